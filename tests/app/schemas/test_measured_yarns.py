"""Yarn by measurement in protocols and files of materials: what is read, and how what is wrong is said."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from app.printing.job import Wanted, print_knit
from app.schemas import ProtocolError, from_yaml, load, loads, to_yaml
from app.schemas.material_files import load_materials
from app.schemas.materials import written
from app.views.labels import friction_value, material_label, yarn_label
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import MeasuredYarn
from rigs.analysis.material_limits import limits_of
from rigs.protocol.made_specimen import make_specimen

EXAMPLES = Path(__file__).parents[3] / "examples"

# Line and column of what the cases below spoil are read off this text.
GOOD = """\
schema: knitlab/protocol@1
rig: biaxial-hook
specimen:
  knit: stockinette-default
  loops: [2, 2]
  loop: 8 mm
  yarn:
    bending: 0.045 N mm^2
    axial: 100 N
    twisting: 35 mN mm^2
    radius: 0.74 mm
    core: 0.325 mm
    compression: {exponent: 2.4, rigidity: 4.8 N/m}
    friction: 0.25
others: hold
steps:
  - zero: {channels: [force]}
"""
LAW = "{exponent: 2.4, rigidity: 4.8 N/m}"
ROWS = "[0.1 mm, 1 N/m], [0.2 mm, 3 N/m], [0.4 mm, 9 N/m], [0.6 mm, 30 N/m]"
PLATES = "compression (mm),force (mN/mm)\n0,0\n0.1,0.07\n0.2,0.38\n0.4,3.8\n0.6,45\n0.7,290\n"


class Bad(NamedTuple):
    """One way to spoil the text: `old` becomes `new`; the error stands at line:column and says so."""

    old: str
    new: str
    line: int
    column: int
    says: str


Y = "specimen.yarn"
BAD = [
    Bad("0.045 N mm^2", "0.045 N mm", 8, 14, f"{Y}.bending: found '0.045 N mm', allowed a stiffness in bending"),
    Bad("0.045 N mm^2", "0 N mm^2", 8, 14, f"{Y}.bending: found 0 N*m**2, allowed a number above 0"),
    Bad(
        "0.045 N mm^2", "45 N mm^2", 8, 14, "found 45 N mm^2, allowed 27.38 N mm^2 or less: half of axial times radius"
    ),
    Bad("35 mN", "35 N", 10, 15, f"{Y}.twisting: found 35 N mm^2, allowed 27.38 N mm^2 or less"),
    Bad("    axial: 100 N\n", "", 8, 5, f"{Y}.axial: found nothing, allowed an axial stiffness"),
    Bad("    axial:", "    axail:", 9, 5, f"{Y}.axail: found an unknown field, allowed bending, axial"),
    Bad("core: 0.325", "core: 0.74", 12, 11, f"{Y}.core: found 0.74 mm, allowed 0.666 mm or less"),
    Bad(
        "radius: 0.74",
        "radius: 4.4",
        11,
        13,
        f"{Y}.radius: found 4.4 mm in loops 8 mm wide, allowed half of that width",
    ),
    Bad("loop: 8 mm", "loop: 0 mm", 6, 9, "specimen.loop: found 0 m, allowed a length from 1 um to 1 m"),
    Bad("2.4", "1.1", 13, 29, f"{Y}.compression.exponent: found 1.1, allowed from 2 to 6"),
    Bad("4.8 N/m", "4.8 N", 13, 44, "found '4.8 N', allowed a force by length with its unit"),
    Bad(", rigidity: 4.8 N/m", "", 13, 18, f"{Y}.compression: found no rigidity, allowed exponent and rigidity"),
    Bad("exponent: 2.4", f"table: [{ROWS}]", 13, 18, "found a table beside exponent or rigidity"),
    Bad(LAW, "{table: [[0.1 mm, 1 N/m]]}", 13, 26, f"{Y}.compression.table: found 1 rows, allowed 4 or more"),
    Bad(
        LAW,
        f"{{table: [{ROWS}, [0.7 mm, 20 N/m]]}}",
        13,
        96,
        "table[4]: found a force of 0.02 N/mm, allowed above 0.03",
    ),
    Bad(LAW, f"{{table: [{ROWS}, [0.5 mm, 40 N/m]]}}", 13, 96, "found a compression of 0.5 mm, allowed above 0.6 mm"),
    Bad(LAW, f"{{table: [{ROWS}, [0.9 mm, 40 N/m]]}}", 13, 96, "and below 0.83 mm, where cores meet"),
    Bad(LAW, "{table: [[0.1 mm]]}", 13, 27, "found nothing, allowed a compression and a force by length"),
    Bad(LAW, "{table: [[0.1, 1 N/m]]}", 13, 28, "found 0.1, allowed a length with its unit"),
    Bad(LAW, "{table: plates.csv}", 13, 26, "found 'plates.csv', allowed points: a text without a file has no table"),
    Bad("0.25", "2.5", 14, 15, f"{Y}.friction: found 2.5, allowed a coefficient from 0 to 2"),
    Bad(
        "  loop: 8 mm",
        "  loop: 8 mm\n  friction: 0.2",
        7,
        13,
        "found 0.2 here and 0.25 in yarn, allowed one of the two",
    ),
    Bad("  loop: 8 mm", "  loop: 8 mm\n  material: IP-Dip", 7, 13, "found IP-Dip beside a yarn by measurement"),
    Bad("  loop: 8 mm", "  loop: 8 mm\n  viscoelastic: on", 7, 17, "of which no relaxation is known"),
    Bad("  loop: 8 mm", "  loop: 8 mm\n  yield: on", 7, 10, "of which no yield curve is known"),
    Bad("  loop: 8 mm", "  loop: 8 mm\n  rupture: stop", 7, 12, "what its fibres bear is not known"),
    Bad(
        "  loop: 8 mm",
        "  loop: 8 mm\n  fused: {gap: 1 mm, patch_radius: 1 mm, strength: 1 MPa}",
        7,
        10,
        "specimen.fused: found fused points, allowed none: measured-yarn is a yarn by measurement",
    ),
    Bad(
        "  loop: 8 mm",
        "  loop: 8 mm\n  rest_shape: straight\n  laid_in: 0.4 mm",
        8,
        12,
        "specimen.laid_in: found 0.4 mm, allowed none: measured-yarn is a yarn by measurement",
    ),
    Bad(
        "  loop: 8 mm", "  loop: 8 mm\n  laid_in: 0.9 mm", 7, 12, "allowed none: measured-yarn is a yarn by measurement"
    ),
    Bad("0.25\n", "0.25\n    fibres: 3\n", 15, 5, f"{Y}.fibres: found an unknown field"),
]


@pytest.mark.parametrize("bad", BAD, ids=[f"{i}: {bad.new[:24]!r}" for i, bad in enumerate(BAD)])
def test_what_is_wrong_is_one_line_with_its_place(bad: Bad) -> None:
    assert bad.old in GOOD
    with pytest.raises(ProtocolError) as raised:
        loads(GOOD.replace(bad.old, bad.new, 1), "p.yaml")
    line = str(raised.value)
    assert line.startswith(f"p.yaml:{bad.line}:{bad.column}: ")
    assert bad.says in line
    assert not raised.value.more


def test_other_mistakes_do_not_hide_a_yarn_nor_invent_a_material() -> None:
    with pytest.raises(ProtocolError) as raised:
        loads(GOOD.replace("hold", "holt").replace("0.325", "0.74"), "p.yaml")
    fields = [one.field for one in (raised.value, *raised.value.more) if isinstance(one, ProtocolError)]
    assert fields == ["specimen.yarn.core", "others"]


def test_without_material_and_yarn_both_are_named() -> None:
    before, rest = GOOD.split("  yarn:\n")
    with pytest.raises(
        ProtocolError, match=r"specimen\.material: found nothing, allowed the name of a material, or a yarn"
    ):
        loads(before + rest[rest.index("others") :])


def test_the_yarn_is_the_specimen_s_and_reads_back() -> None:
    protocol = loads(GOOD).protocol
    spec = protocol.specimen
    yarn = spec.measured
    assert yarn is not None
    assert (yarn.bending.value, yarn.twisting.value) == pytest.approx((4.5e-8, 3.5e-8), rel=1e-12)
    assert spec.friction == 0.25
    assert friction_value(spec).source == "the protocol"
    assert from_yaml(to_yaml(protocol)) == protocol
    specimen = make_specimen(spec)
    assert specimen.radius == pytest.approx(0.74e-3)
    assert limits_of(spec) == ()
    assert "without a Young's modulus" in material_label(spec)
    assert "EI 0.045 N mm²" in yarn_label(spec)


def test_strands_that_the_yarn_makes_overlap_are_refused() -> None:
    # Rows are 0.2458 loop widths apart, turn-arounds between those of a cell's neighbours 0.2303.
    for text, apart in ((GOOD, 0.2458), (GOOD.replace("  yarn:", "  periodic: on\n  yarn:"), 0.2303)):
        made = make_specimen(loads(text).protocol.specimen)
        assert made.clearance == pytest.approx(8e-3 * apart - 1.48e-3, abs=1e-5)
        wide = loads(text.replace("0.74 mm", "1.2 mm")).protocol.specimen
        with pytest.raises(SpecificationError, match="allowed centrelines more than"):
            make_specimen(wide)


@pytest.mark.parametrize(
    ("old", "new", "line", "column", "says"),
    [
        ("0.4,3.8", "0.2,3.8", 5, 1, "found '0.2', allowed more than in the row before"),
        ("0.4,3.8", "0.4,0.1", 5, 5, "found '0.1', allowed more than in the row before"),
        ("0.4,3.8", "0.4,much", 5, 5, "found 'much', allowed a number, in mN/mm"),
        ("0.4,3.8", "0.4", 5, 1, "found 1 columns, allowed two: a compression and a force"),
        ("(mN/mm)", "(mN)", 1, 18, "allowed the name and the unit, such as force (mN/mm)"),
    ],
)
def test_a_table_beside_the_protocol(tmp_path: Path, old: str, new: str, line: int, column: int, says: str) -> None:
    path, table = tmp_path / "p.yaml", tmp_path / "plates.csv"
    path.write_text(GOOD.replace(LAW, "{table: plates.csv}"), encoding="utf-8")
    table.write_text(PLATES, encoding="utf-8")
    loaded = load(path)
    yarn = loaded.protocol.specimen.measured
    assert yarn is not None
    assert yarn.exponent.source.startswith("least squares of relative deviations over 5 rows, missed by ")
    assert from_yaml(loaded.text) == loaded.protocol
    table.write_text(PLATES.replace(old, new), encoding="utf-8")
    with pytest.raises(ProtocolError) as raised:
        load(path)
    assert str(raised.value).startswith(f"{table}:{line}:{column}: ")
    assert says in str(raised.value)
    assert not raised.value.more


def test_a_file_of_materials_gives_every_number_a_source(tmp_path: Path) -> None:
    path = EXAMPLES / "fabric" / "materials" / "acrylic.yaml"
    (yarn,) = load_materials(path).values()
    assert isinstance(yarn, MeasuredYarn)
    guessed = {name for name, value in yarn.numbers() if value.assumed}
    assert guessed == {"axial", "twisting", "exponent", "rigidity", "friction"}
    assert written(yarn)["compression"]["exponent"] == 2.4
    text = path.read_text(encoding="utf-8")
    for old, new, says in (
        ("value: 0.325 mm", "value: 0.8 mm", "core.value: found '0.8 mm', allowed 0.666 mm or less"),
        ("exponent: 2.4", "exponent: 24", "compression.exponent: found 24.0, allowed from 2 to 6"),
        ("radius:", "radios:", "radios: found an unknown field, allowed bending, axial"),
        ("exponent: 2.4", "exponnet: 2.4", "compression.exponnet: found an unknown field, allowed exponent"),
    ):
        assert old in text
        spoilt = tmp_path / "own.yaml"
        spoilt.write_text(text.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(ProtocolError, match=r"own\.yaml:[0-9]+:[0-9]+: materials\.acrylic-worsted") as raised:
            load_materials(spoilt)
        assert says in str(raised.value)


def test_a_material_s_friction_counts_unless_the_specimen_has_its_own() -> None:
    text = (EXAMPLES / "fabric" / "materials" / "acrylic.yaml").read_text(encoding="utf-8")
    before, rest = GOOD.split("  yarn:\n")
    plain = before.replace("specimen:", "materials: own.yaml\nspecimen:\n  material: acrylic-worsted")
    plain += rest[rest.index("others") :]
    spec = loads(plain, materials=text.replace("value: 0.3,", "value: 0.22,")).protocol.specimen
    assert spec.friction == 0.22
    assert friction_value(spec).assumed
    own = loads(plain.replace("  loop: 8", "  friction: 0.4\n  loop: 8"), materials=text).protocol.specimen
    assert own.friction == 0.4


def test_a_filament_of_the_yarn_has_its_diameter() -> None:
    text = GOOD.replace("biaxial-hook", "uniaxial-frame\nmount: C").replace("others: hold", "others: free")
    text = text.replace("[2, 2]", "[1, 1]").replace("8 mm", "50 mm")
    own = loads(text.replace("stockinette-default", "{filament: 1.48 mm}")).protocol.specimen
    assert make_specimen(own).radius == pytest.approx(0.74e-3)
    with pytest.raises(ProtocolError, match=r"found 1 mm, allowed 1\.48 mm, twice the radius of measured-yarn"):
        loads(text.replace("stockinette-default", "{filament: 1 mm}"))


def test_what_needs_a_solid_is_refused_with_the_reason(tmp_path: Path) -> None:
    loaded = loads(GOOD, "p.yaml")
    with pytest.raises(ProtocolError, match=r"p\.yaml:8:5: specimen\.yarn: found measured-yarn, a yarn by"):
        print_knit(loaded, None, tmp_path, Wanted(formats=()), lambda *_: None)  # type: ignore[arg-type]
    with pytest.raises(SpecificationError, match="allowed a solid material"):
        _ = loaded.protocol.specimen.solid

"""Materials that users bring in YAML: what is read, and how what is wrong is said."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

import pytest

from app.runs.provenance import _facts
from app.schemas import ProtocolError
from app.schemas.files_beside import MATERIALS as MATERIALS_FILE
from app.schemas.files_beside import file_beside
from app.schemas.material_files import known_materials, load_materials
from app.schemas.materials import json_schema
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import MATERIALS, Material, material_named

EXAMPLES = Path(__file__).parents[3] / "examples" / "materials"

# Line and column of what the cases below spoil are read off this text.
GOOD = """\
schema: knitlab/materials@1
materials:
  my-resin:
    young_modulus: {value: 2.0 GPa, source: own test}
    poisson_ratio: {value: 0.4, source: guess, assumed: true}
    strength: {value: 40 MPa, source: own test}
    elongation_at_break: {value: 15 %, source: own test}
    density: {value: 1.18 g/cm^3, source: data sheet}
    relaxation:
      terms:
        - {share: 0.2, time: 1.5 min}
      source: own test
    note: a note
"""


class Bad(NamedTuple):
    """One way to spoil the text: `old` becomes `new`; the error stands at line:column and says so."""

    old: str
    new: str
    line: int
    column: int
    says: str


E = "materials.my-resin.young_modulus"
BAD = [
    Bad(
        "    note:", "    colour: red\n    note:", 13, 5, "materials.my-resin.colour: found an unknown field, allowed "
    ),
    Bad("strength:", "strenght:", 6, 5, "(did you mean strength?)"),
    Bad("GPa, source", "GPa, soruce", 4, 37, f"{E}.soruce: found an unknown field, allowed value, source, assumed"),
    Bad("materials:", "material:", 2, 1, "material: found an unknown field, allowed schema, materials"),
    Bad("2.0 GPa", "2.0", 4, 28, f"{E}.value: found 2.0, allowed a stress with its unit, such as 2.0 GPa"),
    Bad("2.0 GPa", "2.0 GN", 4, 28, f"{E}.value: found '2.0 GN', allowed a stress"),
    Bad("2.0 GPa", "-2.0 GPa", 4, 28, f"{E}.value: found -2000000000.0, allowed a number above 0 Pa"),
    Bad(", source: own test}\n    p", "}\n    p", 4, 20, f"{E}.source: found nothing, allowed where the number"),
    Bad("GPa, source: own test", 'GPa, source: " "', 4, 45, f"{E}.source: found ' ', allowed where the number"),
    Bad(
        "{value: 2.0 GPa, source: own test}",
        "2.0 GPa",
        4,
        20,
        f"{E}: found '2.0 GPa', allowed a mapping such as {{value",
    ),
    Bad("value: 0.4", "value: 0.6", 5, 28, "poisson_ratio.value: found 0.6, allowed above -1, at most 0.5"),
    Bad("value: 0.4", "value: high", 5, 28, "found 'high', allowed a pure number, such as 0.37"),
    Bad("assumed: true", "assumed: perhaps", 5, 57, "assumed: found 'perhaps', allowed true for a choice"),
    Bad("1.18 g/cm^3", "1.18 g", 8, 22, "density.value: found '1.18 g', allowed a density with its unit"),
    Bad("share: 0.2", "share: 1.2", 10, 7, "relaxation: found 1.2, allowed shares of less than 1 in all"),
    Bad("share: 0.2", "share: -20 %", 11, 19, "relaxation.terms[0].share: found -0.2, allowed a number above 0"),
    Bad("share: 0.2", "share: a lot", 11, 19, "found 'a lot', allowed a share of the stiffness above 0 and below 1"),
    Bad("1.5 min", "0 s", 11, 30, "relaxation.terms[0].time: found 0.0, allowed a number above 0 s"),
    Bad("time: 1.5 min", "tme: 1.5 min", 11, 24, "terms[0].tme: found an unknown field, allowed share, time"),
    Bad("        - {share: 0.2, time: 1.5 min}\n", "        - 0.2\n", 11, 11, "allowed a mapping of fields: share"),
    Bad("my-resin:", "IP-Dip:", 3, 3, "materials.IP-Dip: found 'IP-Dip', allowed up to 64 letters"),
    Bad("my-resin:", "'../etc':", 3, 3, "found '../etc', allowed up to 64 letters"),
    Bad("materials@1", "materials@9", 1, 9, "schema: found 'knitlab/materials@9', allowed knitlab/materials@1"),
    Bad("schema: knitlab/materials@1\n", "", 1, 1, "schema: found nothing, allowed knitlab/materials@1"),
    Bad("    note: a note", "  my-resin: {}", 13, 3, "found the same key again"),
    Bad("    note: a note", "\tnote: a note", 13, 1, "materials: found text that is not YAML"),
    Bad("    poisson_ratio: {value: 0.4, source: guess, assumed: true}\n", "", 4, 5, "poisson_ratio: found nothing"),
]


def written(folder: Path, text: str) -> Path:
    path = folder / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_number_is_read_in_si_with_its_source(tmp_path: Path) -> None:
    (material,) = load_materials(written(tmp_path, GOOD)).values()
    assert isinstance(material, Material)
    assert material.name == "my-resin"
    assert (material.young_modulus.value, material.young_modulus.unit) == (2e9, "Pa")
    assert not material.young_modulus.assumed
    assert material.poisson_ratio.assumed
    assert material.strength is not None
    assert material.strength.value == 40e6
    assert material.breaking_strain == material.elongation_at_break
    assert material.density is not None
    assert math.isclose(material.density.value, 1180.0)
    (term,) = material.relaxation
    assert (term.share.value, term.time.value, term.time.unit) == (0.2, 90.0, "s")
    assert term.time.source == "own test"
    assert material.note == "a note"


@pytest.mark.parametrize("bad", BAD, ids=[f"{i}: {bad.new[:24]!r}" for i, bad in enumerate(BAD)])
def test_what_is_wrong_is_one_line_with_its_place(tmp_path: Path, bad: Bad) -> None:
    assert bad.old in GOOD
    path = written(tmp_path, GOOD.replace(bad.old, bad.new, 1))
    with pytest.raises(ProtocolError) as raised:
        load_materials(path)
    line = str(raised.value)
    assert line.startswith(f"{path}:{bad.line}:{bad.column}: ")
    assert bad.says in line
    assert "\n" not in line


@pytest.mark.parametrize("text", ["", "[1, 2]", "schema: knitlab/materials@1\nmaterials: {}\n"])
def test_a_file_without_materials_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(ProtocolError, match="allowed a mapping"):
        load_materials(written(tmp_path, text))


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ProtocolError, match=r"none\.yaml:1:1: materials: found no such file or directory"):
        load_materials(tmp_path / "none.yaml")


def test_own_materials_join_the_catalogue(tmp_path: Path) -> None:
    known = known_materials(written(tmp_path, GOOD))
    assert set(known) == {*MATERIALS, "my-resin"}
    mine = material_named("my-resin", known=known)
    assert isinstance(mine, Material)
    assert mine.young_modulus.value == 2e9
    with pytest.raises(SpecificationError, match=r"did you mean my-resin\?"):
        material_named("my-rasin", known=known)
    with pytest.raises(SpecificationError):
        material_named("my-resin")
    assert known_materials() is MATERIALS


@pytest.mark.parametrize(
    "name",
    ["/etc/own.yaml", "../own.yaml", "a/../../own.yaml", "own.txt", "own", "c:own.yaml", "a\\own.yaml", "\0.yaml"],
)
def test_a_protocol_reaches_no_file_outside_its_folder(tmp_path: Path, name: str) -> None:
    with pytest.raises(SpecificationError, match="materials: found "):
        file_beside(tmp_path / "p.yaml", name, MATERIALS_FILE)


def test_a_link_does_not_lead_out_either(tmp_path: Path) -> None:
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    inside.mkdir()
    outside.mkdir()
    (inside / "link").symlink_to(outside)
    with pytest.raises(SpecificationError, match="below it"):
        file_beside(inside / "p.yaml", "link/own.yaml", MATERIALS_FILE)
    assert file_beside(inside / "p.yaml", "deeper/own.yaml", MATERIALS_FILE) == inside / "deeper" / "own.yaml"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_examples_are_read_and_own_up_to_what_they_assume(path: Path) -> None:
    for material in load_materials(path).values():
        assert isinstance(material, Material)
        assert material.breaking_strain is not None
        assert all(term.share.assumed and term.time.assumed for term in material.relaxation)


def test_the_published_schema_asks_for_sources() -> None:
    schema = json_schema()
    assert schema["required"] == ["schema", "materials"]
    for name in ("StressValue", "DensityValue", "StrainValue", "NumberValue", "RelaxationModel"):
        assert "source" in schema["$defs"][name]["required"]
    assert json.loads(json.dumps(schema)) == schema


def test_the_record_names_every_term_and_its_source(tmp_path: Path) -> None:
    (material,) = load_materials(written(tmp_path, GOOD)).values()
    facts = dict(_facts("material", material))
    assert facts["material.relaxation[0].time"] == 90.0
    assert facts["material.relaxation[0].share.source"] == "1; own test"
    assert facts["material.poisson_ratio.source"] == "1; guess; assumed"

"""A knit of the user's own centreline, from CSV to forces."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas import ProtocolError, from_yaml, load, loads, to_yaml
from knitlab_core.equilibrium.march import march
from knitlab_core.knits import NAMED_STITCHES, Counts, knit_specimen
from rigs.machines.rig import pose, read
from rigs.protocol.protocol import Cycle, Zero

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from knitlab_core.knits import Fabric

STITCH = NAMED_STITCHES["stockinette-default"]
STEPS = (Zero(), Cycle(axes=("C", "W"), lower=0.0, upper=0.26, rate=2e-4, n=1))
PROTOCOL = """schema: knitlab/protocol@1
rig: biaxial-hook
specimen:
  knit: {centreline: own/knit.csv, fibre_radius: 0.4 mm}
  loops: [2, 2]
  loop: 8 mm
  material: RGD8530-DM
  nodes_per_loop: 15
others: hold
steps:
  - cycle: {axes: [C, W], lower: 0, upper: 5 %, rate: 0.2 mm/s, n: 1}
"""


@cache
def csv_text(per_edge: int = 8) -> str:
    """Return a stockinette of 2x2 loops as CSV in millimetres, its nodes and sites among the points."""
    knit = knit_specimen(STITCH, rows=2, loops=2, loop_width=1.0, nodes_per_loop=14)
    along = knit.arc_lengths
    arcs = np.append(np.linspace(along[:-1], along[1:], per_edge, endpoint=False).T.ravel(), along[-1])
    named = {int(np.abs(arcs - site.arc_length).argmin()): site.set for site in knit.centreline.sites}
    points = 8.0 * knit.centreline.position(arcs)
    rows = [f"{x:.12g},{y:.12g},{z:.12g},{named.get(k, '')}" for k, (x, y, z) in enumerate(points)]
    return "\n".join(["x [mm], y [mm], z [mm], site", *rows, ""])


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """Return a protocol whose knit stands in a CSV file in a folder beside it."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "knit.csv").write_text(csv_text(), encoding="utf-8")
    (tmp_path / "p.yaml").write_text(PROTOCOL, encoding="utf-8")
    return tmp_path / "p.yaml"


def forces(mount_knit: Callable[..., tuple], knit: Fabric, nodes: int, strain: float) -> list[float]:  # type: ignore[type-arg]
    """Return the forces of both axes at a strain along both [N]."""
    stage, state, _ = mount_knit(*STEPS, knit=knit, nodes=nodes)
    goal = {axis: strain * length for axis, length in stage.gauges.items()}
    path = march(
        stage.work, state, lambda share: pose(stage, {axis: share * way for axis, way in goal.items()}), longest=0.1
    )
    *_, (_, state, _) = path
    return [read(stage, state).force[axis] for axis in ("C", "W")]


def test_a_stockinette_read_from_csv_pulls_as_the_stockinette(
    written: Path,
    mount_knit: Callable[..., tuple],  # type: ignore[type-arg]
) -> None:
    (written.parent / "own" / "knit.csv").write_text(csv_text(60), encoding="utf-8")
    read_back = load(written).protocol.specimen.fabric
    wanted, found = forces(mount_knit, STITCH, 14, 0.1), forces(mount_knit, read_back, 15, 0.1)
    assert min(wanted) > 1e-3
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


def test_its_protocol_says_itself_again_without_the_file(written: Path) -> None:
    loaded = load(written)
    assert loads(loaded.text).protocol.specimen.fabric == loaded.protocol.specimen.fabric
    assert from_yaml(to_yaml(loaded.protocol)) == loaded.protocol
    chosen = PROTOCOL.replace("loops: [2, 2]", "loops: [2, 2]\n  friction: ${mu}") + "params: {mu: 0.3}\n"
    written.write_text(chosen, encoding="utf-8")
    assert loads(load(written, {"mu": 0.2}).text).protocol.specimen.friction == 0.2


BAD = (
    ("x [mm], y", "x, y", "knit.csv:1:1: x: found no unit, allowed a unit of length, such as x [mm]"),
    ("y [mm]", "y [N]", "knit.csv:1:1: y: found the unit 'N', allowed a unit of length"),
    ("site", "sites", "knit.csv:1:1: header: found 'sites' as a column (did you mean site?)"),
    ("z [mm], ", "", "knit.csv:1:1: header: found no column z"),
    ("-4,", "left,", "knit.csv:2:1: x: found 'left', allowed a number"),
    ("-4,-6.4,2,", "-4,-6.4,", "knit.csv:2:1: centreline: found 3 values, allowed 4"),
    (",course-", ",cours-", "knit.csv:2:1: site: found 'cours-', allowed wale+"),
    (",course-", ",", "p.yaml:4:22: specimen.knit.centreline: found no site course-, allowed sites on opposite faces"),
    ("-4,", "nan,", "knit.csv:2:1: x: found 'nan', allowed a number"),
    ("-4,", "-4e9,", "p.yaml:4:22: specimen.knit.centreline: found point 1 at"),
)


@pytest.mark.parametrize(("text", "instead", "message"), BAD)
def test_a_mistake_in_the_csv_is_one_line_with_its_place(written: Path, text: str, instead: str, message: str) -> None:
    file = written.parent / "own" / "knit.csv"
    whole = csv_text()
    file.write_text(whole.replace(text, instead, whole.count(text) if instead == "," else 1), encoding="utf-8")
    with pytest.raises(ProtocolError) as caught:
        load(written)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_second_strand_is_refused_by_its_line(written: Path) -> None:
    lines = csv_text().splitlines()
    text = "\n".join([f"{lines[0]}, strand", *(f"{line},{k // 99}" for k, line in enumerate(lines[1:]))])
    (written.parent / "own" / "knit.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ProtocolError, match=r"knit.csv:101:1: strand: found a second strand, '1', allowed one"):
        load(written)


@pytest.mark.parametrize("name", ["/etc/knit.csv", "../knit.csv", "own/knit.txt", "own/none.csv"])
def test_a_file_elsewhere_or_of_another_kind_is_refused(written: Path, name: str) -> None:
    written.write_text(PROTOCOL.replace("own/knit.csv", name), encoding="utf-8")
    with pytest.raises(ProtocolError, match=r"\.csv"):
        load(written)


def test_another_mistake_is_not_taken_for_one_of_the_centreline(written: Path) -> None:
    written.write_text(PROTOCOL.replace("others: hold", "others: helf").replace("8 mm", "-8 mm"), encoding="utf-8")
    with pytest.raises(ProtocolError) as caught:
        load(written)
    assert [one.field for one in (caught.value, *caught.value.more)] == ["specimen.loop", "others"]
    written.write_text(PROTOCOL.replace("own/knit", "own/none"), encoding="utf-8")
    with pytest.raises(ProtocolError, match=r"none.csv:1:1: centreline: found no such file") as caught:
        load(written)
    assert not caught.value.more


def test_a_file_that_is_too_large_is_not_read(written: Path) -> None:
    with (written.parent / "own" / "knit.csv").open("ab") as file:
        file.truncate(1 << 40)  # a hole: it takes no room on the disk
    with pytest.raises(ProtocolError, match="1000000 bytes or fewer"):
        load(written)


def test_a_text_without_a_file_has_no_centreline_beside_it() -> None:
    with pytest.raises(ProtocolError, match=r"knit.csv, allowed CSV text"):
        loads(PROTOCOL)


def test_csv_text_may_stand_in_the_protocol_with_one_unit_for_all() -> None:
    lines = csv_text().replace(" [mm]", "").splitlines()
    block = "".join(f"\n      {line}" for line in lines)
    values = f"\n    unit: mm\n    fibre_radius: 0.4 mm\n    centreline: |{block}"
    text = PROTOCOL.replace(" {centreline: own/knit.csv, fibre_radius: 0.4 mm}", values)
    assert len(loads(text).protocol.specimen.fabric.centreline(Counts(2, 2)).sites) == 12
    wrong = text.replace("-4,-6.4,2,", "-4,-6.4,two,", 1)
    line = wrong[: wrong.index("two")].count("\n") + 1
    with pytest.raises(ProtocolError, match=rf"^<protocol>:{line}:1: z: found 'two', allowed a number"):
        loads(wrong)

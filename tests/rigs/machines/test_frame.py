from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.checks.dry_run import dry_run, fitted_machines
from app.records.reader import RunReader
from app.runs.provenance import provenance
from app.runs.use_cases import run_protocol
from app.schemas import ProtocolError, loads, to_yaml
from knitlab_core.equilibrium.march import march
from knitlab_core.rods.relaxation import rod_strains
from rigs.analysis.stress_strain import stress_strain
from rigs.axes import COORDINATE
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.machines.rig import pose, read
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle, Preload
from rigs.record import Equilibrium, Outcome

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol

    Mount = Callable[..., tuple[Rig, State, Protocol]]

# The solver leaves 1e-4 of the mean force of a held unknown at a free one; over the knit these add up.
BALANCE = 1e-3


def states(rig: Rig, state: State, *strains: float) -> list[State]:
    """Return the states at some strains, one after the other, and first the one as mounted."""
    found = [state]
    (axis,) = rig.grips
    for low, high in pairwise([0.0, *strains]):
        way = [part * rig.gauges[axis] for part in (low, high - low)]

        def target(share: float, way: list[float] = way) -> np.ndarray:
            return pose(rig, {axis: way[0] + share * way[1]})

        *_, (_, last, _) = march(rig.work, found[-1], target, longest=0.1)
        found.append(last)
    return found


def cycle(axis: Axis, upper: float = 0.1) -> Cycle:
    return Cycle(axes=(axis,), lower=0.0, upper=upper, rate=2e-4, n=1)


@pytest.fixture(scope="module")
def course(request: pytest.FixtureRequest) -> tuple[Rig, list[State]]:
    """Return a 3x3 knit pulled along its courses to 20 and 35 %."""
    rig, state, _ = request.getfixturevalue("mount_knit")(cycle("C"), rows=3, loops=3, mount_along="C")
    return rig, states(rig, state, 0.2, 0.35)


def extent(rig: Rig, state: State, axis: Axis) -> float:
    """Return the distance of the sites on either side along an axis [r]."""
    name = {"C": "course", "W": "wale", "P": "pile"}[axis]
    x, sites = state.q[:, COORDINATE[axis]], rig.specimen.sites
    return float(x[sites[f"{name}+"]].mean() - x[sites[f"{name}-"]].mean())  # type: ignore[index]


def test_the_lower_clamp_stands_and_the_crosshead_makes_the_whole_way(course: tuple[Rig, list[State]]) -> None:
    rig, _ = course
    moved = (pose(rig, {"C": 3e-3}) - rig.mounted)[:, :3] * rig.work.model.scales.length
    lower, upper = rig.grips["C"]
    assert np.all(moved[lower.nodes] == 0.0)
    assert moved[upper.nodes] == pytest.approx(np.tile([3e-3, 0.0, 0.0], (len(upper.nodes), 1)), abs=1e-15)


def test_hooks_hold_two_edges_and_one_of_them_its_place_on_the_pole(course: tuple[Rig, list[State]]) -> None:
    rig, _ = course
    fixed, sites = rig.work.model.fixed, rig.specimen.sites
    held = np.concatenate([sites["course-"], sites["course+"]])
    assert np.all(fixed[held][:, [0, 2]])
    assert np.flatnonzero(fixed[:, 1]).tolist() == rig.grips["C"][0].anchored.tolist()
    # Two unknowns a hook, the anchor's third, and the dummy angle of the last node; the sides hang on nothing.
    assert fixed.sum() == 2 * len(held) + 2


def test_forces_above_and_below_balance(course: tuple[Rig, list[State]]) -> None:
    rig, (_, _, pulled) = course
    reading = read(rig, pulled)
    assert reading.force["C"] > 0.02
    assert abs(reading.imbalance["C"]) <= BALANCE * reading.force["C"]


def test_the_load_cell_hangs_above(course: tuple[Rig, list[State]]) -> None:
    rig, (_, _, pulled) = course
    upper = rig.grips["C"][1].nodes
    felt = pulled.reaction[upper, 0].sum() * rig.work.model.scales.force
    assert read(rig, pulled).force["C"] == felt


def test_the_anchor_keeps_the_knit_in_place_without_a_force(course: tuple[Rig, list[State]]) -> None:
    rig, (_, _, pulled) = course
    reading = read(rig, pulled)
    assert 0.0 <= reading.lateral <= BALANCE * reading.force["C"]


def test_a_taut_knit_gets_narrower_and_its_yarn_hardly_longer(course: tuple[Rig, list[State]]) -> None:
    # Before 20 % its loops open first: nothing yet draws the sides in.
    rig, (start, taut, pulled) = course
    assert extent(rig, pulled, "W") < 0.99 * extent(rig, taut, "W")
    rods = rig.work.model.rods
    # Along the spline: the polygon of the nodes gets shorter where a yarn straightens.
    stretch = [rods.stretched @ rod_strains(state.q, rods, state.frames)[:, 0] for state in (start, pulled)]
    assert stretch[0] == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < stretch[1] / rods.stretched.sum() < 1e-3


@pytest.mark.parametrize("axis", ["C", "W", "P"])
def test_a_volumetric_knit_hangs_by_any_two_faces(
    axis: Axis, mount_knit: Callable[..., tuple[Rig, State, object]]
) -> None:
    rig, state, _ = mount_knit(cycle(axis), rows=2, loops=1, layers=2, mount_along=axis)
    pole = 1 if axis == "C" else 0
    for grip in rig.grips[axis]:
        # Four rows end on a course face; a wale or pile face has two loops, each on two hooks.
        assert len(grip.nodes) == 4
        assert (grip.pole, grip.held) == (pole, tuple(k not in {pole, 3} for k in range(4)))
    assert rig.size.convention == "specimen"
    across = [rig.size.extents[other] for other in ("C", "W", "P") if other != axis]
    assert rig.size.section(axis) == across[0] * across[1]
    (_, pulled) = states(rig, state, 0.12)
    reading = read(rig, pulled)
    assert extent(rig, pulled, axis) == pytest.approx(1.12 * extent(rig, state, axis), rel=0.02)
    assert abs(reading.imbalance[axis]) <= BALANCE * max(reading.force[axis], 1e-3)


def test_a_preload_and_rows_name_the_one_axis(mount_knit: Mount) -> None:
    rig, state, protocol = mount_knit(Preload(axes=("W",), force=0.02, rate=2e-4), mount_along="W", increment=0.05)
    events = list(perform(rig, state, protocol))
    rows = [event for event in events if isinstance(event, Equilibrium)]
    assert events[-1] == Outcome(end="target")
    assert {tuple(row.force) for row in rows} == {("W",)}
    assert rows[-1].force["W"] == pytest.approx(0.02, rel=5e-3)
    assert set(rows[0].numbers()) >= {"displacement_W", "force_W"}


CHOSEN = """\
schema: knitlab/protocol@1
rig: uniaxial-frame
mount: C
load_cell: 2 kN
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 24}
speed_ref: pair
others: free
steps:
  - ramp: {axes: [C], to: {strain: 0.1}, rate: 0.2 mm/s}
"""


def test_a_protocol_chooses_the_load_cell() -> None:
    loaded = loads(CHOSEN)
    protocol = loaded.protocol
    assert protocol.load_cell == 2000.0
    assert loads(to_yaml(protocol)).protocol.load_cell == 2000.0
    data = fitted_machines(loaded)
    (instrument,) = mount(make_specimen(protocol.specimen), protocol, data)[0].instruments
    assert {channel.kind: channel.limit for channel in instrument.channels}["force"] == 2000.0
    facts = provenance(protocol, data)
    assert (facts["rig.load_cell.limit"], facts["rig.load_cell.noise"]) == (2000.0, 0.02)
    assert not any("other_cells" in name for name in facts)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("2 kN", "3 kN", "p.yaml:4:12: load_cell: found 3000 N, allowed one of 500 N, 1000 N, 2000 N"),
        (
            "rig: uniaxial-frame\nmount: C\nload_cell: 2 kN\n",
            "rig: biaxial-hook\nload_cell: 2 kN\n",
            "p.yaml:3:12: load_cell: found 2000 N, allowed none: biaxial-hook has load cells of its own",
        ),
    ],
)
def test_a_load_cell_that_is_not_there_is_one_line(old: str, new: str, says: str) -> None:
    text = CHOSEN.replace(old, new)
    if "biaxial" in new:
        text = text.replace("others: free", "others: hold")
    with pytest.raises(ProtocolError) as error:
        dry_run(loads(text, "p.yaml"))
    assert str(error.value) == says


def test_the_frame_writes_its_log(tmp_path: Path) -> None:
    protocol = tmp_path / "p.yaml"
    protocol.write_text(
        """
schema: knitlab/protocol@1
name: tiny
rig: uniaxial-frame
mount: C
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 24}
speed_ref: pair
others: free
log: {rate: 5 Hz, noise: off}
max_strain_increment: 0.02
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C], lower: 0, upper: 0.1, rate: 0.2 mm/s, n: 1}
""",
        encoding="utf-8",
    )
    result = run_protocol(protocol, tmp_path / "run", lambda _share, _text: None)
    assert (result.outcome, result.message) == ("target", "")
    written = (result.folder / "tiny.is_tcyclic_Exports" / "tiny_1.csv").read_bytes()
    assert written.startswith(b"Time,Displacement,Force\r\n(s),(mm),(N)\r\n0,0,0\r\n0.2,0.04,")
    table = np.array([line.split(b",") for line in written.split(b"\r\n")[2:-1]], dtype=float)
    # 10 % of 16 mm at 0.2 mm/s, twice, at 5 Hz, and the first sample.
    assert table[:, 0] == pytest.approx(np.arange(81) / 5)
    assert table[:, 1] == pytest.approx(1.6 * (1 - np.abs(np.linspace(-1, 1, 81))), abs=1e-4)
    run = RunReader(result.folder / "run.h5")
    assert list(run.samples) == ["uniaxial-frame"]
    assert run.trace.axes == ("C",)
    assert (run.provenance["mount"], run.provenance["rig.load_cell.limit"]) == ("C", 500.0)
    strain, stress = stress_strain(table[:, 1] / 1e3, table[:, 2], "C", run.size)
    assert strain.max() == pytest.approx(0.1)
    assert stress.max() == pytest.approx(table[:, 2].max() / (run.size.extents["W"] * 1e-3))

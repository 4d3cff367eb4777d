from __future__ import annotations

import csv
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.runs.use_cases import run_protocol
from knitlab_core.equilibrium.march import march
from rigs.axes import COORDINATE, SITES
from rigs.machines.rig import most_strained, place_of, pose, read
from rigs.machines.shape import axial_strain, bending_strain, contact_force
from rigs.protocol.protocol import Cycle, Zero
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from pathlib import Path

    from knitlab_core.equilibrium.model import State
    from rigs.machines.rig import Rig

STEPS = (Zero(), Cycle(axes=("C", "W"), lower=0.0, upper=0.26, rate=2e-4, n=1))
# The solver leaves 1e-4 of the mean force of a held unknown at a free one; over the knit these add up.
BALANCE = 1e-3


def stretched(stage: Rig, state: State, strain: float) -> State:
    goal = {axis: strain * length for axis, length in stage.gauges.items()}
    path = march(
        stage.work,
        state,
        lambda share: pose(stage, {axis: share * way for axis, way in goal.items()}),
        longest=0.1,
    )
    for _, found, _ in path:
        state = found
    return state


@pytest.fixture(scope="module")
def small(request: pytest.FixtureRequest) -> tuple[Rig, State]:
    """Return a 3x3 knit, taut at 30 %."""
    make = request.getfixturevalue("mount_knit")
    stage, state, _ = make(*STEPS, rows=3, loops=3)
    return stage, stretched(stage, state, 0.30)


def test_only_what_the_hooks_hold_is_prescribed(small: tuple[Rig, State]) -> None:
    stage, _ = small
    fixed = stage.work.model.fixed
    sites = stage.specimen.sites
    course = np.concatenate([sites["course+"], sites["course-"]])
    wale = np.concatenate([sites["wale+"], sites["wale-"]])
    assert fixed[course].tolist() == [[True, False, True, angle] for angle in fixed[course, 3]]
    assert fixed[wale].tolist() == [[False, True, True, False]] * len(wale)
    # The last node has no edge, so its angle is no unknown.
    assert fixed.sum() == 2 * (len(course) + len(wale)) + 1


def test_every_boundary_loop_hangs_on_two_hooks(small: tuple[Rig, State]) -> None:
    stage, _ = small
    rows, loops = stage.specimen.rows, stage.specimen.loops
    assert [len(grip.nodes) for grip in stage.grips["C"]] == [rows, rows]
    assert [len(grip.nodes) for grip in stage.grips["W"]] == [2 * loops, 2 * loops]


def test_carriages_move_symmetrically_about_the_centre(small: tuple[Rig, State]) -> None:
    stage, _ = small
    target = pose(stage, {"C": 3e-3, "W": 1e-3}) - stage.mounted
    moved = target[:, :3] * stage.work.model.scales.length
    for axis, travel in (("C", 3e-3), ("W", 1e-3)):
        for sites, side in zip(SITES[axis], (-1, 1), strict=True):  # type: ignore[index]
            ways = moved[stage.specimen.sites[sites]]
            expected = np.zeros(3)
            expected[COORDINATE[axis]] = side * travel / 2  # type: ignore[index]
            assert ways == pytest.approx(np.tile(expected, (len(ways), 1)), abs=1e-15)


def test_opposite_carriages_feel_the_same_pull(small: tuple[Rig, State]) -> None:
    reading = read(*small)
    for axis in BOTH:
        assert reading.force[axis] > 0.1
        assert abs(reading.imbalance[axis]) <= BALANCE * reading.force[axis]


def test_fixtures_and_yarn_push_each_other_out_of_plane_with_no_net_force(small: tuple[Rig, State]) -> None:
    stage, state = small
    total = abs(state.reaction[:, 2].sum()) * stage.work.model.scales.force
    assert total <= BALANCE * max(read(stage, state).force.values())


def test_hooks_slide_along_their_pole_and_feel_nothing_there(small: tuple[Rig, State]) -> None:
    stage, state = small
    moved = state.q - stage.mounted
    for axis in BOTH:
        for grip in stage.grips[axis]:
            along = np.abs(moved[grip.nodes, 1 - COORDINATE[axis]]).max()
            assert along * stage.work.model.scales.length > 0.5e-3
    assert read(stage, state).lateral == 0.0


def test_the_yarn_is_stretched_where_the_knit_is_taut(small: tuple[Rig, State]) -> None:
    stage, state = small
    strain = axial_strain(stage, state)
    assert strain.shape == (len(stage.specimen.nodes) - 1,)
    assert 1e-4 < strain.max() < 0.05


def test_a_fibre_is_strained_most_by_its_axial_strain_and_its_bending(small: tuple[Rig, State]) -> None:
    stage, state = small
    total = np.abs(axial_strain(stage, state)) + bending_strain(stage, state)
    spot = most_strained(stage, state)
    assert (int(total.argmax()), total.max()) == (spot.edge, pytest.approx(spot.strain))


def test_yarn_is_pressed_where_strands_touch_and_nowhere_else(small: tuple[Rig, State]) -> None:
    stage, state = small
    pressed = contact_force(stage, state)
    nodes, radius = state.q[:, :3] * stage.work.model.scales.length, stage.size.fibre_radius
    apart = np.linalg.norm(nodes[:, None] - nodes[None], axis=2)
    order = np.arange(len(nodes))
    apart[np.abs(order[:, None] - order) < 8] = np.inf
    nearest = apart.min(axis=1)
    spacing = np.linalg.norm(np.diff(nodes, axis=0), axis=1).max()
    assert 0 < np.count_nonzero(pressed) < 0.7 * len(pressed)
    assert nearest[pressed > 0.0].max() < np.hypot(2 * radius, spacing)
    assert (pressed[nearest > np.hypot(2 * radius, spacing)] == 0.0).all()
    # A loop that carries a course's share of the pull is pressed about as hard by the loops it holds.
    assert 0.2 < pressed.max() / (read(stage, state).force["W"] / 6) < 5.0


def test_a_node_has_a_place_in_the_words_of_a_knitter(small: tuple[Rig, State]) -> None:
    stage, _ = small
    sites = stage.specimen.sites
    assert place_of(stage, int(sites["wale-"][0])) == "row 0, loop 0"
    assert place_of(stage, int(sites["wale+"][-1])) == "row 2, loop 2"


def test_the_stage_writes_its_log(tmp_path: Path) -> None:
    protocol = tmp_path / "p.yaml"
    protocol.write_text(
        """
schema: knitlab/protocol@1
name: tiny
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 24}
speed_ref: pair
others: hold
log: {rate: 5 Hz, noise: off}
max_strain_increment: 0.02
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C], lower: 0, upper: 0.1, rate: 0.2 mm/s, n: 1, tag: up}
""",
        encoding="utf-8",
    )
    result = run_protocol(protocol, tmp_path / "run", lambda _share, _text: None)
    assert (result.outcome, result.message) == ("target", "")
    raw = (result.folder / "tiny.csv").read_bytes()
    assert raw.startswith(
        b"SetName,Cycle,Time_S,Temperature,XSize_um,YSize_um,XDisplacement_um,YDisplacement_um,XForce_mN,YForce_mN\r\n"
    )
    rows = list(csv.DictReader(raw.decode().splitlines()))
    # 10 % of 16 mm at 0.2 mm/s, twice, at 5 Hz, and the first sample.
    assert len(rows) == 2 * 8 * 5 + 1
    assert {row["Cycle"] for row in rows} == {"1-Preload", "1-Stretch", "1-Recover"}
    size, strain = float(rows[0]["XSize_um"]), np.array([float(row["XDisplacement_um"]) for row in rows])
    assert size == pytest.approx(16e3)
    assert strain / size == pytest.approx(0.1 * (1 - np.abs(np.linspace(-1, 1, 81))), abs=1e-4)
    assert float(rows[40]["XForce_mN"]) > 1.0
    assert {path.name for path in result.folder.iterdir()} == {
        "run.h5",
        "tiny.csv",
        "tiny_knit.png",
        "tiny_stress_strain.png",
    }

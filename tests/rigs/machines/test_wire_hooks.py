from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas.machine_data import read_machine
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.hook_friction import pole_forces
from knitlab_core.equilibrium.march import march
from knitlab_core.errors import SpecificationError
from rigs.axes import COORDINATE
from rigs.machines.rig import pose, read
from rigs.machines.shape import axial_strain, bending_strain, contact_force, wire_ends
from rigs.protocol.protocol import Cycle, Zero
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State
    from rigs.machines.rig import Rig

    Mounted = tuple[Rig, State]

STEPS = (Zero(), Cycle(axes=("C", "W"), lower=0.0, upper=0.3, rate=2e-4, n=1))
BALANCE = 1e-3
POLE = 0.1


def stretched(stage: Rig, state: State, strains: list[float]) -> list[State]:
    """Stretch both axes alike to one strain after the other."""
    found = []
    for before, after in zip([0.0, *strains], strains, strict=False):

        def path(share: float, begin: float = before, end: float = after) -> FloatArray:
            strain = begin + (end - begin) * share
            return pose(stage, {axis: strain * length for axis, length in stage.gauges.items()})

        way = march(
            stage.work,
            state,
            path,
            longest=0.02 / abs(after - before),
        )
        *_, (_, state, _) = way
        found.append(state)
    return found


@pytest.fixture(scope="module")
def mounted(request: pytest.FixtureRequest) -> Mounted:
    stage, state, _ = request.getfixturevalue("mount_knit")(*STEPS, hook="wire")
    return stage, state


@pytest.fixture(scope="module")
def hung(mounted: Mounted) -> Mounted:
    """Return a 2x2 knit on wires, taut at 34 %."""
    stage, state = mounted
    return stage, stretched(stage, state, [0.34])[-1]


@pytest.fixture(scope="module")
def rubbed(request: pytest.FixtureRequest) -> tuple[Rig, list[State]]:
    """Return a 2x2 knit on wires whose poles rub, at 20, 34 and, on the way back, 20 %."""
    stage, state, _ = request.getfixturevalue("mount_knit")(*STEPS, hook="wire", pole_friction=POLE)
    return stage, stretched(stage, state, [0.2, 0.34, 0.2])


def total(stage: Rig, state: State) -> FloatArray:
    """Return the sum of all forces on yarn and wires from outside [E r^2]: of carriages and of poles."""
    out: FloatArray = state.reaction[:, :3].sum(axis=0)
    hooks = stage.work.model.hooks
    assert hooks is not None
    np.add.at(out, hooks.pole, -pole_forces(hooks, state.poles, stage.work.model.law.slip))
    return out


def test_pins_on_poles_that_do_not_rub_are_what_they_were(mount_knit: Callable[..., tuple[Rig, State, object]]) -> None:
    stage, _, _ = mount_knit(*STEPS)
    assert stage.work.model.hooks is None
    assert len(stage.work.model.fixed) == len(stage.specimen.nodes)


def test_what_hangs_in_no_loop_stays_a_pin(mounted: Mounted) -> None:
    stage, _ = mounted
    specimen = stage.specimen
    pins = {(axis, grip.side): grip.nodes.tolist() for axis, pair in stage.grips.items() for grip in pair}
    first, last = 0, len(specimen.nodes) - 1
    # Two rows: the yarn begins and ends on the left; its first half sinker is open.
    assert pins == {("C", -1): [first, last], ("C", 1): [], ("W", -1): [specimen.sites["wale-"][0]], ("W", 1): []}
    wires = {(axis, grip.side): len(grip.wires) for axis, pair in stage.grips.items() for grip in pair}
    assert wires == {("C", -1): 0, ("C", 1): 1, ("W", -1): 2, ("W", 1): 2}


def test_a_knit_is_mounted_without_stress(mounted: Mounted, hung: Mounted) -> None:
    stage, state = mounted
    found, _ = advance(stage.work, state, pose(stage, dict.fromkeys(stage.grips, 0.0)))
    assert found is not None
    # On so coarse a mesh the yarn lies a little beside its line, by part of the gap.
    assert max(read(stage, found).force.values()) < 1e-3 * max(read(*hung).force.values())


def test_wires_stay_straight_and_side_by_side(hung: Mounted) -> None:
    stage, state = hung
    moved = state.q - stage.mounted
    for axis, pair in stage.grips.items():
        for grip in pair:
            for wire in grip.wires:
                # Tied along the pole; elsewhere held.
                assert np.ptp(moved[wire, grip.pole]) < 1e-3
                assert np.ptp(moved[wire][:, [COORDINATE[axis], 2, 3]], axis=0).max() == 0.0


def test_the_yarn_stays_on_its_wires(hung: Mounted) -> None:
    stage, state = hung
    unit = stage.work.model.scales.length
    nodes = state.q[: len(stage.specimen.nodes), :3]
    places = np.arange(0.0, len(nodes) - 1.0, 0.05)
    yarn = np.column_stack([np.interp(places, np.arange(len(nodes)), nodes[:, c]) for c in range(3)])
    for low, high in wire_ends(stage, state) / unit:
        near = yarn[np.linalg.norm(yarn[:, :2] - low[:2], axis=1) < 3.0]
        assert len(near) > 0
        assert low[2] + 3.0 < near[:, 2].min() <= near[:, 2].max() < high[2] - 3.0


def test_opposite_carriages_feel_the_same_pull(hung: Mounted) -> None:
    reading = read(*hung)
    for axis in BOTH:
        assert reading.force[axis] > 0.1
        assert abs(reading.imbalance[axis]) <= BALANCE * reading.force[axis]
    assert reading.lateral == 0.0


def test_action_is_reaction(hung: Mounted, rubbed: tuple[Rig, list[State]]) -> None:
    stage, states = rubbed
    for rig, state in (hung, *((stage, state) for state in states)):
        largest = max(read(rig, state).force.values()) / rig.work.model.scales.force
        assert np.abs(total(rig, state)).max() <= BALANCE * largest


def test_a_frame_shows_yarn_and_wires_apart(hung: Mounted) -> None:
    stage, state = hung
    nodes, wires = len(stage.specimen.nodes), wire_ends(stage, state)
    assert axial_strain(stage, state).shape == bending_strain(stage, state).shape == (nodes - 1,)
    assert contact_force(stage, state).shape == (nodes,)
    assert wires.shape == (9, 2, 3)
    assert wires[:, 1, 2] - wires[:, 0, 2] == pytest.approx(20 * stage.specimen.radius)


def test_hooks_are_held_by_their_poles(bar: Callable[..., None], rubbed: tuple[Rig, list[State]]) -> None:
    stage, states = rubbed
    hooks = stage.work.model.hooks
    assert hooks is not None
    shares = []
    for state in states:
        pull = np.zeros(hooks.slider.size)
        np.add.at(pull, hooks.hook, state.reaction[hooks.nodes, hooks.pull[hooks.hook]])
        lateral = np.abs(pole_forces(hooks, state.poles, stage.work.model.law.slip))
        assert lateral.max() > 0.0
        shares.append((lateral / np.maximum(POLE * np.abs(pull), 1e-9)).max())
    excess = max(shares) - 1.0
    bar("hooks: lateral force of a hook over pole friction, beyond 1", max(excess, 0.0), 1e-6, "1", "Coulomb 1785")
    # Some hook slides, in one direction on the way up and in the other on the way back.
    assert max(shares[:2]) > 1.0 - 1e-9
    up, back = (np.sign(state.poles.slip) * (np.abs(state.poles.slip) > 0.0199) for state in states[1:])
    assert ((up * back) < 0.0).any()


def test_work_is_stored_or_dissipated(bar: Callable[..., None], rubbed: tuple[Rig, list[State]]) -> None:
    _, states = rubbed
    top, end = states[1], states[2]
    for state in (top, end):
        lost = state.external_work - state.energies.sum() - state.friction_work
        bar("wires on poles that rub: energy balance", lost / top.external_work, 0.01, "1", "first law")


def test_the_machine_has_pole_friction_of_its_own(mount_knit: Callable[..., tuple[Rig, State, object]]) -> None:
    data = read_machine("biaxial-hook")
    assert data.pole is not None
    rough = replace(data, pole=replace(data.pole, friction=replace(data.pole.friction, value=0.2)))
    for given, expected in ((None, 0.2), (0.05, 0.05)):
        stage, _, _ = mount_knit(*STEPS, data=rough, pole_friction=given)
        hooks = stage.work.model.hooks
        assert hooks is not None
        assert hooks.friction == pytest.approx(np.full(2 * (2 + 4), expected))
        assert hooks.tied.size == 0
    stage, _, _ = mount_knit(*STEPS, data=rough, pole_friction=0.0)
    assert stage.work.model.hooks is None


def test_volumetric_knits_have_no_wires(mount_knit: Callable[..., tuple[Rig, State, object]]) -> None:
    with pytest.raises(SpecificationError, match=r"hook: found 'wire', allowed pin: wires hold .* planar knit"):
        mount_knit(Zero(), hook="wire", layers=2, mount_along="C")


def test_the_middle_of_a_free_specimen_hangs_on_a_wire_that_is_tied(
    mount_knit: Callable[..., tuple[Rig, State, object]],
) -> None:
    stage, _, _ = mount_knit(Zero(), hook="wire", rows=3, loops=3, mount_along="W")
    low, _ = stage.grips["W"]
    fixed = stage.work.model.fixed
    tied = [bool(fixed[wire, low.pole].all()) for wire in low.wires]
    assert sum(tied) == 1
    assert all(fixed[wire][:, [1, 2, 3]].all() for wire in low.wires)

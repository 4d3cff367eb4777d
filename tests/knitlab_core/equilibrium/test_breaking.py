from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.contact.bonds import BondState
from knitlab_core.equilibrium.breaking import TRIES, reach
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.newton import Report
from knitlab_core.equilibrium.step_control import Pace
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import POISSON_RATIO, straight
from tests.knitlab_core.equilibrium.strands import strand

LOCATE = 0.01


def crossed(law: BondLaw | None, gap: float = 0.3, friction: float = 0.0) -> tuple[Model, State]:
    """Make two strands that cross, clamped at their ends, fused or not."""
    strands = [straight((0, 0, 0), (1, 0, 0), 24.0), straight((0, 0, 2.0 + gap), (0, 1, 0), 24.0)]
    model, state = make_model(
        strands, radius=1.0, young_modulus=1.0, poisson_ratio=POISSON_RATIO, friction=friction, bonds=law
    )
    model.fixed[[0, 1, 11, 12, 13, 14, 24, 25]] = True
    return model, state


def lifted(state: State, height: float) -> FloatArray:
    q = state.q.copy()
    q[13:, 2] += height
    return q


@dataclass(slots=True)
class Road:
    """Stands in for a search: every whole bond's load is its rate times the parameter, or jumps to it.

    It fails where a bond keeps less than `boldest` of the stiffness it had, unless that was next to nothing.
    """

    rates: tuple[float, ...]
    jump: float = 0.0
    boldest: float = 0.0
    went: list[tuple[float, float]] = field(default_factory=list)

    held: float = 1.0

    def search(self, state: State, at: float, to: float) -> tuple[State | None, Report]:
        self.went.append((at, to))
        report = Report(converged=True, iterations=2, residual=0.0, node=0, contacts=0)
        hold = float(state.bonds.hold[0])
        if hold < self.boldest * self.held and self.held > 1e-3:
            return None, replace(report, converged=False)
        self.held = hold
        whole = state.bonds.whole
        # A bond that breaks leaves its share to the others.
        load = (
            np.array(self.rates) * (to if to > self.jump else 0.0) * whole.size / max(1, int(np.count_nonzero(whole)))
        )
        bonds = state.bonds._replace(load=np.where(whole, load, 0.0), energy=float(load[whole].sum()))
        return replace(state, bonds=bonds), report

    def settle(self, state: State) -> tuple[State | None, Report]:
        """Search where the last search led."""
        at = self.went[-1][1]
        return self.search(state, at, at)


def walk(road: Road, goal: float = 1.0) -> list[tuple[float, State, Report]]:
    _, state = strand()
    state = replace(state, bonds=BondState.printed(len(road.rates)))
    at, rows = 0.0, []
    while at < goal:
        at, found, report = reach(road.search, road.settle, state, LOCATE, at, goal)
        assert found is not None
        state = found
        rows.append((at, state, report))
    return rows


def test_a_step_without_a_break_is_one_search() -> None:
    road = Road((0.5, 0.9))
    ((at, state, report),) = walk(road)
    assert at == 1.0
    assert road.went == [(0.0, 1.0)]
    assert state.bonds.whole.all()
    assert report.iterations == 2


def test_a_bond_is_found_at_its_strength_and_breaks_at_the_same_place() -> None:
    road = Road((1.25, 0.5))
    first, last = walk(road)
    assert 1.0 - LOCATE <= first[1].bonds.load[0] <= 1.0
    assert first[1].bonds.whole.all()
    assert first[0] == pytest.approx(0.8, rel=LOCATE)
    assert (first[0], first[0]) in road.went
    np.testing.assert_array_equal(last[1].bonds.whole, [False, True])
    # What the first bond stored is gone, less what the other took over.
    assert last[1].bonds.released == pytest.approx(first[1].bonds.energy - 0.5 * 2.0 * first[0])
    assert last[0] == 1.0
    assert first[2].iterations + last[2].iterations == 2 * len(road.went)


def test_one_break_brings_the_next_at_the_same_place() -> None:
    road = Road((1.25, 0.7))
    first, last = walk(road)
    assert road.went.count((first[0], first[0])) == 2
    assert not last[1].bonds.whole.any()
    assert last[1].bonds.energy == 0.0


@pytest.mark.parametrize(("boldest", "searches"), [(0.2, 10), (0.4, 17)])
def test_a_bond_that_cannot_go_at_once_is_weakened_step_by_step(boldest: float, searches: int) -> None:
    road = Road((1.25, 0.5), boldest=boldest)
    first, last = walk(road)
    assert len([way for way in road.went if way == (first[0], first[0])]) < searches
    np.testing.assert_array_equal(last[1].bonds.hold, [0.0, 1.0])
    assert last[1].bonds.released == pytest.approx(first[1].bonds.energy - 0.5 * 2.0 * first[0])


def test_a_bond_that_cannot_go_at_all_ends_the_step() -> None:
    road = Road((1.25, 0.5), boldest=0.6)
    _, state = strand()
    state = replace(state, bonds=BondState.printed(2))
    at, found, _ = reach(road.search, road.settle, state, LOCATE, 0.0, 1.0)
    assert found is not None
    _, end, report = reach(road.search, road.settle, found, LOCATE, at, 1.0)
    assert end is None
    assert not report.converged


def test_a_load_that_jumps_breaks_its_bond_all_the_same() -> None:
    road = Road((3.0,), jump=0.6)
    rows = walk(road)
    assert len(road.went) < 4 * TRIES
    assert not rows[-1][1].bonds.whole.any()
    assert max(state.bonds.load.max() for _, state, _ in rows) <= 1.0


@pytest.mark.parametrize("longest", [1.0, 0.23])
def test_no_equilibrium_has_a_bond_beyond_its_strength_and_none_heals(longest: float) -> None:
    model, printed = crossed(BondLaw(fuse_gap=0.5, patch_radius=0.4, strength=1e-2))
    work = Workspace(model)
    rows = [state for _, state, _ in march(work, printed, lambda s: lifted(printed, s), longest=longest)]
    rows += [state for _, state, _ in march(work, rows[-1], lambda s: lifted(printed, 1.0 - s), longest=longest)]
    assert max(state.bonds.load.max() for state in rows) <= 1.0
    whole = [bool(state.bonds.whole[0]) for state in rows]
    assert whole == sorted(whole, reverse=True)
    assert whole[0]
    end = rows[-1]
    assert not end.bonds.whole[0]
    assert end.bonds.energy == 0.0
    # The strands are straight again: all the work went into the break.
    assert end.bonds.released > 0.0
    assert end.energies.sum() < 1e-12


def test_a_march_goes_back_to_its_own_steps_after_a_break() -> None:
    model, state = crossed(BondLaw(fuse_gap=0.5, patch_radius=0.4, strength=1e-2))
    shares = [s for s, _, _ in march(Workspace(model), state, lambda s: lifted(state, s), longest=0.125)]
    assert set(np.arange(1, 9) / 8) < set(shares)
    assert len(shares) < 12


def test_a_march_yields_what_was_before_and_after_a_break_at_one_place() -> None:
    model, state = crossed(BondLaw(fuse_gap=0.5, patch_radius=0.4, strength=1e-2))
    rows = list(march(Workspace(model), state, lambda s: lifted(state, s), longest=0.125))
    broke = [k for k in range(1, len(rows)) if rows[k][1].bonds.whole.sum() < rows[k - 1][1].bonds.whole.sum()]
    assert len(broke) == 1
    (at, before, _), (also, after, _) = rows[broke[0] - 1], rows[broke[0]]
    assert at == also
    np.testing.assert_array_equal(before.q[model.fixed], after.q[model.fixed])
    assert before.bonds.load.max() > 0.98
    pull = [abs(float(one.reaction[13:, 2].sum())) for one in (before, after)]
    assert pull[1] < 0.9 * pull[0]


def test_a_march_taken_up_between_them_goes_on_to_the_same_rows() -> None:
    model, state = crossed(BondLaw(fuse_gap=0.5, patch_radius=0.4, strength=1e-2))

    def path(share: float) -> FloatArray:
        return lifted(state, share)

    work, pace = Workspace(model), Pace()
    kept, whole = [], []
    for at, found, _ in march(work, state, path, longest=0.125, pace=pace):
        kept.append((Pace(at=pace.at, step=pace.step), found, work.solver_state))
        whole.append((at, found.q.tobytes()))
    for number, (stands, found, carried) in enumerate(kept[:-1]):
        fresh = Workspace(model)
        assert carried is not None
        fresh.restore(carried)
        rest = march(fresh, found, path, longest=0.125, pace=stands)
        assert [(at, one.q.tobytes()) for at, one, _ in rest] == whole[number + 1 :]


def test_a_bond_acts_where_no_contact_is_listed() -> None:
    model, state = crossed(BondLaw(fuse_gap=3.1, patch_radius=0.4, strength=1.0), gap=3.0)
    work = Workspace(model)
    *_, (_, end, report) = march(work, state, lambda s: lifted(state, 0.5 * s), longest=0.25)
    assert work.contacts.touching.a.size == 0
    assert end.bonds.load.max() > 0.0
    assert end.q[6, 2] > 0.05
    assert report.iterations <= 6


def test_a_workspace_may_go_back_to_a_state_with_more_bonds() -> None:
    model, state = crossed(BondLaw(fuse_gap=3.1, patch_radius=0.4, strength=1.0), gap=3.0)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory, np.zeros(1))
    free = work.stiffness.pattern.rows.size
    work.start_step(state.q, state.frames, state.memory)
    assert work.stiffness.pattern.rows.size == free + 9


def _pressed(state: State) -> Callable[[float], FloatArray]:
    return lambda s: lifted(state, -0.8 * s)


def test_a_law_that_fuses_nothing_changes_nothing() -> None:
    ends = []
    for law in (None, BondLaw(fuse_gap=0.1, patch_radius=0.4, strength=1e-2)):
        model, state = crossed(law, friction=0.3)
        *_, (_, end, _) = march(Workspace(model), state, _pressed(state), longest=0.25)
        assert end.contacts > 0
        ends.append(end)
    np.testing.assert_array_equal(ends[0].q, ends[1].q)
    np.testing.assert_array_equal(ends[0].reaction, ends[1].reaction)
    assert ends[1].bonds.whole.size == 0

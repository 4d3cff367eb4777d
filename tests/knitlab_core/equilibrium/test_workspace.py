import numpy as np
import pytest

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import follow
from tests.knitlab_core.equilibrium.strands import crossing, strand, stretched


def pressed(depth: float, friction: float = 0.3) -> tuple[Workspace, State]:
    """Press two crossing strands together; return the workspace, begun at the equilibrium, and that."""
    model, state = crossing(gap=0.1, friction=friction)
    target = state.q.copy()
    target[17:, 2] -= 0.1 + depth
    work = Workspace(model)
    *_, (_, end, _) = march(work, state, lambda s: state.q + s * (target - state.q), longest=0.25)
    work.start_step(end.q, end.frames, end.memory)
    return work, end


def test_strands_that_press_are_in_contact_and_straight_ones_are_not() -> None:
    work, _ = pressed(0.3)
    assert work.lag() > 0
    model, state = crossing(gap=0.1)
    apart = Workspace(model)
    apart.start_step(state.q, state.frames, state.memory)
    assert apart.lag() == 0
    assert apart.contacts.spans.a.size > 0
    assert apart.contacts.touching.a.size == 0


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_room_ends_before_cores_overlap(share: float) -> None:
    work, state = pressed(0.3)
    down = np.zeros_like(state.q)
    down[17:, 2] = -5.0
    fraction = work.contacts.collision_free_fraction(state.q, down, share)
    assert 0.0 < fraction < 0.3
    work.move_to(state.q + fraction * down, state.frames)
    points = work.placed.points
    near = find_candidates(state.q + fraction * down, work.model.samples, work.model.law, 0.0)
    gaps = np.linalg.norm(points[near.a] - points[near.b], axis=1)
    assert gaps.min() > work.model.law.distance - work.model.law.overlap_limit


def test_there_is_room_for_all_of_a_motion_that_brings_nothing_nearer() -> None:
    work, state = pressed(0.1)
    together = np.zeros_like(state.q)
    together[:, 0] = 50.0
    assert work.contacts.collision_free_fraction(state.q, together, 0.5) == 1.0


def test_cores_that_overlap_have_infinite_energy() -> None:
    model, state = crossing(gap=0.1)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    q = state.q.copy()
    q[17:, 2] -= 1.2
    work.contacts.keep_listed(q)
    assert work.energy(q, state.frames) == np.inf


def test_a_column_past_its_buckling_load_is_shifted_as_little_as_makes_it_stable() -> None:
    model, state = strand(41)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    # Clamped ends: buckles at a strain of -4 pi^2 I / (A L^2) = -pi^2 / 400 = -0.0247.
    for strain, stable in ((-0.02, True), (-0.04, False)):
        q = stretched(state, strain)
        frames = state.frames.copy()
        frames.length[:-1] *= 1.0 + strain
        work.move_to(q, frames)
        work.assemble()
        assert work.stiffness.factor()
        assert (work.stiffness.shift == 0.0) is stable


def test_dead_loads_bend_a_clamped_strand_as_a_beam() -> None:
    model, state = strand(81)
    work = Workspace(model)
    work.dead.loads[40, 2] = 1e-6
    found, _ = advance(work, state, state.q, Options(tolerance=1e-8))
    assert found is not None
    # The bend at a clamp's inner node stands for half an edge on either side: free from middle to middle.
    length = 20.0 * 79 / 80
    assert found.q[40, 2] == pytest.approx(1e-6 * length**3 / (192.0 * np.pi / 4.0), rel=2e-3)
    np.testing.assert_allclose(found.reaction[:, 2].sum(), -1e-6, rtol=1e-6)


def test_the_list_follows_strands_that_move_far() -> None:
    model, state = crossing(gap=8.4)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    assert work.contacts.touching.a.size == 0
    q = state.q.copy()
    q[17:, 2] -= 8.5
    assert work.contacts.keep_listed(q)
    work.move_to(q, state.frames)
    assert work.contacts.touching.a.size > 0


def test_times_are_kept_by_part() -> None:
    work, _ = pressed(0.2)
    assert {"gradient", "assembly", "factor", "solve", "neighbours", "analyse"} <= set(work.clock.seconds)
    assert work.clock.factorisations >= work.clock.calls["factor"] > 0


def test_drag_resists_as_its_energy_says() -> None:
    model, state = strand(12)
    work = Workspace(model)
    rng = np.random.default_rng(3)
    work.start_step(state.q, state.frames, state.memory, drag=0.3)
    free = ~model.fixed
    q = state.q + 0.01 * free * rng.standard_normal(state.q.shape)
    way = free * rng.standard_normal(state.q.shape)
    frames = state.frames.copy()
    follow(q, work.model.rods.has_edge, state.frames, frames)

    def gradient(at: FloatArray) -> FloatArray:
        there = frames.copy()
        follow(at, work.model.rods.has_edge, frames, there)
        work.move_to(at, there)
        return work.gradient()

    small = 1e-5 * way
    slope = (work.energy(q + small, frames) - work.energy(q - small, frames)) / 2.0
    assert np.vdot(gradient(q), small) == pytest.approx(slope, rel=1e-7)
    work.move_to(q, frames)
    work.assemble()
    thick = work.stiffness.times(way)
    work.start_step(state.q, state.frames, state.memory)
    work.move_to(q, frames)
    work.assemble()
    assert free * (thick - work.stiffness.times(way)) == pytest.approx(way * [0.3, 0.3, 0.3, 0.0], abs=1e-12)

"""Pairs that act, against kernels over all candidates."""

import numpy as np
import pytest

from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.stiffness import contact_hessian, friction_hessian
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.pattern import make_pattern
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import Touch, sampled, touch
from tests.knitlab_core.equilibrium.strands import crossing


def slid(friction: float = 0.3) -> tuple[Workspace, State]:
    """Press two strands together and slide them a little; return a workspace begun there, and the state."""
    model, start = crossing(gap=0.1, friction=friction)
    way = np.zeros_like(start.q)
    way[17:, 2], way[17:, 0] = -0.3, 0.05
    work = Workspace(model)
    *_, (_, state, _) = march(work, start, lambda s: start.q + s * way, longest=0.25)
    work.start_step(state.q, state.frames, state.memory)
    return work, state


def all_pairs(work: Workspace, state: State) -> Touch:
    """Return every candidate within a wide skin, with what friction remembers."""
    return touch(work.model, state, memory=state.memory, skin=1.5)


def test_pairs_that_rub_at_first_are_those_remembered() -> None:
    work, state = slid()
    rubbing = work.contacts.rubbing
    key = rubbing.a * len(sampled(work.model, state.q)) + rubbing.b
    np.testing.assert_array_equal(np.sort(key), state.memory.key)


@pytest.mark.parametrize("lagged", [False, True])
def test_they_store_exert_and_resist_what_all_candidates_do(lagged: bool) -> None:  # noqa: FBT001
    work, state = slid()
    law, scene = work.model.law, all_pairs(work, state)
    assert scene.candidates.a.size > 3 * work.contacts.touching.a.size > 0
    q = state.q.copy()
    q[17:, 0] += 0.01
    q[17:, 2] -= 0.02
    frames = scene.follow(q)
    work.move_to(q, frames)
    if lagged:
        assert work.lag() == scene.lag(q)
    assert work.contacts.energy() == pytest.approx(scene.energy(q), rel=1e-12)
    gradient = np.zeros_like(q)
    work.contacts.add_gradient(gradient)
    expected = scene.gradient(q)
    np.testing.assert_allclose(gradient, expected, rtol=0.0, atol=1e-14 * np.abs(expected).max())

    pattern = make_pattern(len(q), find_candidates(q, work.model.samples, law, 1.5))
    found = np.zeros((pattern.rows.size, 4, 4))
    assert work.contacts.fits(pattern)
    work.contacts.add_hessian(1.0, found)
    pattern = make_pattern(len(q), scene.candidates)
    whole, placed, samples = np.zeros((pattern.rows.size, 4, 4)), scene.placed(q), work.model.samples
    contact_hessian(placed.points, scene.candidates, samples, law, 1.0, pattern, whole)
    friction_hessian(placed, scene.candidates, samples, law, 1.0, scene.pairs, pattern, whole)
    assert found.sum() == pytest.approx(whole.sum(), rel=1e-10)
    assert np.vdot(found, found) == pytest.approx(np.vdot(whole, whole), rel=1e-12)


def test_what_is_remembered_and_its_work_are_those_of_all_candidates() -> None:
    work, state = slid()
    scene = all_pairs(work, state)
    q = state.q.copy()
    # Some pairs come apart, others come together.
    q[17:, 0] += 0.3
    work.move_to(q, scene.follow(q))
    scene.lag(q)
    memory, rubbed = work.contacts.settle()
    expected, wanted = scene.settle(q)
    assert set(state.memory.key.tolist()) - set(memory.key.tolist())
    np.testing.assert_array_equal(memory.key, expected.key)
    np.testing.assert_allclose(memory.slip, expected.slip, rtol=0.0, atol=1e-15)
    assert rubbed == pytest.approx(wanted, rel=1e-12)

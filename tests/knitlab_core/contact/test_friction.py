"""What friction remembers: who was loaded, how far it had slipped, and no more."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.contact.friction import Memory, recall
from knitlab_core.contact.neighbours import find_candidates
from tests.contact_scenes import Touch, straight, touch, unit_model

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State

MU = 0.3


def pressed() -> tuple[Touch, State]:
    """Return two rods that cross and press, and their state."""
    upper = straight((0.1, 0, 1.9), (0, 1, 0), 12.0)
    model, state = unit_model([straight((0, 0, 0), (1, 0, 0), 12.0), upper], friction=MU)
    return touch(model, state), state


def slid(scene: Touch, state: State, way: float) -> tuple[Memory, float, FloatArray]:
    """Slide the upper rod along the lower, accept that, and return memory, work and place."""
    q = state.q.copy()
    q[7:, 0] += way
    scene.lag(q)
    return *scene.settle(q), q


def test_nothing_is_remembered_at_first() -> None:
    scene, _ = pressed()
    pairs = recall(Memory.empty(), scene.candidates, scene.base)
    np.testing.assert_array_equal(pairs.anchor, scene.base[scene.candidates.a] - scene.base[scene.candidates.b])
    assert not any(part.any() for part in (pairs.start_load, pairs.load, pairs.normal))


def test_loaded_pairs_are_remembered_in_order() -> None:
    scene, state = pressed()
    memory, _, _ = slid(scene, state, 0.01)
    assert memory.key.size == np.count_nonzero(scene.pairs.load) > 0
    assert (np.diff(memory.key) > 0).all()
    assert memory.load.sum() == pytest.approx(scene.pairs.load.sum())


def test_recall_finds_the_same_pairs_in_another_list() -> None:
    scene, state = pressed()
    memory, _, q = slid(scene, state, 0.01)
    model, base = scene.model, scene.base
    wider = find_candidates(q, model.samples, model.law, 1.5)
    assert wider.a.size > scene.candidates.a.size
    pairs = recall(memory, wider, base)
    key = wider.a * len(base) + wider.b
    known = np.isin(key, memory.key)
    order = np.argsort(key[known])
    carried = base[wider.a] - base[wider.b] - pairs.anchor
    np.testing.assert_allclose(carried[known][order], memory.slip, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(pairs.start_load[known][order], memory.load)
    np.testing.assert_array_equal(pairs.normal[known][order], memory.normal)
    assert not any(part[~known].any() for part in (carried, pairs.start_load, pairs.load, pairs.normal))


@pytest.mark.parametrize("way", [0.0, 0.02, 0.3])
def test_slip_is_tangential_and_never_longer_than_its_limit(way: float) -> None:
    scene, state = pressed()
    memory, _, _ = slid(scene, state, way)
    limit = scene.model.law.slip
    size = np.linalg.norm(memory.slip, axis=1)
    assert (size <= limit * (1.0 + 1e-12)).all()
    np.testing.assert_allclose((memory.slip * memory.normal).sum(axis=1), 0.0, atol=1e-12)
    if way > limit:
        # Nearly all pairs slide; those whose normal leans far along the slide may still stick.
        assert np.median(size) == pytest.approx(limit)


def test_memory_continues_the_force_across_an_equilibrium() -> None:
    scene, state = pressed()
    memory, _, q = slid(scene, state, 0.02)
    assert np.linalg.norm(memory.slip, axis=1).max() > 0.01
    later = touch(scene.model, state, memory=memory, q=q)
    before, after = scene.gradient(q), later.gradient(q)
    np.testing.assert_allclose(after[:7].sum(axis=0)[:3], before[:7].sum(axis=0)[:3], atol=1e-14)
    # The couple's arm is that of the last equilibrium: it changes as the pairs came nearer or went apart on the way.
    apart = [np.linalg.norm(x[scene.candidates.a] - x[scene.candidates.b], axis=1) for x in (scene.base, later.base)]
    couple = MU * np.vdot(scene.pairs.load, np.abs(apart[1] - apart[0]))
    assert np.abs(after - before).max() < 0.5 * couple
    # Held there, nothing changes any more.
    held, _ = later.settle(q)
    np.testing.assert_allclose(touch(scene.model, state, memory=held, q=q).gradient(q), after, atol=1e-14)


def test_sliding_back_and_forth_dissipates_and_holding_does_not() -> None:
    scene, state = pressed()
    load = scene.pairs.load.sum()
    _, work, _ = slid(scene, state, 0.0)
    assert work == pytest.approx(0.0, abs=1e-30)
    _, work, _ = slid(scene, state, 0.3)
    # Loads and normals vary a little on the way; start and end forces are averaged.
    assert 0.0 < work < MU * load * 0.3


def test_pair_that_parted_is_forgotten() -> None:
    scene, state = pressed()
    lifted = state.q.copy()
    lifted[7:, 2] += 0.3
    scene.lag(lifted)
    memory, _ = scene.settle(lifted)
    assert memory.key.size == 0

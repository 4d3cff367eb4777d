"""What friction remembers: who was loaded, how far it had slipped, and no more."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.contact.friction import Memory, recall, settle
from knitlab_core.contact.neighbours import find_candidates
from tests.contact_scenes import Touch, straight, touch, unit_model

MU = 0.3


def pressed() -> tuple[Touch, np.ndarray]:
    """Return two rods that cross and press, and where they are."""
    upper = straight((0.1, 0, 1.9), (0, 1, 0), 12.0)
    model, state = unit_model([straight((0, 0, 0), (1, 0, 0), 12.0), upper], friction=MU)
    return touch(model, state.q), state.q


def slid(scene: Touch, q: np.ndarray, way: float) -> tuple[Memory, float, np.ndarray]:
    """Slide the upper rod along the lower, accept that, and return memory, work and place."""
    q = q.copy()
    q[7:, 0] += way
    scene.lag(q)
    memory, work = settle(scene.points(q), scene.base, scene.candidates, scene.model.law, scene.pairs)
    return memory, work, q


def test_nothing_is_remembered_at_first() -> None:
    scene, _ = pressed()
    pairs = recall(Memory.empty(), scene.candidates, len(scene.base))
    assert not any(part.any() for part in pairs)


def test_loaded_pairs_are_remembered_in_order() -> None:
    scene, q = pressed()
    memory, _, _ = slid(scene, q, 0.01)
    assert memory.key.size == np.count_nonzero(scene.pairs.load) > 0
    assert (np.diff(memory.key) > 0).all()
    assert memory.load.sum() == pytest.approx(scene.pairs.load.sum())


def test_recall_finds_the_same_pairs_in_another_list() -> None:
    scene, q = pressed()
    memory, _, q = slid(scene, q, 0.01)
    model = scene.model
    wider = find_candidates(q, model.samples, model.law, 1.5)
    assert wider.a.size > scene.candidates.a.size
    pairs = recall(memory, wider, len(scene.base))
    key = wider.a * len(scene.base) + wider.b
    known = np.isin(key, memory.key)
    order = np.argsort(key[known])
    np.testing.assert_array_equal(pairs.carried[known][order], memory.slip)
    np.testing.assert_array_equal(pairs.start_load[known][order], memory.load)
    np.testing.assert_array_equal(pairs.normal[known][order], memory.normal)
    assert not any(part[~known].any() for part in pairs)


@pytest.mark.parametrize("way", [0.0, 0.02, 0.3])
def test_slip_is_tangential_and_never_longer_than_its_limit(way: float) -> None:
    scene, q = pressed()
    memory, _, _ = slid(scene, q, way)
    limit = scene.model.law.slip
    size = np.linalg.norm(memory.slip, axis=1)
    assert (size <= limit * (1.0 + 1e-12)).all()
    np.testing.assert_allclose((memory.slip * memory.normal).sum(axis=1), 0.0, atol=1e-12)
    if way > limit:
        # Nearly all pairs slide; those whose normal leans far along the slide may still stick.
        assert np.median(size) == pytest.approx(limit)


def test_memory_continues_the_force_across_an_equilibrium() -> None:
    scene, q = pressed()
    memory, _, q = slid(scene, q, 0.02)
    before = scene.gradient(q)
    after = touch(scene.model, q)
    pairs = recall(memory, after.candidates, len(after.base))
    later = Touch(model=scene.model, base=after.base, candidates=after.candidates, pairs=pairs)
    np.testing.assert_allclose(later.gradient(q), before, atol=1e-12)


def test_sliding_back_and_forth_dissipates_and_holding_does_not() -> None:
    scene, q = pressed()
    load = scene.pairs.load.sum()
    _, work, _ = slid(scene, q, 0.0)
    assert work == 0.0
    _, work, _ = slid(scene, q, 0.3)
    # Loads and normals vary a little on the way; start and end forces are averaged.
    assert 0.0 < work < MU * load * 0.3


def test_pair_that_parted_is_forgotten() -> None:
    scene, q = pressed()
    lifted = q.copy()
    lifted[7:, 2] += 0.3
    scene.lag(lifted)
    memory, _ = settle(scene.points(lifted), scene.base, scene.candidates, scene.model.law, scene.pairs)
    assert memory.key.size == 0

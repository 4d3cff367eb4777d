"""Candidate pairs: all of them and no others, still all of them after a motion, and no way through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.contact.approach import largest_approach
from knitlab_core.contact.neighbours import find_candidates, least_distance, list_spans
from knitlab_core.contact.pairs import Balls, fill_balls, largest_fraction
from knitlab_core.equilibrium.contacts import SKIN
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import sampled, straight, unit_model

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.contact.pairs import Candidates
    from knitlab_core.equilibrium.model import Model

SEEDS = st.integers(0, 2**32 - 1)


def tangle(seed: int, strands: int, nodes: int, box: float) -> list[FloatArray]:
    """Return random smooth curves in a box [r], of uneven edges."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, nodes)[:, None, None]
    k = np.arange(1, 5)[None, :, None]
    return [
        rng.uniform(-box, box, 3)
        + (box * rng.normal(size=(1, 4, 3)) / k * np.sin(np.pi * k * (t + rng.uniform(size=(1, 4, 3))))).sum(axis=1)
        for _ in range(strands)
    ]


def keys(candidates: Candidates, count: int) -> set[int]:
    """Return one number per pair."""
    found = candidates.a * count + candidates.b
    assert len(np.unique(found)) == len(found)
    return set(found.tolist())


def all_pairs(model: Model, points: FloatArray, reach: float) -> set[int]:
    """Return what `keys` should give, from every pair of samples there is."""
    samples = model.samples
    m = len(samples.weights)
    number = (samples.spans[:, None] * m + np.arange(m)).ravel()
    span, place = number // m, number % m
    arc = samples.arc[span] + ((place + 0.5) / m - 0.5) * samples.length[span] * m
    near = np.linalg.norm(points[number][:, None] - points[number][None], axis=2) < reach
    same = samples.strand[span][:, None] == samples.strand[span][None]
    apart = np.abs(arc[:, None] - arc[None]) >= model.law.exclusion
    apart &= np.abs(span[:, None] - span[None]) >= 3
    a, b = np.nonzero(near & (~same | apart) & (span[:, None] < span[None]))
    return set((number[a] * len(points) + number[b]).tolist())


@given(seed=SEEDS, strands=st.integers(1, 4), nodes=st.integers(3, 24), skin=st.sampled_from([0.0, 0.5, 1.5]))
@settings(deadline=None, max_examples=60)
def test_candidates_are_those_of_all_pairs(seed: int, strands: int, nodes: int, skin: float) -> None:
    model, state = unit_model(tangle(seed, strands, nodes, 6.0), sample_spacing=0.7)
    points = sampled(model, state.q)
    found = find_candidates(state.q, model.samples, model.law, skin)
    assert keys(found, len(points)) == all_pairs(model, points, model.law.distance + skin)
    m = len(model.samples.weights)
    for s, (i, j) in enumerate(zip(found.span_a, found.span_b, strict=True)):
        pairs = slice(found.start[s], found.start[s + 1])
        assert found.start[s + 1] > found.start[s]
        assert (found.a[pairs] // m == i).all()
        assert (found.b[pairs] // m == j).all()


@given(seed=SEEDS, strands=st.integers(2, 4))
@settings(deadline=None, max_examples=30)
def test_least_distance_is_that_of_all_pairs_and_never_more(seed: int, strands: int) -> None:
    model, state = unit_model(tangle(seed, strands, 20, 4.0), sample_spacing=0.7)
    points = sampled(model, state.q)
    near = np.array(sorted(all_pairs(model, points, model.law.reach)), dtype=np.int64)
    apart = np.linalg.norm(points[near // len(points)] - points[near % len(points)], axis=1)
    found, expected = least_distance(state.q, model.samples, model.law), apart.min(initial=np.inf)
    assert found <= expected
    assert found == pytest.approx(expected, rel=1e-11)


def test_specimen_wider_than_the_largest_grid_is_still_searched() -> None:
    far = straight((1e5, 1e5, 1e5), (1, 0, 0), 8.0)
    near = [straight((0, 0, z), (1, 0, 0), 8.0) for z in (0.0, 2.0)]
    model, state = unit_model([*near, far], sample_spacing=1.0)
    points = sampled(model, state.q)
    found = find_candidates(state.q, model.samples, model.law, 0.5)
    assert found.a.size > 0
    assert keys(found, len(points)) == all_pairs(model, points, model.law.distance + 0.5)


@given(seed=SEEDS, strands=st.integers(1, 4), enough=st.sampled_from([0.0, 1.0, 5.0]), stretch=st.floats(0.0, 0.5))
@settings(deadline=None, max_examples=60)
def test_no_two_nodes_approach_by_more_than_the_bound(seed: int, strands: int, enough: float, stretch: float) -> None:
    rng = np.random.default_rng(seed)
    x = np.concatenate(tangle(seed, strands, 10, 8.0))
    dx = x @ rng.normal(0.0, stretch, (3, 3)) + rng.normal(0.0, rng.uniform(0.0, 0.5), x.shape) + rng.normal(size=3)
    reach = 3.0
    bound = largest_approach(x, dx, reach, enough)
    before = np.linalg.norm(x[:, None] - x[None], axis=2)
    after = np.linalg.norm((x + dx)[:, None] - (x + dx)[None], axis=2)
    assert (after >= np.minimum(before, reach) - bound - 1e-9).all()


def test_stretch_of_a_large_specimen_brings_little_together() -> None:
    x = np.concatenate([straight((0, y, 0), (1, 0, 0), 400.0) for y in np.linspace(-200.0, 200.0, 41)])
    dx = 0.01 * x
    # The motion is 2.8 r at the corners; pairs within reach come 1 % of 3 r nearer.
    assert np.linalg.norm(dx, axis=1).max() > 2.8
    assert largest_approach(x, dx, 3.0, 0.0) < 0.1
    assert largest_approach(x, np.full_like(x, 7.0), 3.0, 1.0) == pytest.approx(0.0, abs=1e-9)


@given(seed=SEEDS, scale=st.floats(0.01, 0.4))
@settings(deadline=None, max_examples=40)
def test_kept_list_holds_every_pair_that_acts(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    model, state = unit_model(tangle(seed, 3, 12, 6.0), sample_spacing=0.7)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    q = state.q.copy()
    for _ in range(6):
        q[:, :3] += q[:, :3] @ rng.normal(0.0, 0.2 * scale, (3, 3)) + rng.normal(0.0, scale, (len(q), 3))
        work.contacts.keep_listed(q)
        work.move_to(q, state.frames)
        points = sampled(model, q)
        assert keys(work.contacts.touching, len(points)) == all_pairs(model, points, model.law.reach)


@given(seed=SEEDS, scale=st.floats(0.01, 5.0))
@settings(deadline=None, max_examples=40)
def test_a_step_with_room_touches_no_pair_that_is_not_listed(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    model, state = unit_model(tangle(seed, 3, 12, 6.0), sample_spacing=0.7)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    q = state.q.copy()
    for _ in range(4):
        step = rng.normal(0.0, scale, q.shape)
        q += work.contacts.collision_free_fraction(q, step, 0.9) * step
        work.move_to(q, state.frames)
        points = sampled(model, q)
        assert keys(work.contacts.touching, len(points)) == all_pairs(model, points, model.law.reach)
        work.contacts.keep_listed(q)


def crossed(gap: float) -> list[FloatArray]:
    """Return two strands crossed at right angles, a gap [r] between their centrelines."""
    return [straight((0, 0, 0), (1, 0, 0), 20.0), straight((0, 0, gap), (0, 1, 0), 20.0)]


def test_list_is_renewed_before_a_pair_comes_within_reach() -> None:
    # Balls of spans of two radii hold more than their samples: strands farther apart than both are not listed.
    gap = 2.0 + SKIN + 2.01
    model, state = unit_model(crossed(gap))
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    spans = work.contacts.spans
    assert not ((spans.a < 11) & (spans.b >= 11)).any()
    q = state.q.copy()
    for _ in range(250):
        q[11:, 2] -= 0.02
        work.contacts.keep_listed(q)
        work.move_to(q, state.frames)
        points = sampled(model, q)
        assert keys(work.contacts.touching, len(points)) == all_pairs(model, points, model.law.reach)
    assert work.contacts.touching.a.size > 0


@given(seed=SEEDS, scale=st.floats(0.01, 20.0), share=st.floats(0.05, 0.95))
@settings(deadline=None, max_examples=60)
def test_largest_fraction_is_safe_and_not_smaller_than_it_must(seed: int, scale: float, share: float) -> None:
    rng = np.random.default_rng(seed)
    # Strands on levels 1.3 r apart: they overlap, but not to the core.
    x = [straight((0, 0, 1.3 * k), (np.cos(k), np.sin(k), 0), 16.0) + rng.uniform(-0.1, 0.1, (9, 3)) for k in range(3)]
    model, state = unit_model(x, sample_spacing=0.5)
    candidates = find_candidates(state.q, model.samples, model.law, SKIN)
    balls, move_balls = Balls.zeros(len(state.q)), Balls.zeros(len(state.q))
    spans = list_spans(state.q, model.samples, 100.0, balls)
    points, step = sampled(model, state.q), rng.normal(0.0, scale, state.q.shape)
    fill_balls(step, model.samples.spans, move_balls)
    moves = sampled(model, step)
    core = model.law.distance - model.law.overlap_limit
    fraction = largest_fraction(
        points, moves, balls, move_balls, spans, model.samples, model.law.exclusion, core, share
    )
    apart = points[candidates.a] - points[candidates.b]
    move = moves[candidates.a] - moves[candidates.b]
    room = share * (np.linalg.norm(apart, axis=1) - core)
    used = fraction * np.linalg.norm(move, axis=1)
    assert (used <= room * (1.0 + 1e-12)).all()
    assert fraction == 1.0 or (used / room).max() == pytest.approx(1.0)
    for part in np.linspace(0.0, fraction, 5):
        assert (np.linalg.norm(apart + part * move, axis=1) > core).all()


def test_no_room_is_lent_that_an_old_list_has_already_used() -> None:
    # One strand moves towards another within the skin: the pair is not listed, yet no longer far.
    strands = [*crossed(2.0 + SKIN + 0.05), straight((0, 0, -3.05), (0, 1, 0), 20.0)]
    model, state = unit_model(strands)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    q = state.q.copy()
    q[:11, 2] += 0.7
    work.contacts.keep_listed(q)
    work.move_to(q, state.frames)
    step = np.zeros_like(q)
    step[:11, 2] = 4.0
    q += work.contacts.collision_free_fraction(q, step, 0.5) * step
    core = model.law.distance - model.law.overlap_limit
    assert q[16, 2] - q[5, 2] > core

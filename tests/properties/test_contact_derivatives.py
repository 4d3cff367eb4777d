"""Contact and friction: forces and stiffness against finite differences, on random tangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from knitlab_core.contact.forces import contact_hessian
from knitlab_core.contact.friction import add_load_coupling
from knitlab_core.equilibrium.pattern import make_pattern, multiply
from tests.contact_scenes import Touch, straight, touch, unit_model

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

SEEDS = st.integers(0, 2**32 - 1)
SLIDES = st.sampled_from([0.0, 0.01, 0.4])
"""Motion since the last equilibrium: none, stuck (below the elastic slip of 0.05) or sliding [r]."""

EDGES = st.sampled_from([0.9, 2.0])


def tangle(seed: int, friction: float, slide: float, edge: float) -> tuple[Touch, FloatArray]:
    """Return three wavy rods that cross and press, loaded at one place and now at another."""
    rng = np.random.default_rng(seed)
    strands = []
    for level in range(3):
        angle = 1.1 * level + rng.uniform(-0.3, 0.3)
        x = straight((0, 0, 1.88 * level), (np.cos(angle), np.sin(angle), 0), 6 * edge, edge)
        strands.append(x + rng.normal(0.0, 0.02, x.shape))
    model, state = unit_model(strands, friction=friction)
    scene = touch(model, state.q)
    scene.pairs.carried[:] = rng.normal(0.0, 0.01, scene.pairs.carried.shape)
    q = state.q.copy()
    for first in (0, 7, 14):
        q[first : first + 7, :2] += slide * rng.uniform(-1.0, 1.0, 2)
    q[:, :3] += rng.normal(0.0, 0.01, (len(q), 3))
    energies = scene.energies(q)
    assume(np.isfinite(energies[0]) and energies[0] > 0.0)
    assert friction == 0.0 or energies[1] > 0.0
    return scene, q


def stiffness(scene: Touch, q: FloatArray, exact: float = 1.0) -> FloatArray:
    """Return the Hessian (4 N, 4 N) as a dense matrix."""
    m = scene.model
    pattern = make_pattern(len(q), scene.candidates)
    blocks = np.zeros((pattern.rows.size, 4, 4))
    points = scene.points(q)
    contact_hessian(points, scene.base, scene.candidates, m.samples, m.law, exact, scene.pairs, pattern, blocks)
    columns = []
    for unit in np.eye(q.size):
        column = np.zeros_like(q)
        multiply(pattern, blocks, unit.reshape(q.shape), column)
        columns.append(column.ravel())
    own = blocks[pattern.diagonal]
    np.testing.assert_array_equal(own, own.transpose(0, 2, 1))
    return np.column_stack(columns)


def least_way_to_a_jump(scene: Touch, q: FloatArray) -> float:
    """Return how near any pair is to where psi'' or friction's stiffness jumps [r]."""
    law, pairs, points = scene.model.law, scene.pairs, scene.points(q)
    a, b = scene.candidates.a, scene.candidates.b
    apart = points[a] - points[b]
    overlap = law.distance - np.linalg.norm(apart, axis=1)
    slip = pairs.carried + apart - (scene.base[a] - scene.base[b])
    slip -= (slip * pairs.normal).sum(axis=1, keepdims=True) * pairs.normal
    rest = np.abs(np.linalg.norm(slip, axis=1) - law.slip)[pairs.load > 0.0]
    return float(min(np.abs(overlap - law.onset).min(), rest.min(initial=1.0)))


@given(seed=SEEDS, friction=st.sampled_from([0.0, 0.3]), slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=40)
def test_gradient_against_differences_of_energy_over_decades(
    seed: int, friction: float, slide: float, edge: float
) -> None:
    scene, q = tangle(seed, friction, slide, edge)
    gradient = scene.gradient(q)
    way = np.random.default_rng(seed).normal(size=q.shape)
    way += gradient * np.linalg.norm(way) / np.linalg.norm(gradient)
    way /= np.linalg.norm(way)
    expected = float(np.vdot(gradient, way))
    steps = np.logspace(-2, -6, 9)
    differences = np.array([(scene.energy(q + s * way) - scene.energy(q - s * way)) / (2 * s) for s in steps])
    errors = np.abs(differences / expected - 1.0)
    assert errors.min() < 1e-8
    assert (errors < 0.1 * steps + 1e-9).all()


@given(seed=SEEDS, friction=st.sampled_from([0.0, 0.3]), slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=25)
def test_hessian_against_differences_of_gradient(seed: int, friction: float, slide: float, edge: float) -> None:
    scene, q = tangle(seed, friction, slide, edge)
    assume(least_way_to_a_jump(scene, q) > 4e-6)
    hessian = stiffness(scene, q)
    np.testing.assert_array_equal(hessian, hessian.T)
    errors = []
    for step in (2e-6, 1e-6, 5e-7):
        columns = [
            (scene.gradient(q + step * unit) - scene.gradient(q - step * unit)).ravel() / (2 * step)
            for unit in np.eye(q.size).reshape(-1, *q.shape)
        ]
        difference = np.column_stack(columns)
        errors.append(np.abs(difference - hessian).max() / np.abs(hessian).max())
    assert min(errors) < 1e-6


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=25)
def test_gauss_newton_stiffness_is_positive(seed: int, slide: float) -> None:
    scene, q = tangle(seed, 0.3, slide, 2.0)
    values = np.linalg.eigvalsh(stiffness(scene, q, exact=0.0))
    assert values[0] > -1e-12 * values[-1]


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=40)
def test_load_coupling_against_differences_of_friction_with_loads_that_follow(seed: int, slide: float) -> None:
    scene, q = tangle(seed, 0.3, slide, 2.0)
    scene.lag(q)
    assume(least_way_to_a_jump(scene, q) > 4e-6)
    m = scene.model
    normal = scene.pairs.normal.copy()
    way = np.random.default_rng(seed).normal(size=q.shape)
    coupling = np.zeros_like(q)
    add_load_coupling(scene.points(q), scene.base, scene.candidates, m.samples, m.law, scene.pairs, way, coupling)
    size = np.abs(coupling).max()
    assume(size > 0.0)

    def friction(step: float) -> FloatArray:
        # Only the loads follow: slips and directions are those of q.
        scene.lag(q + step * way)
        scene.pairs.normal[:] = normal
        return scene.gradient(q)

    errors = [np.abs((friction(step) - friction(-step)) / (2 * step) - coupling).max() / size for step in (1e-6, 5e-7)]
    assert min(errors) < 1e-6


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=25)
def test_action_is_reaction(seed: int, slide: float) -> None:
    scene, q = tangle(seed, 0.3, slide, 2.0)
    gradient = scene.gradient(q)
    assert np.abs(gradient.sum(axis=0)).max() < 1e-13 * max(1.0, np.abs(gradient).max() * len(q))


@given(seed=SEEDS, slide=SLIDES, friction=st.sampled_from([0.0, 0.3]))
@settings(deadline=None, max_examples=25)
def test_moving_everything_moves_nothing(seed: int, slide: float, friction: float) -> None:
    scene, q = tangle(seed, friction, slide, 2.0)
    away = q + np.array([3.0, -2.0, 5.0, 0.0])
    assert scene.energy(away) == pytest.approx(scene.energy(q), rel=1e-10)
    np.testing.assert_allclose(scene.gradient(away), scene.gradient(q), atol=1e-11 * np.abs(scene.gradient(q)).max())

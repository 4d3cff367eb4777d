"""Contact and friction: forces and stiffness against finite differences, on random tangles."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from knitlab_core.contact.friction import add_load_coupling
from knitlab_core.contact.law import law_as_printed
from knitlab_core.contact.stiffness import contact_hessian, friction_hessian
from knitlab_core.equilibrium.pattern import make_pattern, multiply
from tests.contact_scenes import Touch, straight, touch, unit_model

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.rods.frames import Frames

SEEDS = st.integers(0, 2**32 - 1)
FRICTIONS = st.sampled_from([0.0, 0.3])
SLIDES = st.sampled_from([0.0, 0.01, 0.4])
"""Motion since the last equilibrium: little, stuck (below the elastic slip of 0.02) or sliding [r]."""

EDGES = st.sampled_from([0.9, 2.0])

ROUNDING = 1e-14
"""By which a sum of squares may differ from its transpose, relative to the largest entry."""


class Tangle(NamedTuple):
    """A scene, where it is now and the frames there, from which any trial is followed."""

    scene: Touch
    q: FloatArray
    frames: Frames

    def energy(self, q: FloatArray) -> float:
        return self.scene.energy(q, self.frames)

    def gradient(self, q: FloatArray) -> FloatArray:
        return self.scene.gradient(q, self.frames)


def tangle(seed: int, friction: float, slide: float, edge: float) -> Tangle:
    """Return three wavy rods that cross and press, loaded at one place and now moved, turned and spun to another."""
    rng = np.random.default_rng(seed)
    strands = []
    for level in range(3):
        angle = 1.1 * level + rng.uniform(-0.3, 0.3)
        x = straight((0, 0, 1.88 * level), (np.cos(angle), np.sin(angle), 0), 6 * edge, edge)
        strands.append(x + rng.normal(0.0, 0.02, x.shape))
    model, state = unit_model(strands, friction=friction)
    # Printed far apart, nearer than the onset, or touching.
    model = replace(model, law=law_as_printed(model.law, 2.0 + (1.0, 0.01, 0.0)[seed % 3]))
    scene = touch(model, state)
    scene.pairs.anchor[:] += rng.normal(0.0, 0.01, scene.pairs.anchor.shape)
    q = state.q.copy()
    for first in (0, 7, 14):
        q[first : first + 7, :2] += slide * rng.uniform(-1.0, 1.0, 2)
    q[:, :3] += rng.normal(0.0, 0.01, (len(q), 3))
    for first in (0, 7, 14):
        q[first : first + 6, 3] += slide * rng.uniform(-1.0, 1.0) + rng.normal(0.0, 0.01, 6)
    energies = scene.energies(q)
    assume(np.isfinite(energies[0]) and energies[0] > 0.0)
    assert friction == 0.0 or energies[1] > 0.0
    return Tangle(scene, q, scene.follow(q))


def stiffness(tangle: Tangle, exact: float = 1.0) -> FloatArray:
    """Return the Hessian (4 N, 4 N) as a dense matrix."""
    scene, q, _ = tangle
    m = scene.model
    pattern = make_pattern(len(q), scene.candidates)
    blocks = np.zeros((pattern.rows.size, 4, 4))
    placed = scene.placed(q)
    contact_hessian(placed.points, scene.candidates, m.samples, m.law, exact, pattern, blocks)
    friction_hessian(placed, scene.candidates, m.samples, m.law, exact, scene.pairs, pattern, blocks)
    columns = []
    for unit in np.eye(q.size):
        column = np.zeros_like(q)
        multiply(pattern, blocks, unit.reshape(q.shape), column)
        columns.append(column.ravel())
    own = blocks[pattern.diagonal]
    np.testing.assert_allclose(own, own.transpose(0, 2, 1), rtol=0.0, atol=ROUNDING * np.abs(blocks).max())
    return np.column_stack(columns)


def jacobian(function: Callable[[FloatArray], FloatArray], q: FloatArray, step: float) -> FloatArray:
    """Return central differences (4 N, 4 N) of a function of the unknowns."""
    units = step * np.eye(q.size).reshape(-1, *q.shape)
    return np.column_stack([(function(q + way) - function(q - way)).ravel() / (2.0 * step) for way in units])


def least_way_to_a_jump(tangle: Tangle) -> float:
    """Return how near any pair is to where psi'' or friction's stiffness jumps [r]."""
    scene, q, _ = tangle
    law, pairs, points = scene.model.law, scene.pairs, scene.placed(q).points
    apart = points[scene.candidates.a] - points[scene.candidates.b]
    overlap = law.distance - np.linalg.norm(apart, axis=1)
    rest = np.abs(np.linalg.norm(scene.slips(q), axis=1) - law.slip)[pairs.load > 0.0]
    return float(min(np.abs(overlap - law.rounding).min(), rest.min(initial=1.0)))


@given(seed=SEEDS, friction=FRICTIONS, slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=40)
def test_gradient_against_differences_of_energy_over_decades(
    seed: int, friction: float, slide: float, edge: float
) -> None:
    now = tangle(seed, friction, slide, edge)
    gradient = now.gradient(now.q)
    way = np.random.default_rng(seed).normal(size=now.q.shape)
    way += gradient * np.linalg.norm(way) / np.linalg.norm(gradient)
    way /= np.linalg.norm(way)
    expected = float(np.vdot(gradient, way))
    steps = np.logspace(-2.5, -6.5, 9)
    differences = np.array([(now.energy(now.q + s * way) - now.energy(now.q - s * way)) / (2 * s) for s in steps])
    errors = np.abs(differences / expected - 1.0)
    assert errors.min() < 1e-8
    # Of first order where a pair begins to slide within the step: its stiffness jumps by mu load / slip.
    assert (errors < 0.3 * steps + 1e-9).all()


@given(seed=SEEDS, friction=FRICTIONS, slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=20)
def test_every_force_against_a_difference_of_energy(seed: int, friction: float, slide: float, edge: float) -> None:
    now = tangle(seed, friction, slide, edge)
    # A difference across a jump of the stiffness is of first order.
    assume(least_way_to_a_jump(now) > 4e-6)
    gradient = now.gradient(now.q)
    assert friction == 0.0 or np.abs(gradient[:, 3]).max() > 0.0
    units = np.eye(now.q.size).reshape(-1, *now.q.shape)
    slopes = [(now.energy(now.q + 2e-6 * way) - now.energy(now.q - 2e-6 * way)) / 4e-6 for way in units]
    np.testing.assert_allclose(gradient.ravel(), slopes, rtol=0.0, atol=1e-6 * np.abs(gradient).max())


@given(seed=SEEDS, slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=15)
def test_hessian_of_contact_is_exact(seed: int, slide: float, edge: float) -> None:
    now = tangle(seed, 0.0, slide, edge)
    assume(least_way_to_a_jump(now) > 4e-6)
    hessian = stiffness(now)
    np.testing.assert_array_equal(hessian, hessian.T)
    errors = [np.abs(jacobian(now.gradient, now.q, step) - hessian).max() for step in (2e-6, 1e-6, 5e-7)]
    assert min(errors) < 1e-6 * np.abs(hessian).max()


@given(seed=SEEDS, slide=SLIDES, edge=EDGES)
@settings(deadline=None, max_examples=20)
def test_hessian_of_friction_is_exact(seed: int, slide: float, edge: float) -> None:
    now = tangle(seed, 0.3, slide, edge)
    assume(least_way_to_a_jump(now) > 4e-6)
    hessian = stiffness(now)
    np.testing.assert_allclose(hessian, hessian.T, rtol=0.0, atol=ROUNDING * np.abs(hessian).max())
    errors = []
    for step in (2e-6, 1e-6, 5e-7):
        differences = jacobian(now.gradient, now.q, step)
        # Frames carried round a loop come back turned, so only the symmetric part is a second derivative.
        errors.append(np.abs(0.5 * (differences + differences.T) - hessian).max())
    assert min(errors) < 1e-6 * np.abs(hessian).max()


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=25)
def test_gauss_newton_stiffness_is_positive(seed: int, slide: float) -> None:
    values = np.linalg.eigvalsh(stiffness(tangle(seed, 0.3, slide, 2.0), exact=0.0))
    assert values[0] > -1e-12 * values[-1]


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=40)
def test_load_coupling_against_differences_of_friction_with_loads_that_follow(seed: int, slide: float) -> None:
    now = tangle(seed, 0.3, slide, 2.0)
    scene, q, _ = now
    scene.lag(q)
    assume(least_way_to_a_jump(now) > 4e-6)
    m = scene.model
    normal = scene.pairs.normal.copy()
    way = np.random.default_rng(seed).normal(size=q.shape)
    coupling = np.zeros_like(q)
    scene.gradient(q)
    add_load_coupling(scene.placed(q), scene.candidates, m.samples, m.law, scene.pairs, way, coupling)
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
    now = tangle(seed, 0.3, slide, 2.0)
    gradient = now.gradient(now.q)
    assert np.abs(gradient[:, :3].sum(axis=0)).max() < 1e-13 * max(1.0, np.abs(gradient).max() * len(now.q))


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=25)
def test_couples_of_friction_balance_but_for_the_approach_of_the_pairs(seed: int, slide: float) -> None:
    now = tangle(seed, 0.3, slide, 2.0)
    scene, q, frames = now
    gradient = now.gradient(q)
    moment = np.cross(q[:, :3], gradient[:, :3]).sum(axis=0) + (frames.tangent * gradient[:, 3:]).sum(axis=0)
    # The arm is the line between the centrelines as it was at the last equilibrium: it lacks what opened across.
    size = np.maximum(np.linalg.norm(scene.slips(q), axis=1), scene.model.law.slip)
    pull = (0.3 * scene.pairs.load / size)[:, None] * scene.slips(q)
    rest = np.cross(scene.openings(q), pull).sum(axis=0)
    assert np.abs(rest).max() > 0.0
    np.testing.assert_allclose(moment, rest, rtol=0.0, atol=1e-12)


@given(seed=SEEDS, slide=SLIDES, friction=FRICTIONS)
@settings(deadline=None, max_examples=25)
def test_moving_everything_moves_nothing(seed: int, slide: float, friction: float) -> None:
    now = tangle(seed, friction, slide, 2.0)
    away = now.q + np.array([3.0, -2.0, 5.0, 0.0])
    before = now.gradient(now.q)
    assert now.energy(away) == pytest.approx(now.energy(now.q), rel=1e-10)
    np.testing.assert_allclose(now.gradient(away), before, atol=1e-11 * np.abs(before).max())


@given(seed=SEEDS, slide=SLIDES)
@settings(deadline=None, max_examples=25)
def test_turning_everything_turns_the_forces(seed: int, slide: float) -> None:
    now = tangle(seed, 0.3, slide, 2.0)
    turn = Rotation.from_rotvec(np.random.default_rng(seed).uniform(-3.0, 3.0, 3))
    energy, gradient = now.energy(now.q), now.gradient(now.q)
    q, frames = now.q.copy(), now.frames.copy()
    for vectors in (q[:, :3], frames.tangent, frames.director, now.scene.pairs.normal):
        vectors[:] = turn.apply(vectors)
    gradient[:, :3] = turn.apply(gradient[:, :3])
    assert now.scene.energy(q, frames) == pytest.approx(energy, rel=1e-10)
    np.testing.assert_allclose(now.scene.gradient(q, frames), gradient, atol=1e-11 * np.abs(gradient).max())

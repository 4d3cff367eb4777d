"""Bonds: forces and stiffness against finite differences, and what rigid motion must not change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from knitlab_core.contact.bond_forces import bond_energy, bond_gradient, bond_hessian, bond_loads
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.contact.samples import sample_points
from knitlab_core.contact.slip import Placed, place_edges
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.pattern import make_pattern, multiply, update_pattern
from knitlab_core.rods.frames import follow
from tests.contact_scenes import POISSON_RATIO, straight
from tests.knitlab_core.sparse.blocks import touching

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.contact.bonds import Bonds
    from knitlab_core.equilibrium.model import Model, State
    from knitlab_core.rods.frames import Frames

SEEDS = st.integers(0, 2**32 - 1)
MOVES = st.sampled_from([0.0, 0.03, 0.3])
"""How far nodes are off the printed shape, and edges turned about themselves [r, rad]."""

LAW = BondLaw(fuse_gap=0.6, patch_radius=0.5, strength=0.03, shear_strength=0.02)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fused:
    """Three wavy rods fused where they cross, and where they are now; every trial is followed from `frames`."""

    model: Model
    printed: State
    bonds: Bonds
    q: FloatArray
    frames: Frames

    def placed(self, q: FloatArray, source: Frames | None = None) -> Placed:
        has_edge, samples = self.model.rods.has_edge, self.model.samples
        frames = self.frames.copy()
        follow(q, has_edge, self.frames if source is None else source, frames)
        found = Placed.zeros(len(q), len(q) * len(samples.weights))
        sample_points(q, samples, found.points)
        place_edges(q, has_edge, frames, self.bonds.frames, found)
        return found

    def energy(self, q: FloatArray, source: Frames | None = None) -> float:
        return bond_energy(self.placed(q, source), self.bonds, len(self.model.samples.weights))

    def gradient(self, q: FloatArray, source: Frames | None = None) -> FloatArray:
        out = np.zeros_like(q)
        bond_gradient(self.placed(q, source), self.bonds, self.model.samples.weights, out)
        return out

    def loads(self, q: FloatArray, source: Frames | None = None) -> FloatArray:
        out = np.zeros(self.bonds.a.size)
        bond_loads(self.placed(q, source), self.bonds, len(self.model.samples.weights), out)
        return out

    def stiffness(self, exact: float = 1.0) -> FloatArray:
        n = len(self.q)
        pattern = update_pattern(make_pattern(n, touching(), self.bonds), n, self.bonds)
        assert pattern is not None
        blocks = np.zeros((pattern.rows.size, 4, 4))
        bond_hessian(self.placed(self.q), self.bonds, self.model.samples.weights, exact, pattern, blocks)
        columns = []
        for unit in np.eye(self.q.size):
            column = np.zeros_like(self.q)
            multiply(pattern, blocks, unit.reshape(self.q.shape), column)
            columns.append(column.ravel())
        own = blocks[pattern.diagonal]
        np.testing.assert_allclose(own, own.transpose(0, 2, 1), rtol=0.0, atol=1e-14 * np.abs(blocks).max())
        return np.column_stack(columns)


def fused(seed: int, move: float) -> Fused:
    rng = np.random.default_rng(seed)
    strands = []
    for level in range(3):
        angle = 1.1 * level + rng.uniform(-0.3, 0.3)
        x = straight((0, 0, 2.3 * level), (np.cos(angle), np.sin(angle), 0), 12.0, 2.0)
        strands.append(x + rng.normal(0.0, 0.03, x.shape))
    model, state = make_model(
        strands, radius=1.0, young_modulus=1.0, poisson_ratio=POISSON_RATIO, friction=0.0, bonds=LAW
    )
    assert model.bonds is not None
    assert model.bonds.a.size == 2
    q = state.q.copy()
    q[:, :3] += move * rng.normal(0.0, 1.0, (len(q), 3))
    q[:, 3] += move * rng.normal(0.0, 1.0, len(q)) * model.rods.has_edge
    frames = state.frames.copy()
    follow(q, model.rods.has_edge, state.frames, frames)
    return Fused(model=model, printed=state, bonds=model.bonds, q=q, frames=frames)


def jacobian(function: Callable[[FloatArray], FloatArray], q: FloatArray, step: float) -> FloatArray:
    units = step * np.eye(q.size).reshape(-1, *q.shape)
    return np.column_stack([(function(q + way) - function(q - way)).ravel() / (2.0 * step) for way in units])


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=30)
def test_gradient_against_differences_of_energy_over_decades(seed: int, move: float) -> None:
    now = fused(seed, move)
    way = np.random.default_rng(seed).normal(size=now.q.shape)
    way /= np.linalg.norm(way)
    expected = float(np.vdot(now.gradient(now.q), way))
    steps = np.logspace(-2.0, -5.0, 7)
    errors = np.array([(now.energy(now.q + s * way) - now.energy(now.q - s * way)) / (2 * s) for s in steps]) - expected
    # Central differences: of second order until rounding.
    assert (np.abs(errors) < 3.0 * steps**2 + 1e-10).all()


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=15)
def test_every_force_against_a_difference_of_energy(seed: int, move: float) -> None:
    now = fused(seed, move)
    units = np.eye(now.q.size).reshape(-1, *now.q.shape)
    slopes = [(now.energy(now.q + 1e-5 * way) - now.energy(now.q - 1e-5 * way)) / 2e-5 for way in units]
    np.testing.assert_allclose(now.gradient(now.q).ravel(), slopes, rtol=0.0, atol=1e-9)


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=15)
def test_hessian_is_symmetric_and_exact(seed: int, move: float) -> None:
    now = fused(seed, move)
    hessian = now.stiffness()
    size = np.abs(hessian).max()
    np.testing.assert_allclose(hessian, hessian.T, rtol=0.0, atol=1e-14 * size)
    differences = jacobian(now.gradient, now.q, 1e-5)
    # Frames carried round a loop come back turned, so only the symmetric part is a second derivative.
    assert np.abs(0.5 * (differences + differences.T) - hessian).max() < 1e-7 * size


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=15)
def test_gauss_newton_stiffness_is_positive(seed: int, move: float) -> None:
    values = np.linalg.eigvalsh(fused(seed, move).stiffness(exact=0.0))
    assert values[0] > -1e-12 * values[-1]


@given(seed=SEEDS)
@settings(deadline=None, max_examples=10)
def test_a_bond_resists_every_motion_of_one_strand_against_the_other(seed: int) -> None:
    now = fused(seed, 0.0)
    first = now.bonds.held(np.array([1.0, 0.0]))
    alone = Fused(model=now.model, printed=now.printed, bonds=first, q=now.q, frames=now.frames)
    values = np.linalg.eigvalsh(alone.stiffness())
    # Three displacements and three turns of the two ends of a bond, and nothing else.
    assert np.count_nonzero(values > 1e-9) == 6
    assert np.abs(values[:-6]).max() < 1e-12


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=25)
def test_action_is_reaction_in_forces_and_moments(seed: int, move: float) -> None:
    now = fused(seed, move)
    gradient = now.gradient(now.q)
    moment = np.cross(now.q[:, :3], gradient[:, :3]).sum(axis=0)
    moment += (now.frames.tangent * gradient[:, 3:]).sum(axis=0)
    size = max(1e-6, float(np.abs(gradient).max()))
    assert np.abs(gradient[:, :3].sum(axis=0)).max() < 1e-12 * size
    assert np.abs(moment).max() < 1e-11 * size


@given(seed=SEEDS, move=MOVES)
@settings(deadline=None, max_examples=25)
def test_turning_everything_turns_the_forces_and_changes_no_load(seed: int, move: float) -> None:
    now = fused(seed, move)
    turn = Rotation.from_rotvec(np.random.default_rng(seed).uniform(-3.0, 3.0, 3))
    energy, gradient, loads = now.energy(now.q), now.gradient(now.q), now.loads(now.q)
    q, frames = now.q.copy(), now.frames.copy()
    for vectors in (q[:, :3], frames.tangent, frames.director):
        vectors[:] = turn.apply(vectors)
    q[:, :3] += (3.0, -2.0, 5.0)
    gradient[:, :3] = turn.apply(gradient[:, :3])
    assert now.energy(q, frames) == pytest.approx(energy, rel=1e-10, abs=1e-24)
    np.testing.assert_allclose(now.gradient(q, frames), gradient, atol=1e-12)
    np.testing.assert_allclose(now.loads(q, frames), loads, rtol=1e-9, atol=1e-11)


@given(seed=SEEDS)
@settings(deadline=None, max_examples=10)
def test_printed_strands_bear_nothing(seed: int) -> None:
    now = fused(seed, 0.0)
    assert now.energy(now.q) < 1e-28
    assert np.abs(now.gradient(now.q)).max() < 1e-14
    assert now.loads(now.q).max() < 1e-11

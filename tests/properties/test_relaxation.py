"""What a step of relaxing rods must obey, whatever their shape, history and duration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.rods.relaxation import (
    Relaxation,
    hold_steps,
    relaxed_rods,
    remember,
    rod_strains,
    stored_energy,
    viscous_work,
)
from knitlab_core.rods.rod import Rods, make_rods

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

PRONY = Relaxation(np.array([0.3, 0.2, 0.1]), np.array([0.01, 1.0, 100.0]))
SIZES = (7, 5)
seeds = st.integers(0, 2**32 - 1)
durations = st.one_of(st.just(0.0), st.floats(1e-9, 1e6))


def random_rods(seed: int) -> tuple[np.random.Generator, Rods, Frames, Array]:
    """Make two random walks, straight or as printed; return them and their configuration."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.uniform([1.2, -0.8, -0.8], [2.8, 0.8, 0.8], size=(sum(SIZES), 3)), axis=0)
    rods, frames = make_rods(walk, SIZES, poisson_ratio=0.3, straight=bool(seed % 2))
    return rng, rods, frames, np.column_stack([walk, np.zeros(len(walk))])


def moved(rng: np.random.Generator, q: Array, rods: Rods, frames: Frames, size: float) -> tuple[Array, Frames]:
    there = q + size * rng.uniform(-1.0, 1.0, size=q.shape)
    new = Frames.zeros(len(q))
    follow(there, rods.has_edge, frames, new)
    return there, new


def random_history(rng: np.random.Generator, strain: Array) -> Array:
    return np.asarray(rng.uniform(-0.05, 0.05, size=(PRONY.shares.size, *strain.shape)) * (strain != 0.0))


def potential(rods: Rods, before: Array, history: Array, after: Array, duration: float) -> float:
    """Return the energy whose slope in the strains is the stress at the end of a step."""
    kept = remember(PRONY, history, before, after, duration)
    gain = remember(PRONY, 0.0 * history, 0.0 * before, 0.0 * before + 1.0, duration)
    part = stored_energy(rods, PRONY, after, kept / np.sqrt(gain))
    return float(part.sum())


@settings(max_examples=30, deadline=None)
@given(seed=seeds, duration=st.floats(0.0, 1e4))
def test_the_rods_of_a_step_have_its_stress(seed: int, duration: float) -> None:
    rng, rods, frames, q = random_rods(seed)
    begin, at_begin = moved(rng, q, rods, frames, 0.2)
    before = rod_strains(begin, rods, at_begin)
    history = random_history(rng, before)
    step = relaxed_rods(rods, PRONY, before, history, duration)
    end, at_end = moved(rng, begin, rods, at_begin, 0.1)
    gradient = np.zeros_like(q)
    rod_gradient(end, step, at_end, gradient)
    way = rng.normal(size=q.shape) * np.append(rods.has_edge, 1)[: len(q), None]
    way[:, :3] = rng.normal(size=(len(q), 3))

    def value(h: float) -> tuple[float, float]:
        there, new = end + h * way, Frames.zeros(len(q))
        follow(there, rods.has_edge, at_end, new)
        strain = rod_strains(there, rods, new)
        return potential(rods, before, history, strain, duration), sum(rod_energy(there, step, new))

    (up, up_step), (down, down_step) = value(1e-5), value(-1e-5)
    slope = float(np.vdot(gradient, way))
    scale = float(np.abs(gradient * way).sum())
    assert (up - down) / 2e-5 == pytest.approx(slope, abs=1e-7 * scale)
    # The two energies differ by a constant alone.
    assert up_step - down_step == pytest.approx(up - down, abs=1e-12 * max(up, up_step))


@settings(max_examples=50, deadline=None)
@given(seed=seeds, duration=durations, cut=st.floats(0.01, 0.99))
def test_a_step_is_its_two_parts(seed: int, duration: float, cut: float) -> None:
    rng, rods, frames, q = random_rods(seed)
    before, after = (rod_strains(*pair) for pair in _two(rng, q, rods, frames))
    history = random_history(rng, before)
    middle = before + cut * (after - before)
    first = remember(PRONY, history, before, middle, cut * duration)
    second = remember(PRONY, first, middle, after, (1.0 - cut) * duration)
    whole = remember(PRONY, history, before, after, duration)
    np.testing.assert_allclose(second, whole, rtol=0.0, atol=1e-14)
    lost = viscous_work(rods, PRONY, history, before, middle, cut * duration)
    lost += viscous_work(rods, PRONY, first, middle, after, (1.0 - cut) * duration)
    stored = float(stored_energy(rods, PRONY, before, history).sum() + stored_energy(rods, PRONY, after, whole).sum())
    # A series of brief steps drops a ten-thousandth of what they lose, itself a ten-thousandth of what is stored.
    assert viscous_work(rods, PRONY, history, before, after, duration) == pytest.approx(lost, abs=1e-8 * stored)
    assert lost >= -1e-12 * stored


def _two(rng: np.random.Generator, q: Array, rods: Rods, frames: Frames) -> list[tuple[Array, Rods, Frames]]:
    begin, at_begin = moved(rng, q, rods, frames, 0.2)
    end, at_end = moved(rng, begin, rods, at_begin, 0.1)
    return [(begin, rods, at_begin), (end, rods, at_end)]


@pytest.mark.parametrize("duration", [1e-3, 1.0, 30.0])
def test_work_is_stored_or_lost(duration: float) -> None:
    # One span alone: the integral of its force over its stretch, by the midpoint rule.
    prony = Relaxation(np.array([0.3, 0.2, 0.1]), np.array([0.1, 1.0, 10.0]))
    rods, _ = make_rods(np.outer(np.arange(3.0), [2.0, 0.0, 0.0]), (3,), poisson_ratio=0.3)
    before, after = np.zeros((3, 5)), np.zeros((3, 5))
    before[1, 0], after[1, 0] = 0.02, -0.03
    history = np.zeros((3, 3, 5))
    history[:, 1, 0] = [0.01, -0.02, 0.015]
    steps, work = 4000, 0.0
    for share in (np.arange(steps) + 0.5) / steps:
        strain = before + share * (after - before)
        kept = remember(prony, history, before, strain, share * duration)[:, 1, 0]
        stress = np.pi * (prony.lasting * strain[1, 0] + prony.shares @ kept)
        work += stress * -0.05 * 2.0 / steps
    kept = remember(prony, history, before, after, duration)
    grown = stored_energy(rods, prony, after, kept) - stored_energy(rods, prony, before, history)
    lost = viscous_work(rods, prony, history, before, after, duration)
    assert work == pytest.approx(grown.sum() + lost, abs=1e-5 * np.abs(grown).sum())


def test_a_sudden_step_is_elastic_and_a_slow_one_relaxed() -> None:
    _, rods, _, q = random_rods(1)
    none, history = np.zeros((len(q), 5)), PRONY.unstrained(len(q))
    for duration, share in ((0.0, 1.0), (1e12, 0.4)):
        step = relaxed_rods(rods, PRONY, none, history, duration)
        np.testing.assert_allclose(step.stretch_stiffness, share * rods.stretch_stiffness, rtol=1e-9)
        np.testing.assert_allclose(step.bend_stiffness, share * rods.bend_stiffness, rtol=1e-9)
        np.testing.assert_allclose(step.twist_stiffness, share * rods.twist_stiffness, rtol=1e-9)
        np.testing.assert_array_equal(step.rest_stretch, rods.rest_stretch)
        np.testing.assert_array_equal(step.rest_curvature, rods.rest_curvature)


@pytest.mark.parametrize("duration", [1e-6, 0.3, 1e5])
def test_the_steps_of_a_hold(duration: float) -> None:
    steps = np.array(hold_steps(PRONY, duration))
    assert steps.sum() == pytest.approx(duration)
    assert steps[0] <= 0.1 * PRONY.times.min() * (1.0 + 1e-12)
    np.testing.assert_allclose(steps[1:] / steps[:-1], 1.5)
    assert len(steps) < 50
    assert hold_steps(None, duration) == (duration,)

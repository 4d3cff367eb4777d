"""What derivatives, energies and frames of rods must obey, whatever the shape."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.pattern import make_pattern, multiply
from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.rods.rod import Rods, make_rods
from knitlab_core.rods.rupture import cut_rods
from knitlab_core.rods.stiffness import rod_hessian

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

seeds = st.integers(0, 2**32 - 1)


class Rod(NamedTuple):
    """Two rods in one array, far from their rest shape."""

    rods: Rods
    q: Array
    frames: Frames


def at(rod: Rod, q: Array) -> Frames:
    """Return the frames of `q` carried from those of the rod."""
    frames = Frames.zeros(len(q))
    follow(q, rod.rods.has_edge, rod.frames, frames)
    return frames


def random_rod(seed: int, *, straight: bool = False, strain: float = 0.3, sizes: tuple[int, ...] = (9, 6)) -> Rod:
    """Make two random walks that bend by up to 90 degrees at a node; move their nodes by `strain`, and turn edges.

    Every other seed cuts the second after its first edge, which then is all there is of a rod.
    """
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.uniform([1.2, -0.8, -0.8], [2.8, 0.8, 0.8], size=(sum(sizes), 3)), axis=0)
    rods, frames = make_rods(walk, sizes, poisson_ratio=rng.uniform(0.0, 0.5), straight=straight)
    if seed % 2:
        rods = cut_rods(rods, sizes[0] + 1)
    q = np.column_stack([walk, np.zeros(len(walk))])
    rest = Rod(rods, q, frames)
    q = q + strain * rng.uniform(-1.0, 1.0, size=q.shape)
    return rest._replace(q=q, frames=at(rest, q))


def energy(rod: Rod, q: Array) -> float:
    return float(sum(rod_energy(q, rod.rods, at(rod, q))))


def gradient(rod: Rod, q: Array) -> Array:
    g = np.zeros_like(q)
    rod_gradient(q, rod.rods, at(rod, q), g)
    return g


def hessian(rod: Rod, exact: float) -> Array:
    """Return the stiffness (4N, 4N), column by column."""
    n = len(rod.q)
    none = np.zeros(0, dtype=np.int64)
    pattern = make_pattern(n, Candidates(none, none, np.zeros(1, dtype=np.int64), none, none))
    blocks = np.zeros((pattern.rows.size, 4, 4))
    rod_hessian(rod.q, rod.rods, rod.frames, exact, pattern, blocks)
    columns = np.zeros((4 * n, n, 4))
    for k, column in enumerate(columns):
        multiply(pattern, blocks, np.eye(4 * n)[k].reshape(n, 4), column)
    return np.asarray(columns.reshape(4 * n, 4 * n).T)


def slopes(rod: Rod, function: Callable[[Rod, Array], Array | float], h: float) -> Array:
    """Return central differences of a function in every unknown, as columns."""
    units = h * np.eye(rod.q.size).reshape(-1, *rod.q.shape)
    return np.stack(
        [np.ravel(np.subtract(function(rod, rod.q + u), function(rod, rod.q - u))) / (2.0 * h) for u in units], axis=1
    )


def check_decades(exact: Array, difference: Callable[[float], Array]) -> None:
    """Check that central differences err by h², then by rounding over h."""
    steps = 10.0 ** np.arange(-1.0, -11.5, -0.5)
    errors = np.array([np.linalg.norm(difference(h) - exact) for h in steps]) / np.linalg.norm(exact)
    best = int(errors.argmin())
    assert errors[best] < 1e-8
    # From a hundredth of an edge down to where rounding begins to show.
    falling = (steps < 2e-2) & (errors > 1e2 * errors[best]) & (np.arange(steps.size) < best)
    assert falling.sum() >= 3
    assert np.polyfit(np.log(steps[falling]), np.log(errors[falling]), 1)[0] == pytest.approx(2.0, abs=0.1)
    # Rounding: below a constant over h, and well above the best.
    rising = steps < 0.1 * steps[best]
    assert errors[rising].max() > 10.0 * errors[best]
    assert (errors[rising] * steps[rising]).max() < 1e-12


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_gradient_is_the_slope_of_the_energy(seed: int, *, straight: bool) -> None:
    rod = random_rod(seed, straight=straight)
    check_decades(gradient(rod, rod.q).reshape(1, -1), lambda h: slopes(rod, energy, h))


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_hessian_is_the_slope_of_the_gradient(seed: int, *, straight: bool) -> None:
    rod = random_rod(seed, straight=straight)

    def symmetric_slopes(h: float) -> Array:
        # Frames carried along two ways differ by the solid angle between them: the slopes of the
        # gradient have an antisymmetric part, the Hessian of the energy has none.
        found = slopes(rod, gradient, h)
        return np.asarray(0.5 * (found + found.T))

    check_decades(hessian(rod, 1.0), symmetric_slopes)


@settings(max_examples=25, deadline=None)
@given(seed=seeds, straight=st.booleans())
def test_hessian_entry_by_entry(seed: int, *, straight: bool) -> None:
    rod = random_rod(seed, straight=straight)
    found, exact = slopes(rod, gradient, 1e-5), hessian(rod, 1.0)
    np.testing.assert_allclose(exact, 0.5 * (found + found.T), atol=1e-7 * np.abs(exact).max())


@settings(max_examples=50, deadline=None)
@given(seed=seeds, exact=st.sampled_from([0.0, 0.5, 1.0]))
def test_hessian_is_symmetric(seed: int, exact: float) -> None:
    matrix = hessian(random_rod(seed), exact)
    np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-14 * np.abs(matrix).max())


@settings(max_examples=50, deadline=None)
@given(seed=seeds, straight=st.booleans(), strain=st.floats(0.0, 0.5))
def test_gauss_newton_is_positive_semidefinite(seed: int, strain: float, *, straight: bool) -> None:
    values = np.linalg.eigvalsh(hessian(random_rod(seed, straight=straight, strain=strain), 0.0))
    assert values[0] > -1e-13 * values[-1]


@settings(max_examples=50, deadline=None)
@given(seed=seeds)
def test_printed_state_is_free_of_stress(seed: int) -> None:
    rod = random_rod(seed, strain=0.0)
    assert sum(rod_energy(rod.q, rod.rods, rod.frames)) < 1e-25
    assert np.abs(gradient(rod, rod.q)).max() < 1e-13
    # There the exact second derivatives of the strains multiply nothing.
    np.testing.assert_allclose(hessian(rod, 1.0), hessian(rod, 0.0), atol=1e-12)


def turned(x: Array, axis: Array, angle: float) -> Array:
    """Turn rows of vectors about a unit axis (Rodrigues)."""
    along = np.outer(x @ axis, axis)
    return np.asarray(along + np.cos(angle) * (x - along) + np.sin(angle) * np.cross(axis, x))


@settings(max_examples=50, deadline=None)
@given(seed=seeds, angle=st.floats(-3.0, 3.0))
def test_energy_does_not_see_a_rigid_motion(seed: int, angle: float) -> None:
    rod = random_rod(seed)
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    q = rod.q.copy()
    q[:, :3] = turned(q[:, :3], axis, angle) + np.array([1.0, -2.0, 3.0])
    frames = rod.frames._replace(
        tangent=turned(rod.frames.tangent, axis, angle), director=turned(rod.frames.director, axis, angle)
    )
    before, after = rod_energy(rod.q, rod.rods, rod.frames), rod_energy(q, rod.rods, frames)
    np.testing.assert_allclose(after, before, rtol=1e-11)


@settings(max_examples=50, deadline=None)
@given(seed=seeds)
def test_forces_and_moments_are_in_balance(seed: int) -> None:
    rod = random_rod(seed)
    g = gradient(rod, rod.q)
    scale = np.abs(g).max() * np.abs(rod.q).max() * len(g)
    for part in (slice(0, 9), slice(9, 15)):
        force, torque = g[part, :3], g[part, 3]
        assert np.abs(force.sum(axis=0)).max() < 1e-14 * scale
        # The moment on an edge's angle acts along the edge.
        moment = np.cross(rod.q[part, :3], force).sum(axis=0) + torque @ rod.frames.tangent[part]
        assert np.abs(moment).max() < 1e-14 * scale


def test_a_rod_turned_in_small_steps_stays_free_of_stress() -> None:
    rod = random_rod(5, strain=0.0)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    errors = []
    for count in (500, 1000):
        frames, step = rod.frames.copy(), 3.0 / count
        q = rod.q.copy()
        for k in range(1, count + 1):
            q[:, :3] = turned(rod.q[:, :3], axis, k * step)
            # An edge of a turning body spins about itself by its share of the turn.
            q[:, 3] = rod.rods.has_edge * (rod.frames.tangent @ axis) * k * step
            follow(q, rod.rods.has_edge, frames.copy(), frames)
        errors.append(sum(rod_energy(q, rod.rods, frames)))
    # Each step follows a great circle instead of the turn: an angle of h², an energy of h⁴.
    assert errors[1] < 1e-9
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.05)


def test_frames_stay_orthonormal_after_thousands_of_steps() -> None:
    rod = random_rod(3)
    rng = np.random.default_rng(3)
    q, frames = rod.q.copy(), rod.frames.copy()
    edges = rod.rods.has_edge
    for _ in range(5000):
        q += 0.05 * rng.normal(size=q.shape) - 0.02 * (q - rod.q)
        follow(q, edges, frames.copy(), frames)
    tangent, director = frames.tangent[edges], frames.director[edges]
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(director, axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose((tangent * director).sum(axis=1), 0.0, atol=1e-15)
    np.testing.assert_allclose(np.diff(q[:, :3], axis=0)[edges[:-1]], tangent * frames.length[edges, None], atol=1e-13)

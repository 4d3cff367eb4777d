"""Strands never pass through each other, however far the fixtures are told to go in one step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError
from tests.contact_scenes import sampled, straight, unit_model
from tests.linking import linking_number

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import Model, State

Ends = slice | list[int]

LENGTH = 40.0
HEIGHT = 2.2
SOURCE = "solids do not interpenetrate"

HELD: dict[str, tuple[Ends, Ends]] = {
    "both everywhere": (slice(None), slice(None)),
    "one at its ends": ([0, 1, -2, -1], slice(None)),
    "both at their ends": ([0, 1, -2, -1], [0, 1, -2, -1]),
}
"""Which nodes of the lower and of the upper strand are prescribed."""


def crossing(held: str, friction: float) -> tuple[Workspace, State, int]:
    """Return two strands crossed at right angles, not yet touching, and the number of nodes of the lower one."""
    lower = straight((0, 0, 0), (1, 0, 0), LENGTH)
    upper = straight((0.1, 0, HEIGHT), (0.1, 1, 0), LENGTH)
    model, state = unit_model([lower, upper], friction=friction)
    first, second = HELD[held]
    model.fixed[: len(lower)][first] = True
    model.fixed[len(lower) :][second] = True
    return Workspace(model), state, len(lower)


def least_distance(model: Model, state: State) -> float:
    """Return the least distance [r] between samples of different strands."""
    m = len(model.samples.weights)
    points = sampled(model, state.q).reshape(-1, m, 3)
    strand = model.samples.strand[model.samples.spans]
    first, second = (points[model.samples.spans[strand == k]].reshape(-1, 3) for k in (0, 1))
    return float(np.sqrt(((first[:, None] - second[None]) ** 2).sum(axis=2)).min())


def apart(model: Model, state: State) -> bool:
    """Return whether no sample is inside another strand's core."""
    return least_distance(model, state) > model.law.distance - model.law.overlap_limit


def order(state: State, lower: int) -> float:
    """Return how far the middle of the upper strand is above that of the lower [r]."""
    upper = len(state.q) - lower
    return float(state.q[lower + upper // 2, 2] - state.q[lower // 2, 2])


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("way", [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 20.0])
def test_one_step_never_jumps_through(held: str, way: float) -> None:
    work, state, lower = crossing(held, 0.3)
    target = state.q.copy()
    target[lower:, 2] -= way
    found, _ = advance(work, state, target)
    if found is not None:
        assert order(found, lower) > 0.0
        assert apart(work.model, found)
        assert np.isfinite(found.energies).all()


def test_prescribed_strands_stop_before_they_meet_cores() -> None:
    work, state, lower = crossing("both everywhere", 0.0)
    start = state.q.copy()

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[lower:, 2] -= 10.0 * s
        return target

    seen = [state]
    with pytest.raises(ConvergenceError):
        seen.extend(found for _, found, _ in march(work, state, path, longest=1.0))
    assert all(apart(work.model, found) and order(found, lower) > 0.0 for found in seen)
    # It got as far as the barrier lets it: cores touch at half of D.
    assert 1.0 < order(seen[-1], lower) < 1.2


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_pushed_strands_carry_each_other(bar: Callable[..., None], friction: float) -> None:
    # Sixteen radii, in what is asked for as one step: the march has to cut it.
    work, state, lower = crossing("both at their ends", friction)
    start = state.q.copy()

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[lower:, 2] -= 16.0 * s
        return target

    least = np.inf
    for _, found, _ in march(work, state, path, longest=1.0):
        state = found
        assert order(found, lower) > 0.0
        least = min(least, least_distance(work.model, found))
    assert np.abs(state.q - path(1.0))[work.model.fixed].max() == pytest.approx(0.0, abs=1e-12)
    assert np.abs(state.reaction[:lower, 2].sum()) > 0.01
    bar(
        f"no crossing, strands pushed 16 r past touch, mu = {friction}: deepest overlap over the core's",
        figure=(2.0 - least) / work.model.law.overlap_limit,
        limit=1.0,
        unit="1",
        source=SOURCE,
    )


def ring(centre: tuple[float, float, float], normal: str, opening: float) -> FloatArray:
    """Return the nodes of a ring of radius 8 r, open at an angle [rad]; its two ends nearly meet there."""
    t = opening + np.linspace(0.0, 2.0 * np.pi, 26)[:-1] + np.pi / 25
    x, y = 8.0 * np.cos(t), 8.0 * np.sin(t)
    z = np.zeros_like(t)
    return np.asarray(centre) + np.column_stack((x, y, z) if normal == "z" else (x, z, y))


def test_linked_rings_stay_linked() -> None:
    rings = [ring((-4, 0, 0), "z", np.pi), ring((4, 0, 0), "y", 0.0)]
    model, state = unit_model(rings, friction=0.3)
    count = len(rings[0])
    # Each is held where it is open, at its far side.
    held = [0, 1, -2, -1]
    for part in (model.fixed[:count], model.fixed[count:]):
        part[held] = True
    work = Workspace(model)
    start = state.q.copy()
    linked = linking_number(start[:count, :3], start[count:, :3])
    last = state
    assert abs(linked) == pytest.approx(1.0)

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[count:, 0] += 120.0 * s
        return target

    for _, found, _ in march(work, state, path, longest=0.25):
        assert linking_number(found.q[:count, :3], found.q[count:, :3]) == pytest.approx(linked)
        assert apart(model, found)
        last = found
    # Stretched to several times their length, they still hang in each other.
    assert last.contacts > 0
    assert last.reaction[count:, 0].sum() > 1.0

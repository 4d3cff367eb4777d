"""Twist makes a ring and a column buckle: where the stiffness stops being positive definite."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.validation.bare_rod import EI, bare_rod, settle, stiffness

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.workspace import Workspace

EDGES = 96
POISSON_RATIO = 0.3


def critical_twist(
    work: Workspace, state: State, free: NDArray[np.float64], bracket: tuple[float, float]
) -> tuple[float, State]:
    """Return the twist [rad] of the last edge where the stiffness of free motions turns singular, and the state.

    `free` (4N, n) has the free motions as columns.
    """
    last = state

    def smallest(angle: float) -> float:
        nonlocal last
        target = last.q.copy()
        target[-2, 3] = angle
        last = settle(work, last, target)
        return float(np.linalg.eigvalsh(free.T @ stiffness(work, last) @ free)[0])

    twist = float(brentq(smallest, *bracket, rtol=1e-5))
    smallest(twist)
    return twist, last


def free_motions(work: Workspace) -> NDArray[np.float64]:
    """Return the unit motions (4N, n) of the free unknowns."""
    fixed = work.model.fixed
    return np.asarray(np.eye(fixed.size)[:, ~fixed.ravel()])


def twisted_ring(poisson_ratio: float, radius: float = 200.0) -> tuple[Workspace, State]:
    """Make a ring of a naturally straight rod whose last edge lies clamped on its first."""
    angle = 2.0 * np.pi * (np.arange(EDGES + 2) - 0.5) / EDGES
    work, state = bare_rod(
        radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)]),
        straight=True,
        poisson_ratio=poisson_ratio,
    )
    work.model.fixed[[0, 1, -2, -1], :3] = True
    work.model.fixed[[0, -2], 3] = True
    return work, settle(work, state, state.q)


@pytest.mark.parametrize("angle", [0.0, 5.0])
def test_ring_rolls_for_nothing(angle: float) -> None:
    work, state = twisted_ring(POISSON_RATIO)
    target = state.q.copy()
    target[-2, 3] = angle
    state = settle(work, state, target)
    # All sections turn about the centreline, while the ring turns back about the clamped edge.
    x, tangent = state.q[:, :3], state.frames.tangent
    axis = tangent[0]
    roll = np.column_stack([np.cross(axis, x - x[0]), tangent @ axis - 1.0])
    roll[-1, 3] = 0.0
    force = stiffness(work, state) @ roll.ravel() / np.linalg.norm(roll)
    # The smallest eigenvalues of the ring with its roll held are near 1e-9.
    assert np.abs(force[~work.model.fixed.ravel()]).max() < 1e-13


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.5])
def test_michell(bar: Callable[..., None], poisson_ratio: float) -> None:
    work, state = twisted_ring(poisson_ratio)
    # The roll above costs nothing, so holding one node in the plane stops it and takes nothing away.
    work.model.fixed[1 + EDGES // 2, 2] = True
    theory = 2.0 * np.pi * np.sqrt(3.0) * (1.0 + poisson_ratio)
    twist, state = critical_twist(work, state, free_motions(work), (0.8 * theory, 1.2 * theory))
    assert np.abs(state.q[:, 2]).max() < 1e-6
    bar(
        f"Michell ring, ν = {poisson_ratio:g}, {EDGES} edges: twist at buckling",
        figure=twist / theory - 1.0,
        limit=0.01,
        unit="1",
        source="Michell 1889; Goriely 2006: 2π√3 EI/GJ",
    )


def stretched_column(tension: float, length: float = 400.0) -> tuple[Workspace, State]:
    """Make a straight rod with both end edges held, under a tension [EI/L²]."""
    # Held edges keep their direction up to their middles, between which the length counts.
    edge = length / (EDGES - 1)
    nodes = np.zeros((EDGES + 1, 3))
    nodes[:, 0] = edge * np.arange(EDGES + 1)
    work, state = bare_rod(nodes, poisson_ratio=POISSON_RATIO)
    work.model.fixed[[0, 1, -2, -1], :3] = True
    work.model.fixed[[0, -2], 3] = True
    target = state.q.copy()
    target[-2:, 0] += tension * EI / length**2 / np.pi * (length - edge)
    return work, settle(work, state, target)


def moment_and_tension(state: State) -> tuple[float, float]:
    """Return ML/2EI and TL²/EI from the reactions at the far end."""
    length = 0.5 * float(state.q[-1, 0] + state.q[-2, 0] - state.q[1, 0] - state.q[0, 0])
    return float(state.reaction[-2, 3]) * length / (2.0 * EI), float(state.reaction[-2:, 0].sum()) * length**2 / EI


@pytest.mark.parametrize("tension", [0.0, 10.0, 40.0])
def test_greenhill(bar: Callable[..., None], tension: float) -> None:
    """Hold the tangents, and leave the far end free to move sideways.

    Small deflections u = y + iz obey EI u‴ − iM u″ − T u′ = side force. It vanishes at an end free to
    move sideways, so that u′ = exp(ip₁x) − exp(ip₂x), EI p² − M p + T = 0; held tangents, u′(0) = u′(L) = 0,
    ask for (p₁ − p₂) L = 2π, which is Greenhill's formula. (His hinges carry a moment of fixed axis.)
    """
    work, state = stretched_column(tension)
    aside = np.zeros((2, *state.q.shape))
    aside[0, -2:, 1] = aside[1, -2:, 2] = 1.0
    free = np.column_stack([free_motions(work), aside.reshape(2, -1).T])
    guess = 2.0 * np.sqrt(np.pi**2 + tension) * (1.0 + POISSON_RATIO)
    _, state = critical_twist(work, state, free, (0.8 * guess, 1.2 * guess))
    moment, reached = moment_and_tension(state)
    assert reached == pytest.approx(tension, rel=1e-3, abs=1e-9)
    bar(
        f"Greenhill, TL²/EI = {tension:g}: moment at buckling",
        figure=moment / np.sqrt(np.pi**2 + reached) - 1.0,
        limit=0.01,
        unit="1",
        source="Greenhill 1883: (M/2EI)² = π²/L² + T/EI",
    )


def test_column_with_both_ends_clamped(bar: Callable[..., None]) -> None:
    work, state = stretched_column(0.0)
    # The side forces no longer vanish: tan(ML/2EI) = ML/2EI instead of sin = 0.
    theory = brentq(lambda m: np.tan(m) - m, 4.4, 4.6)
    guess = 2.0 * theory * (1.0 + POISSON_RATIO)
    _, state = critical_twist(work, state, free_motions(work), (0.8 * guess, 1.2 * guess))
    moment, _ = moment_and_tension(state)
    bar(
        "twisted column, both ends clamped: moment at buckling",
        figure=moment / theory - 1.0,
        limit=0.01,
        unit="1",
        source="small deflections: tan(ML/2EI) = ML/2EI",
    )

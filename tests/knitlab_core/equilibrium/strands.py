"""Small models: a straight strand clamped at its ends, and two that cross."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.model import Model, State, make_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

POISSON_RATIO = 0.3


def _made(strands: Sequence[NDArray[np.float64]], friction: float) -> tuple[Model, State]:
    return make_model(strands, radius=1e-3, young_modulus=1e9, poisson_ratio=POISSON_RATIO, friction=friction)


def strand(nodes: int = 11) -> tuple[Model, State]:
    """Make a strand along x, 20 radii long, both of its ends clamped (two nodes and the angle)."""
    line = np.zeros((nodes, 3))
    line[:, 0] = np.linspace(0.0, 20e-3, nodes)
    model, state = _made([line], 0.0)
    model.fixed[[0, 1, -2, -1]] = True
    return model, state


def stretched(state: State, strain: float) -> NDArray[np.float64]:
    """Return the target (N, 4) that stretches a strand evenly."""
    q = state.q.copy()
    q[:, 0] *= 1.0 + strain
    return q


def crossing(gap: float, friction: float = 0.3) -> tuple[Model, State]:
    """Make a strand along x, and one along y above it, clear of it by `gap` radii; ends clamped."""
    line = np.linspace(-8e-3, 8e-3, 17)
    none = np.zeros(17)
    lower = np.column_stack([line, none, none])
    upper = np.column_stack([none, line, none + (2.0 + gap) * 1e-3])
    model, state = _made([lower, upper], friction)
    model.fixed[[0, 1, 15, 16, 17, 18, 32, 33]] = True
    return model, state

"""A printed arc pulled straight: what it gives when it unbends is its stretch, and none of its nodes' polygon."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from knitlab_core.knits.mesh import control_points
from tests.validation.bare_rod import EI, bare_rod, settle

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

EA = np.pi
RADIUS, ANGLE = 8.0, 2.5
LENGTH = RADIUS * ANGLE
EDGES = 12
"""Of 1.7 r, turning by 12 degrees: the mesh of a knit's loops. Their polygon is 0.36 % longer than the arc."""


def printed_arc(edges: int) -> NDArray[np.float64]:
    """Return the nodes of an arc in the x-y plane, symmetric about y, that control the printed curve."""
    turn = ANGLE * (np.linspace(0.0, 1.0, edges + 1) - 0.5)
    return control_points(RADIUS * np.column_stack([np.sin(turn), np.cos(turn), 0.0 * turn]))


def test_a_printed_arc_held_straight_is_a_bar_of_its_arc_length(bar: Callable[..., None]) -> None:
    work, state = bare_rod(printed_arc(EDGES))
    work.model.fixed[:, 1:] = True
    work.model.fixed[[0, -1], 0] = True
    strain = 0.02
    for share in (0.25, 0.5, 0.75, 1.0):
        target = state.q.copy()
        target[:, 1] += share * (0.0 - target[:, 1])
        line = (1.0 + strain) * LENGTH * (np.linspace(0.0, 1.0, EDGES + 1) - 0.5)
        target[:, 0] += share * (line - target[:, 0])
        state = settle(work, state, target)
    force = 0.5 * (state.reaction[-1, 0] - state.reaction[0, 0])
    source = "Hooke: EA times extension beyond the printed arc"
    bar("printed arc held straight at 2 %: force", force / (EA * strain) - 1.0, 0.01, "1", source)


def arc_force(gap: float) -> float:
    """Return the tension T at a distance of the ends from EI θ″ = T sin θ, θ′ = 1/R at both, gap = ∫ (1 + N/EA) cos θ.

    By symmetry over half of the arc, θ(0) = 0; N = T cos θ.
    """
    s = np.linspace(0.0, 0.5 * LENGTH, 200)
    y = np.stack([s / RADIUS, np.full_like(s, 1.0 / RADIUS), RADIUS * np.sin(s / RADIUS)])
    tension = np.array([1e-4])
    start = 2.0 * RADIUS * np.sin(0.5 * ANGLE)
    for share in np.linspace(0.1, 1.0, 10):
        half = 0.5 * (start + share * (gap - start))
        found = solve_bvp(
            lambda _, y, p: np.stack(
                [
                    y[1],
                    p[0] / EI * np.sin(y[0]) * (1.0 + p[0] * np.cos(y[0]) / EA),
                    np.cos(y[0]) * (1.0 + p[0] * np.cos(y[0]) / EA),
                ]
            ),
            lambda a, b, _, half=half: np.array([a[0], a[2], b[1] - 1.0 / RADIUS, b[2] - half]),
            s,
            y,
            p=tension,
            tol=1e-8,
            max_nodes=100_000,
        )
        assert found.success
        s, y, tension = found.x, found.y, found.p
    return float(tension[0])


@pytest.mark.parametrize("share", [0.9, 0.97, 1.0])
def test_the_ends_of_a_printed_arc_pulled_apart(bar: Callable[..., None], share: float) -> None:
    work, state = bare_rod(printed_arc(EDGES))
    work.model.fixed[[0, -1], :3] = True
    work.model.fixed[:, 2] = True
    gap = share * LENGTH
    start = state.q[-1, 0] - state.q[0, 0]
    for part in np.linspace(0.1, 1.0, 10):
        target = state.q.copy()
        half = 0.5 * (start + part * (gap - start))
        target[0, 0], target[-1, 0] = -half, half
        state = settle(work, state, target)
    force = 0.5 * (state.reaction[-1, 0] - state.reaction[0, 0])
    name = f"printed arc, ends apart by {share:.0%} of its length: force"
    bar(name, force / arc_force(gap) - 1.0, 0.01, "1", "extensible elastica of an arc, solved here")

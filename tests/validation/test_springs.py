"""Helical springs pulled a little along their axis, with ends free to spin and locked."""

from __future__ import annotations

from math import cos, pi, radians, sin, tan
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.validation.bare_rod import EI, bare_rod, settle

if TYPE_CHECKING:
    from collections.abc import Callable

# Torsion is softest against bending here, so free and locked ends differ most.
POISSON_RATIO = 0.5
GJ = EI / (1.0 + POISSON_RATIO)
RADIUS = 30.0
TURNS, EDGES_PER_TURN = 3, 64
RIGID = 1e4


def spring_stiffness(pitch_angle: float, *, locked: bool) -> float:
    """Return the axial force over extension [E r] of the solver's spring.

    Arms lead from both ends of the wire to ball joints on the axis, so that the load is a force along it.
    A free spring spins as a whole: its first arm is held; the second one too if locked.
    """
    count = TURNS * EDGES_PER_TURN
    turn = 2.0 * pi * np.arange(count + 1) / EDGES_PER_TURN
    wire = RADIUS * np.column_stack([np.cos(turn), np.sin(turn), tan(pitch_angle) * turn])
    joints = wire[[0, -1]] * [0.0, 0.0, 1.0]
    work, state = bare_rod(np.concatenate([joints[:1], wire, joints[1:]]), poisson_ratio=POISSON_RATIO)
    rods, fixed = work.model.rods, work.model.fixed
    for corners in (rods.bend_stiffness, rods.twist_stiffness):
        corners[[1, -2]] *= RIGID
    fixed[[0, -1], :3] = True
    fixed[1, 1] = True
    fixed[-2, 1] = locked
    forces = []
    extension = 1e-3 * joints[1, 2]
    for sign in (1.0, -1.0):
        target = state.q.copy()
        target[-1, 2] += sign * extension
        forces.append(sign * float(settle(work, state, target).reaction[-1, 2]))
    return float(0.5 * sum(forces) / extension)


def theory(pitch_angle: float, *, locked: bool) -> float:
    """Return the same for the wire between the corners, each of which takes half an edge."""
    c2, s2 = cos(pitch_angle) ** 2, sin(pitch_angle) ** 2
    length = 2.0 * pi * RADIUS / cos(pitch_angle) * (TURNS - 1.0 / EDGES_PER_TURN)
    if locked:
        return (GJ * c2 + EI * s2) / (RADIUS**2 * length)
    return 1.0 / (RADIUS**2 * length * (c2 / GJ + s2 / EI))


@pytest.mark.parametrize("locked", [False, True], ids=["free to spin", "locked"])
@pytest.mark.parametrize("degrees", [10, 30, 45, 60])
def test_helical_spring(bar: Callable[..., None], degrees: int, *, locked: bool) -> None:
    angle = radians(degrees)
    found = spring_stiffness(angle, locked=locked)
    ends = "locked" if locked else "free to spin"
    bar(
        f"helical spring, pitch angle {degrees}°, ends {ends}",
        figure=found / theory(angle, locked=locked) - 1.0,
        limit=0.01,
        unit="1",
        source="Castigliano: (F, N) along the axis; Love 1927, ch. XIX",
    )


def test_locked_springs_are_stiffer() -> None:
    angle = radians(45)
    ratio = theory(angle, locked=True) / theory(angle, locked=False)
    assert ratio > 1.04
    found = spring_stiffness(angle, locked=True) / spring_stiffness(angle, locked=False)
    assert found == pytest.approx(ratio, rel=2e-3)

"""A straight rod of a material that yields, and a round section of it in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits.mesh import control_points
from knitlab_core.materials import CurvePoint, Material, Value
from knitlab_core.rods.section import SOLID
from knitlab_core.rods.yielding import make_yielding
from tests.validation.bare_rod import EI, bare_rod

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State
    from knitlab_core.rods.relaxation import Relaxation
    from knitlab_core.rods.yielding import Yielding

POISSON = 0.3


def resin(*points: tuple[float, float], modulus: float = 1.0) -> Material:
    """Return a material with a yield curve of strains [1] and stresses [E]."""
    source = "a test"
    curve = tuple(
        CurvePoint(
            strain=Value(value=strain, unit="1", source=source),
            stress=Value(value=stress * modulus, unit="Pa", source=source),
        )
        for strain, stress in points
    )
    number = Value(value=POISSON, unit="1", source=source)
    young = Value(value=modulus, unit="Pa", source=source)
    return Material(name="resin", young_modulus=young, poisson_ratio=number, yield_curve=curve)


def law_of(*points: tuple[float, float], lasting: float = 1.0) -> Yielding:
    """Return how solid round sections with a yield curve yield."""
    law = make_yielding(resin(*points), SOLID, lasting)
    assert law is not None
    return law


def yielding_rod(
    law: Yielding, *, edges: int = 24, edge: float = 1.0, relaxation: Relaxation | None = None
) -> tuple[Workspace, State]:
    """Make a rod along x with no contact."""
    work, state = bare_rod(np.outer(np.arange(edges + 1.0), [edge, 0.0, 0.0]), poisson_ratio=POISSON)
    return Workspace(replace(work.model, yielding=law, relaxation=relaxation)), state


def arc(curvature: float, edges: int, edge: float) -> NDArray[np.float64]:
    """Return the nodes (N, 4) of a rod bent to an arc from the origin along x, of unchanged length."""
    if curvature == 0.0:
        return np.outer(np.arange(edges + 1.0), [edge, 0.0, 0.0, 0.0])
    turn = curvature * edge * np.arange(edges + 1.0)
    points = control_points(np.column_stack([np.sin(turn), 1.0 - np.cos(turn), 0.0 * turn]) / curvature)
    return np.column_stack([points - points[0], np.zeros(edges + 1)])


def plastic_moment(curvature: float, limit: float) -> float:
    """Return the moment of an elastic, perfectly plastic round section of unit radius and modulus [E r^3].

    Twice the integral of y min(k y, e_y) over the half section, whose chord at height y is 2 sqrt(1 - y^2).
    """
    if curvature <= limit:
        return EI * curvature
    angle = np.arcsin(limit / curvature)
    core = curvature * (angle / 8.0 - np.sin(4.0 * angle) / 32.0)
    return float(4.0 * (core + limit * np.cos(angle) ** 3 / 3.0))

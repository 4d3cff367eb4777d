"""Effective strain and stress from travel and force.

Effective quantities are "using the overall sample dimensions ... unit thickness is assumed" (the paper's Results). As
in every file of this package functions are formulas on arrays, SI units in and out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigs.axes import Axis, FloatArray
    from rigs.instruments.zeros import SizeInTime
    from rigs.record import SpecimenSize


def effective_strain(travel: FloatArray, gauge: float | FloatArray) -> FloatArray:
    """Return ε = u / L₀.

    Parameters
    ----------
    travel : FloatArray, shape (n,)
        Change u of the hook-to-hook distance [m].
    gauge : float or FloatArray, shape (n,)
        Gauge length L₀ [m]: the initial hook-to-hook distance, or that at a zero.

    Returns
    -------
    FloatArray, shape (n,)
        Effective strain [1].
    """
    return travel / gauge


def effective_stress(force: FloatArray, section: float | FloatArray) -> FloatArray:
    """Return σ = F / A₀.

    Parameters
    ----------
    force : FloatArray, shape (n,)
        Force F of the axis [N].
    section : float or FloatArray, shape (n,)
        Initial cross-section A₀ [m²]: of a planar knit its width by a thickness of 1 mm, as the paper has it.

    Returns
    -------
    FloatArray, shape (n,)
        Effective stress [Pa].
    """
    return force / section


def stress_strain(
    travel: FloatArray, force: FloatArray, axis: Axis, size: SpecimenSize | SizeInTime
) -> tuple[FloatArray, FloatArray]:
    """Return strain [1] and stress [Pa] of an axis, (n,), from its travel [m] and force [N], zeroed."""
    return effective_strain(travel, size.gauge(axis)), effective_stress(force, size.section(axis))

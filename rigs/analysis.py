"""Turn logged travel and force into the figures a mechanics paper prints.

Every function is a formula on arrays; SI units in, SI units out. Stress and strain are effective
ones: "using the overall sample dimensions ... unit thickness is assumed" (the paper's Results).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.record import FloatArray, IntArray, Phase, SpecimenSize
    from rigs.steps import Axis

#: Strains at which a cycle's stress is quoted.
LEVELS = (0.2, 0.3, 0.4)

#: The paper's moduli are secants "up to 0.4 % strain".
FIRST_STRAIN = 0.004


def effective_strain(travel: FloatArray, gauge: float) -> FloatArray:
    """Return ε = u / L₀.

    Parameters
    ----------
    travel : FloatArray, shape (n,)
        Change u of the hook-to-hook distance [m].
    gauge : float
        Initial hook-to-hook distance L₀ [m].

    Returns
    -------
    FloatArray, shape (n,)
        Effective strain [1].
    """
    return travel / gauge


def effective_stress(force: FloatArray, section: float) -> FloatArray:
    """Return σ = F / A₀.

    Parameters
    ----------
    force : FloatArray, shape (n,)
        Force F of the axis [N].
    section : float
        Initial cross-section A₀ [m²]: of a planar knit its width by a thickness of 1 mm, as the paper has it.

    Returns
    -------
    FloatArray, shape (n,)
        Effective stress [Pa].
    """
    return force / section


def stress_strain(
    travel: FloatArray, force: FloatArray, axis: Axis, size: SpecimenSize
) -> tuple[FloatArray, FloatArray]:
    """Return strain [1] and stress [Pa] of an axis."""
    return effective_strain(travel, size.extents[axis]), effective_stress(force, size.section(axis))


def branch(phase: Sequence[Phase], cycle: IntArray, number: int, which: Sequence[Phase]) -> IntArray:
    """Return the rows of one cycle in some phases, with the row they set out from.

    Parameters
    ----------
    phase : sequence of Phase, length n
        Phase of every row.
    cycle : IntArray, shape (n,)
        Cycle of every row.
    number : int
        The cycle wanted.
    which : sequence of Phase
        The phases wanted: ``["Stretch"]`` is the loading branch.

    Returns
    -------
    IntArray, shape (m,)
        Row indices, empty if the cycle has no such rows.
    """
    wanted = np.flatnonzero((np.asarray(cycle) == number) & np.isin(np.asarray(phase), which))
    if len(wanted) and wanted[0] > 0:
        wanted = np.concatenate([[wanted[0] - 1], wanted])
    return wanted.astype(np.int64)


def stress_at(strain: FloatArray, stress: FloatArray, at: float) -> float:
    """Return the stress where a loading branch first reaches a strain, linearly between rows.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch; noise may make the strain step back, so its running maximum is used.
    at : float
        Strain asked for [1].

    Returns
    -------
    float
        Stress [Pa]; ``nan`` outside the branch.
    """
    reached = np.maximum.accumulate(strain)
    # A target of 40 % reached to within a rounding error or an encoder step is reached.
    slack = 1e-9 + 1e-4 * abs(at)
    if not len(strain) or not reached[0] - slack <= at <= reached[-1] + slack:
        return float("nan")
    return float(np.interp(at, reached, stress))


def secant_modulus(strain: FloatArray, stress: FloatArray, to: float, start: float = 0.0) -> float:
    """Return E_s = (σ(ε₁) - σ(ε₀)) / (ε₁ - ε₀) of a loading branch.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch [1], [Pa].
    to, start : float
        Strains ε₁ and ε₀ [1]; the paper quotes the secant from rest "up to 0.4 %".

    Returns
    -------
    float
        Secant modulus [Pa]; ``nan`` if the branch does not reach so far.

    Raises
    ------
    SpecificationError
        If both strains are the same.
    """
    if to == start:
        raise SpecificationError("to", to, f"a strain other than {start}")
    rise = stress_at(strain, stress, to) - stress_at(strain, stress, start)
    return rise / (to - start)


def cycle_work(strain: FloatArray, stress: FloatArray) -> float:
    """Return W = ∫ σ dε along a path by the trapezium rule [J/m³].

    Positive on loading; over a whole cycle it is what the specimen kept (see `loop_area`).
    """
    return float(np.trapezoid(stress, strain))


def loop_area(strain: FloatArray, stress: FloatArray) -> float:
    """Return the dissipated energy density ∮ σ dε of a cycle [Pa = J/m³].

    "Dissipated energy (area between the loading and unloading curves)", the paper's Results. The
    path is closed by a straight line from its end to its start.
    """
    return cycle_work(np.append(strain, strain[:1]), np.append(stress, stress[:1]))


def hysteresis(strain: FloatArray, stress: FloatArray) -> float:
    """Return the share of the loading work that a cycle dissipates, ∮ σ dε / ∫ σ dε [1].

    Loading runs to the largest strain; ``nan`` if it took no work.
    """
    peak = int(np.argmax(strain)) + 1
    loading = cycle_work(strain[:peak], stress[:peak])
    return loop_area(strain, stress) / loading if loading > 0 else float("nan")


def _is_closed(strain: FloatArray) -> bool:
    """Tell whether a path comes back to the strain it set out from, to a thousandth of its range."""
    return bool(abs(strain[-1] - strain[0]) <= 1e-3 * np.ptp(strain))


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleFigures:
    """Hold the figures of one axis over one cycle.

    Attributes
    ----------
    axis : Axis
        Course, wale or pile.
    cycle : int
        Counter of the set, from 1.
    stress : dict of float to float
        Stress on loading [Pa] by strain [1]; ``nan`` where the branch does not reach.
    loading_work : float
        Work of loading [J/m³].
    loop_area : float
        Dissipated energy density [J/m³]; ``nan`` if the cycle did not come back to where it set out from.
    hysteresis : float
        Share of the loading work that was dissipated [1].
    initial_secant, peak_secant : float
        Secant moduli of loading from where the cycles set out: over the first `FIRST_STRAIN`, and to the largest
        strain [Pa]; ``nan`` where the branch does not reach so far.
    """

    axis: Axis
    cycle: int
    stress: dict[float, float]
    loading_work: float
    loop_area: float
    hysteresis: float
    initial_secant: float
    peak_secant: float


def cycle_figures(
    axis: Axis,
    strain: FloatArray,
    stress: FloatArray,
    phase: Sequence[Phase],
    cycle: IntArray,
) -> tuple[CycleFigures, ...]:
    """Work out the figures of every cycle that was loaded.

    Parameters
    ----------
    axis : Axis
        Course, wale or pile.
    strain, stress : FloatArray, shape (n,)
        The whole test on this axis [1], [Pa].
    phase : sequence of Phase, length n
        Phase of every row.
    cycle : IntArray, shape (n,)
        Cycle of every row.

    Returns
    -------
    tuple of CycleFigures
        One per cycle, in order.
    """
    found = []
    for number in np.unique(cycle[np.isin(np.asarray(phase), ["Stretch"])]):
        up = branch(phase, cycle, int(number), ["Stretch"])
        loop = branch(phase, cycle, int(number), ["Stretch", "Hold", "Recover"])
        closed = _is_closed(strain[loop])
        start, peak = float(strain[up[0]]), float(strain[up].max())
        found.append(
            CycleFigures(
                axis=axis,
                cycle=int(number),
                stress={at: stress_at(strain[up], stress[up], at) for at in LEVELS},
                loading_work=cycle_work(strain[up], stress[up]),
                loop_area=loop_area(strain[loop], stress[loop]) if closed else float("nan"),
                hysteresis=hysteresis(strain[loop], stress[loop]) if closed else float("nan"),
                initial_secant=secant_modulus(strain[up], stress[up], start + FIRST_STRAIN, start),
                peak_secant=secant_modulus(strain[up], stress[up], peak, start) if peak > start else float("nan"),
            )
        )
    return tuple(found)

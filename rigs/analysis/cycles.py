"""Stress, strain and the figures of cycles from logged travel and force.

Every function is a formula on arrays; SI units in, SI units out. Stress and strain are effective
ones: "using the overall sample dimensions ... unit thickness is assumed" (the paper's Results).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.instruments.pchip import Pchip

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import Axis, FloatArray, IntArray
    from rigs.instruments.zeros import SizeInTime
    from rigs.record import Phase, SpecimenSize

#: Strains at which a cycle's stress is quoted.
LEVELS = (0.2, 0.3, 0.4)

#: The paper's moduli are secants "up to 0.4 % strain".
FIRST_STRAIN = 0.004

#: Share of a path's range of strain by which strain goes back where a branch ends; what is less is noise.
TURN = 0.05

#: Share of a branch's range of strain up to which two rows are at one strain.
STILL = 1e-9


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
    """Return W = ∫ σ dε along a path [J/m³].

    The integrand is the shape-preserving cubic that the instruments sample too
    (`rigs.instruments.signals.interpolate`), branch by branch: rows of a test are irregular, and the trapezium rule
    between them is off by some percent of a loop's area.
    Where strain steps back inside a branch, as in a measured log with noise, that branch has no such curve and is
    integrated by the trapezium rule; there rows are many.

    Positive on loading; over a whole cycle it is what the specimen kept (see `loop_area`).

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The path in the order of time [1], [Pa]. Stress that changes at one strain, as in a hold, does no work.

    Returns
    -------
    float
        Work per volume [J/m³]; 0 of fewer than two rows.
    """
    work = 0.0
    for first, last in pairwise(_turns(strain)):
        rows = slice(first, last + 1)
        work += _branch_work(strain[rows], stress[rows])
    return work


def _turns(strain: FloatArray) -> list[int]:
    """Return the first row, those where strain turns back by more than noise, and the last row."""
    if len(strain) < 2:
        return []
    back = TURN * float(np.ptp(strain))
    turns, low, high, way = [0], 0, 0, 0
    for row, value in enumerate(strain):
        # Before the first turn it is not yet known whether the path goes up or down.
        if way >= 0 and value > strain[high]:
            high = row
        if way <= 0 and value < strain[low]:
            low = row
        if way >= 0 and strain[high] - value > back:
            turns, low, way = turns + [high] * (high > turns[-1]), row, -1
        elif way <= 0 and value - strain[low] > back:
            turns, high, way = turns + [low] * (low > turns[-1]), row, 1
    return [*turns, len(strain) - 1]


def _branch_work(strain: FloatArray, stress: FloatArray) -> float:
    """Return ∫ σ dε of one branch [J/m³]."""
    rise = np.diff(strain)
    still = np.abs(rise) <= STILL * np.ptp(strain)
    way = np.sign(strain[-1] - strain[0])
    if np.any(way * rise[~still] <= 0.0):
        return float(np.trapezoid(stress, strain))
    work = 0.0
    # Between rows at one strain stress may jump, so a curve ends before them and another begins after.
    for rows in np.split(np.arange(len(strain)), np.flatnonzero(still) + 1):
        if len(rows) > 1:
            work += way * Pchip.through(way * strain[rows], stress[rows]).integral()
    return float(work)


def loop_area(strain: FloatArray, stress: FloatArray) -> float:
    """Return the dissipated energy density ∮ σ dε of a cycle [Pa = J/m³].

    "Dissipated energy (area between the loading and unloading curves)", the paper's Results. The path is integrated as
    in `cycle_work` and closed by a straight line from its end to its start.
    """
    back = np.trapezoid(np.append(stress[-1:], stress[:1]), np.append(strain[-1:], strain[:1]))
    return cycle_work(strain, stress) + float(back)


def hysteresis(strain: FloatArray, stress: FloatArray) -> float:
    """Return the share of the loading work that a cycle dissipates, ∮ σ dε / ∫ σ dε [1].

    Loading runs to the largest strain; ``nan`` if it took no work.
    """
    peak = int(np.argmax(strain)) + 1
    loading = cycle_work(strain[:peak], stress[:peak])
    return loop_area(strain, stress) / loading if loading > 0 else float("nan")


def _is_closed(strain: FloatArray) -> bool:
    """Return whether a path comes back to the strain it began at, to a thousandth of its range."""
    return bool(abs(strain[-1] - strain[0]) <= 1e-3 * np.ptp(strain))


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleFigures:
    """Figures of one axis over one cycle.

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

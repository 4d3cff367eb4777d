"""Work of loading, area of loops and what is lost of the work."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.analysis.branches import turning_rows
from rigs.instruments.pchip import Pchip

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray

STILL: Final = 1e-9
"""Share of a branch's range of strain up to which two rows are at one strain."""


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
    for first, last in pairwise(turning_rows(strain)):
        rows = slice(first, last + 1)
        work += _branch_work(strain[rows], stress[rows])
    return work


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


def work_put_in(strain: FloatArray, stress: FloatArray) -> float:
    """Return ∫ σ dε along the parts of a path where it is above 0, trapezium by trapezium [J/m³].

    A cycle that loads a specimen both ways, such as one of shear, takes work twice. Of its way up `cycle_work` gives
    what it takes less what comes back from the other side.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The path in the order of time [1], [Pa].
    """
    parts = 0.5 * (stress[1:] + stress[:-1]) * np.diff(strain)
    return float(np.sum(np.maximum(parts, 0.0)))


def is_closed(strain: FloatArray, within: float = 1e-3) -> bool:
    """Return whether a path comes back to the strain it began at, within a share of its range [1]."""
    return bool(abs(strain[-1] - strain[0]) <= within * np.ptp(strain))


def summed_hysteresis(loops: Sequence[float], works: Sequence[float]) -> float:
    """Return the share of the loading work of all axes that a cycle dissipates, Σ ∮ σ dε / Σ ∫ σ dε [1].

    Axes that are strained together pass energy to each other, so that the loop of one alone may be below 0; only the
    sum is what the specimen lost. Per volume they add up: F du / V = σ dε along each axis, for F = σ A and V = A L.

    Parameters
    ----------
    loops, works : sequence of float
        Loop area and work of loading of each axis [J/m³].
    """
    work = float(np.sum(works))
    return float(np.sum(loops)) / work if work > 0.0 else float("nan")


def loading_work_ratios(works: Sequence[float]) -> FloatArray:
    """Return the work of loading of each cycle over that of the first [1], (n,).

    Below 1 where the first loading is stiffer than later ones, as "the initial loading exhibits a stiffer response as
    compared to subsequent loading" (the paper's Results).
    """
    found = np.asarray(works, dtype=np.float64)
    return found / found[0] if len(found) and found[0] != 0.0 else np.full(len(found), np.nan)

"""Straight lines by least squares, with confidence intervals; moduli over a window of strain.

References
----------
N. R. Draper and H. Smith, Applied Regression Analysis (3rd ed., 1998), 1.4 and 1.5: slope, its standard error, R².
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import stdtrit

from rigs.instruments.pchip import Pchip

if TYPE_CHECKING:
    from rigs.axes import FloatArray

CONFIDENCE: Final = 0.95
"""Level of confidence intervals unless another is asked for [1]."""

FEWEST_ROWS: Final = 8
"""Rows in a window from which on a line goes through them; of fewer that rise the curve between them is read."""

READINGS: Final = 101
"""Readings of that curve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LineFit:
    """Line y = a + b x by least squares.

    Attributes
    ----------
    slope, intercept : float
        b and a; ``nan`` of fewer than three points, or of points at one x.
    low, high : float
        Confidence interval of the slope: b ± t s / √Sxx, s² = Σ r² / (n - 2). Points of a smooth curve scatter by
        curvature and not by chance; of them it says how far from straight the curve is.
    r2 : float
        1 - Σ r² / Σ (y - ȳ)².
    points : int
        How many there were.
    """

    slope: float
    intercept: float
    low: float
    high: float
    r2: float
    points: int


def fit_line(x: FloatArray, y: FloatArray, confidence: float = CONFIDENCE) -> LineFit:
    """Fit a line through points (n,), with the confidence interval of its slope at a level [1]."""
    count = len(x)
    spread = float(np.sum((x - x.mean()) ** 2)) if count else 0.0
    # Points that differ by rounding alone are at one x.
    if count < 3 or spread <= count * (1e-13 * float(np.abs(x).max())) ** 2:
        return LineFit(slope=nan, intercept=nan, low=nan, high=nan, r2=nan, points=count)
    slope = float(np.sum((x - x.mean()) * (y - y.mean()))) / spread
    intercept = float(y.mean() - slope * x.mean())
    rest = float(np.sum((y - intercept - slope * x) ** 2))
    half = float(stdtrit(count - 2, 0.5 + 0.5 * confidence)) * (rest / (count - 2) / spread) ** 0.5
    return LineFit(
        slope=slope,
        intercept=intercept,
        low=slope - half,
        high=slope + half,
        r2=r_squared(y, y - intercept - slope * x),
        points=count,
    )


def r_squared(y: FloatArray, residuals: FloatArray) -> float:
    """Return R² = 1 - Σ r² / Σ (y - ȳ)² of values (n,) and residuals (n,); ``nan`` where all values are the same."""
    total = float(np.sum((y - y.mean()) ** 2))
    return 1.0 - float(np.sum(residuals**2)) / total if total > 0.0 else nan


def window(x: FloatArray, y: FloatArray, first: float, last: float) -> tuple[FloatArray, FloatArray]:
    """Return the points of a branch between two x, both included.

    Where fewer than `FEWEST_ROWS` rows are in the window and x rises from row to row, the shape-preserving cubic
    through the rows is read at `READINGS` equally spaced x: one step of a solver is no line, and the secant over it
    alone was found 11 % off. Nothing is read beyond the rows.

    Parameters
    ----------
    x, y : FloatArray, shape (n,)
        The branch, in the order of time.
    first, last : float
        The window, in the unit of x.

    Returns
    -------
    tuple of FloatArray, shape (m,)
        Its x and y.
    """
    slack = 1e-9 * max(abs(first), abs(last))
    rows = (x >= first - slack) & (x <= last + slack)
    if np.count_nonzero(rows) >= FEWEST_ROWS or len(x) < 2 or np.any(np.diff(x) <= 0.0):
        return x[rows], y[rows]
    low, high = max(first, float(x[0])), min(last, float(x[-1]))
    if high <= low:
        return x[rows], y[rows]
    at = np.linspace(low, high, READINGS)
    return at, Pchip.through(x, y)(at)


def segment_modulus(
    strain: FloatArray, stress: FloatArray, first: float, last: float, confidence: float = CONFIDENCE
) -> LineFit:
    """Fit a line through all points of a loading branch between two strains; its slope is the modulus [Pa].

    The regression slope of ISO 527-1:2019, 10.3; the secant through both ends alone is
    `rigs.analysis.moduli.secant_modulus`.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch [1], [Pa].
    first, last : float
        Strains between which it counts [1]; the modulus is ``nan`` if the branch does not cover them to a hundredth of
        the window.
    confidence : float
        Level of the slope's interval [1].
    """
    within = 0.01 * (last - first)
    if not len(strain) or strain.min() > first + within or strain.max() < last - within:
        return fit_line(strain[:0], stress[:0])
    return fit_line(*window(strain, stress, first, last), confidence)

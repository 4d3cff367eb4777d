"""Exponential fit of a loading branch, and whether a kinked line fits as well.

References
----------
The paper's Results: "an anisotropic, hysteric, exponential stress-strain behavior"; Fig. 3c draws σ = A exp(β ε).
K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference (2nd ed., 2002), 2.4 (AICc), 2.9 (weights).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, nan
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from rigs.analysis.regression import CONFIDENCE, fit_line, r_squared, window

if TYPE_CHECKING:
    from rigs.axes import FloatArray

FEWEST: Final = 8
"""Points from which on both models can be compared; the kinked line has four parameters."""

KINKS: Final = 97
"""Places at which a kink is tried before the best is refined."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExponentialFit:
    """Fit σ = A exp(β ε): a line of ln σ over ε by least squares.

    Attributes
    ----------
    rate, rate_low, rate_high : float
        β and its confidence interval [1].
    amplitude : float
        A [Pa].
    r2 : float
        R² of the line.
    first, last : float
        Window of strain [1].
    points : int
        Points in it with a stress above 0.
    """

    rate: float
    rate_low: float
    rate_high: float
    amplitude: float
    r2: float
    first: float
    last: float
    points: int


def exponential_fit(
    strain: FloatArray, stress: FloatArray, first: float, last: float, confidence: float = CONFIDENCE
) -> ExponentialFit:
    """Fit σ = A exp(β ε) to a loading branch in a window of strain.

    ln σ = ln A + β ε, ordinary least squares: each stress weighs by its relative error, so that the toe of the curve
    counts as much as its end.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch [1], [Pa]; what is not above 0 is left out.
    first, last : float
        Window of strain [1].
    confidence : float
        Level of the interval of β [1].
    """
    x, y = window(strain, stress, first, last)
    x, y = x[y > 0.0], y[y > 0.0]
    line = fit_line(x, np.log(y), confidence)
    return ExponentialFit(
        rate=line.slope,
        rate_low=line.low,
        rate_high=line.high,
        amplitude=exp(line.intercept),
        r2=line.r2,
        first=first,
        last=last,
        points=line.points,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class KinkedLine:
    """Line with one kink, y = a + b x + c max(x - k, 0), by least squares.

    Attributes
    ----------
    kink : float
        k, in the unit of x.
    below, above : float
        Slopes b and b + c.
    start : float
        a.
    residuals : FloatArray, shape (n,)
        y less the line.
    """

    kink: float
    below: float
    above: float
    start: float
    residuals: FloatArray


def kinked_fit(x: FloatArray, y: FloatArray) -> KinkedLine:
    """Fit a line with one kink through points (n,), four or more with three different x.

    For a given kink the rest is linear; the kink is the best of `KINKS` places, refined between their neighbours.
    """

    def solved(kink: float) -> tuple[FloatArray, FloatArray]:
        columns = np.stack([np.ones_like(x), x, np.maximum(x - kink, 0.0)], axis=1)
        found = np.linalg.lstsq(columns, y, rcond=None)[0]
        return found, y - columns @ found

    def lost(kink: float) -> float:
        return float(np.sum(solved(kink)[1] ** 2))

    places = np.linspace(float(x.min()), float(x.max()), KINKS + 2)
    best = 1 + int(np.argmin([lost(float(place)) for place in places[1:-1]]))
    refined = minimize_scalar(lost, bounds=(float(places[best - 1]), float(places[best + 1])), method="bounded")
    kink = float(refined.x) if refined.fun < lost(float(places[best])) else float(places[best])
    (start, below, more), residuals = solved(kink)
    return KinkedLine(kink=kink, below=float(below), above=float(below + more), start=float(start), residuals=residuals)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeTest:
    """Exponential against kinked line on the same stresses.

    Attributes
    ----------
    weight : float
        Akaike weight of the exponential [1]: near 1 it is the better model, near 0 the kinked line is.
    exponential_r2, kinked_r2 : float
        R² of both in σ.
    kink : float
        Strain at the kink [1].
    below, above : float
        Moduli below and above it [Pa].
    points : int
        Points that were fitted.
    """

    weight: float
    exponential_r2: float
    kinked_r2: float
    kink: float
    below: float
    above: float
    points: int


def exponential_or_kinked(strain: FloatArray, stress: FloatArray, first: float, last: float) -> ShapeTest:
    """Compare σ = A exp(β ε) and a kinked line (toe and stiff part) in a window of strain.

    Both are fitted to σ by least squares. AICc = n ln(Σ r² / n) + 2 k + 2 k (k + 1) / (n - k - 1), where k counts the
    variance too (3 and 5), and the weight is 1 / (1 + exp((AICc_exponential - AICc_kinked) / 2)). Neighbouring rows of
    a smooth curve are not independent, so that weights are nearer to 0 or 1 than chance alone allows: they say which
    model is nearer, not by how much.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The loading branch [1], [Pa].
    first, last : float
        Window of strain [1].

    Returns
    -------
    ShapeTest
        With ``nan`` where the window has fewer than `FEWEST` points.
    """
    x, y = window(strain, stress, first, last)
    if len(x) < FEWEST or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return ShapeTest(weight=nan, exponential_r2=nan, kinked_r2=nan, kink=nan, below=nan, above=nan, points=len(x))
    scale = float(np.abs(y).max())
    curved = _exponential_residuals(x, y / scale)
    kinked = kinked_fit(x, y / scale)
    ahead = 0.5 * (_aicc(curved, 3) - _aicc(kinked.residuals, 5))
    return ShapeTest(
        weight=1.0 / (1.0 + exp(min(ahead, 700.0))),
        exponential_r2=r_squared(y / scale, curved),
        kinked_r2=r_squared(y / scale, kinked.residuals),
        kink=kinked.kink,
        below=scale * kinked.below,
        above=scale * kinked.above,
        points=len(x),
    )


def _exponential_residuals(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return y less A exp(β x) fitted by least squares in y; it starts at the line through ln y."""
    above = y > 0.0
    line = fit_line(x[above], np.log(y[above]))
    if line.points < 3:
        return np.asarray(y - y.mean())
    middle = float(x.mean())
    start = np.array([line.intercept + line.slope * middle, line.slope])

    def residuals(wanted: FloatArray) -> FloatArray:
        # A step that is far too long must not overflow.
        rest: FloatArray = y - np.exp(np.clip(wanted[0] + wanted[1] * (x - middle), -300.0, 300.0))
        return rest

    return residuals(least_squares(residuals, start, x_scale="jac").x)


def _aicc(residuals: FloatArray, parameters: int) -> float:
    """Return Akaike's criterion for few points; residuals (n,) below rounding count as such."""
    count = len(residuals)
    mean_square = max(float(np.mean(residuals**2)), 1e-30)
    penalty = 2.0 * parameters * (parameters + 1) / (count - parameters - 1)
    return count * log(mean_square) + 2.0 * parameters + penalty

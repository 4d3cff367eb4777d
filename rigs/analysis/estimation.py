"""Estimates of parameters by least squares: their scale, intervals, correlations, and what the data do not see.

References
----------
G. A. F. Seber and C. J. Wild, Nonlinear Regression (1989), 5.1: intervals by the linearised model.
A. K. Gupta, P. Bayley and J. M. Hammersley, J. R. Stat. Soc. Suppl. 8 (1946) 184: effective number of observations of a
    series with correlation, n (1 - rho) / (1 + rho).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, nan
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import stdtrit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray

CONFIDENCE: Final = 0.95

ROUGHNESS: Final = 2e-5
"""Differences of equilibria that the solver's tolerance leaves, in the range of a curve [1]."""

STEP: Final = 0.02
"""Step of finite differences, in the width of a parameter's bounds: far above roughness, and that of friction."""

TAKES_PART: Final = 0.1
"""Component from which on a parameter takes part in a direction that the data do not see."""

AT_BOUND: Final = 5e-3
"""Distance from a bound within which an estimate is at it, in the width of the bounds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounded:
    """A parameter between bounds, and its coordinate z from 0 to 1: of ln(value) where both are above 0.

    Attributes
    ----------
    name : str
        Its name.
    low, high, start : float
        Bounds and first value, in `unit`.
    unit : str
        The unit that its values are written with; empty of a plain number.
    """

    name: str
    low: float
    high: float
    start: float
    unit: str = ""

    @property
    def logarithmic(self) -> bool:
        """Return whether steps are ratios."""
        return self.low > 0.0

    def value(self, z: float) -> float:
        """Return the value at a coordinate, rounded to eight digits so that the same point is the same run."""
        if self.logarithmic:
            found = exp(log(self.low) + z * (log(self.high) - log(self.low)))
        else:
            found = self.low + z * (self.high - self.low)
        return float(f"{found:.8g}")

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value."""
        if self.logarithmic:
            return (log(value) - log(self.low)) / (log(self.high) - log(self.low))
        return (value - self.low) / (self.high - self.low)

    def change(self, by: float) -> str:
        """Return a change of the coordinate in words: in percent, or in its unit."""
        if self.logarithmic:
            return f"{self.name} {100.0 * ((self.high / self.low) ** by - 1.0):+.2g} %"
        return f"{self.name} {by * (self.high - self.low):+.2g}{' ' * bool(self.unit)}{self.unit}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A parameter as the data tell it.

    Attributes
    ----------
    parameter : Bounded
        Which.
    used : float
        Its value in the best run.
    value, low, high : float
        Estimate and its 95 % interval; ``nan`` where the data do not tell it, an interval also at a bound.
    at_bound : str
        ``lower`` or ``upper`` bound that it is at; empty between them.
    """

    parameter: Bounded
    used: float
    value: float
    low: float
    high: float
    at_bound: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Estimates:
    """All parameters of a fit.

    Attributes
    ----------
    each : tuple of Estimate
        One by one.
    correlation : FloatArray, shape (p, p)
        Of the estimates; ``nan`` where one has no interval.
    singular_values : FloatArray, shape (p,)
        Of the Jacobian over √m: root mean square change of the curves, in their range, for a change along each singular
        direction by the width of the bounds.
    unseen : tuple of str
        What the data do not tell, in words.
    """

    each: tuple[Estimate, ...]
    correlation: FloatArray
    singular_values: FloatArray
    unseen: tuple[str, ...]


def without_roughness(jacobian: FloatArray) -> FloatArray:
    """Return a Jacobian (m, p) without the directions whose effect is no more than the roughness of the curves.

    A search would follow them to a bound.
    """
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    values = np.where(values < ROUGHNESS / STEP * len(jacobian) ** 0.5, 0.0, values)
    return np.asarray((left * values) @ right)


def effective_count(parts: Sequence[FloatArray]) -> float:
    """Return how many independent residuals there are in series of them: n (1 - rho) / (1 + rho), rho at least 0.

    Parameters
    ----------
    parts : sequence of FloatArray
        Residuals of each branch in the order of its rows; rho is their correlation from one to the next. Misfit of the
        model correlates them, and intervals that took them for independent would be too narrow.
    """
    total = sum(float(np.sum(one**2)) for one in parts)
    if total == 0.0:
        return float(sum(map(len, parts)))
    rho = min(max(sum(float(np.sum(one[1:] * one[:-1])) for one in parts) / total, 0.0), 0.999)
    return sum(map(len, parts)) * (1.0 - rho) / (1.0 + rho)


def estimates(
    parameters: Sequence[Bounded], z: FloatArray, jacobian: FloatArray, parts: Sequence[FloatArray]
) -> Estimates:
    """Return estimates with intervals from the Jacobian at the best point.

    A direction is not seen if its 95 % half-width is more than half of the bounds' width: the data then tell no more
    than the bounds. Scatter counts as the roughness of equilibria at least.

    Parameters
    ----------
    parameters : sequence of Bounded, length p
        The parameters.
    z : FloatArray, shape (p,)
        Their coordinates at the best point.
    jacobian : FloatArray, shape (m, p)
        Derivatives of all residuals by them.
    parts : sequence of FloatArray
        Residuals of each branch.
    """
    count = sum(map(len, parts))
    rest = sum(float(np.sum(one**2)) for one in parts)
    # A smooth misfit may leave few independent residuals.
    effective = max(effective_count(parts), min(len(parameters) + 1.0, count))
    freedom = max(count - len(parameters), 1)
    scatter = max((rest / max(count - len(parameters), 1)) ** 0.5, ROUGHNESS)
    reach = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE)) * scatter * (count / effective) ** 0.5
    _, values, right = np.linalg.svd(jacobian, full_matrices=False)
    # A bound makes misfit that is no scatter: there, only an effect within roughness is not seen.
    held = any(_side(place) for place in z)
    seen = ((values > 2.0 * reach) | held) & (values > ROUGHNESS / STEP * count**0.5)
    unseen = [_in_words(parameters, direction) for direction in right[~seen]]
    shares = np.max(np.abs(right[~seen]), axis=0, initial=0.0)
    covariance = (right[seen].T / values[seen] ** 2) @ right[seen]
    each, spread = [], np.sqrt(np.diag(covariance))
    for one, place, half, share in zip(parameters, z, reach * spread, shares, strict=True):
        side = _side(place)
        known, bounded = share < TAKES_PART, bool(side)
        ends = [one.value(place - half), one.value(place + half)] if known and not bounded else [nan, nan]
        used = one.value(place)
        each.append(
            Estimate(parameter=one, used=used, value=used if known else nan, low=ends[0], high=ends[1], at_bound=side)
        )
    known_spread = np.where([np.isfinite(one.low) for one in each], spread, nan)
    return Estimates(
        each=tuple(each),
        correlation=covariance / np.outer(known_spread, known_spread),
        singular_values=values / count**0.5,
        unseen=tuple(unseen),
    )


def _side(place: float) -> str:
    """Return the bound that a coordinate is at; empty between them."""
    return "lower" if place < AT_BOUND else "upper" if place > 1.0 - AT_BOUND else ""


def _in_words(parameters: Sequence[Bounded], direction: FloatArray) -> str:
    """Return what a direction that the data do not see means."""
    part = [k for k in np.argsort(-np.abs(direction)) if abs(direction[k]) >= TAKES_PART]
    if len(part) == 1:
        one = parameters[part[0]]
        unit = f"{' ' * bool(one.unit)}{one.unit}"
        return f"{one.name} is not seen by the data between {one.low:g}{unit} and {one.high:g}{unit}"
    ratio = 0.1 / float(np.max(np.abs(direction)))
    names = ", ".join(parameters[k].name for k in part[:-1]) + f" and {parameters[part[-1]].name}"
    # The sign of a singular direction is arbitrary: the first parameter goes up.
    sign = 1.0 if direction[part[0]] > 0.0 else -1.0
    together = " with ".join(parameters[k].change(sign * ratio * float(direction[k])) for k in part)
    return f"{names} cannot be told apart: {together} leaves the measured curves as they are"

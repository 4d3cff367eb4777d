"""How alike curves are: normalised differences, and the band that repeats of a test make."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray

READINGS: Final = 201
"""Strains at which curves are compared."""


def read_at(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Read a loading branch at some x, linearly between rows and where it first gets there; ``nan`` outside it.

    Parameters
    ----------
    x, y : FloatArray, shape (n,)
        The branch; noise may make x step back, so its running maximum counts.
    at : FloatArray, shape (m,)
        Where to read.
    """
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return np.full(len(at), np.nan)
    reached, first = np.unique(np.maximum.accumulate(x[known]), return_index=True)
    slack = 1e-9 * max(abs(float(reached[0])), abs(float(reached[-1])))
    inside = (at >= reached[0] - slack) & (at <= reached[-1] + slack)
    return np.where(inside, np.interp(at, reached, y[known][first]), np.nan)


def common_range(curves: Sequence[tuple[FloatArray, FloatArray]], readings: int = READINGS) -> FloatArray:
    """Return equally spaced x that all curves (x, y) cover, (m,); none if they have none in common."""
    ends = [(float(np.nanmin(x)), float(np.nanmax(x))) for x, _ in curves if np.isfinite(x).any()]
    if len(ends) < len(curves) or not ends:
        return np.zeros(0)
    low, high = max(low for low, _ in ends), min(high for _, high in ends)
    return np.linspace(low, high, readings) if high > low else np.zeros(0)


def nrmse(reference: FloatArray, other: FloatArray) -> float:
    """Return the root mean square difference over the range of the reference, √(mean (b - a)²) / (max a - min a) [1].

    Parameters
    ----------
    reference, other : FloatArray, shape (n,)
        Values a and b at the same x; where either is ``nan`` none counts. ``nan`` if none is left, or a is constant.

    References
    ----------
    R. J. Hyndman and A. B. Koehler, Int. J. Forecasting 22 (2006) 679: scale-free measures; normalised by the range.
    """
    both = np.isfinite(reference) & np.isfinite(other)
    if not both.any():
        return float("nan")
    a, b = reference[both], other[both]
    spread = float(np.ptp(a))
    return float(np.sqrt(np.mean((b - a) ** 2))) / spread if spread > 0.0 else float("nan")


def curve_nrmse(reference: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray]) -> float:
    """Return the `nrmse` of two curves (x, y) over the x that both cover [1]."""
    at = common_range([reference, other])
    return nrmse(read_at(*reference, at), read_at(*other, at)) if len(at) else float("nan")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """Repeats of a test at common x.

    Attributes
    ----------
    x : FloatArray, shape (m,)
        Where they are read.
    mean, low, high, deviation : FloatArray, shape (m,)
        Mean, least and largest value, and sample standard deviation (0 of a single curve).
    repeats : int
        How many curves.
    """

    x: FloatArray
    mean: FloatArray
    low: FloatArray
    high: FloatArray
    deviation: FloatArray
    repeats: int


def band_of(curves: Sequence[tuple[FloatArray, FloatArray]]) -> Band | None:
    """Return the band of curves (x, y) over the x that all cover; None if there is none."""
    at = common_range(curves)
    if not len(at):
        return None
    values = np.stack([read_at(x, y, at) for x, y in curves])
    return Band(
        x=at,
        mean=values.mean(axis=0),
        low=values.min(axis=0),
        high=values.max(axis=0),
        deviation=values.std(axis=0, ddof=1) if len(curves) > 1 else np.zeros(len(at)),
        repeats=len(curves),
    )

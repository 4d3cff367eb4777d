"""Shape-preserving piecewise cubic (PCHIP) through points, in NumPy.

The same numbers to the last bit as `scipy.interpolate.PchipInterpolator`, whose package takes longer to import than a
short test takes to solve (docs/decisions/0029).

References
----------
F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300: the slopes.
C. Moler, Numerical Computing with MATLAB (2004), 3.6: the slopes at the ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigs.axes import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pchip:
    """Cubics between points, c0 s³ + c1 s² + c2 s + c3 at a distance s from the point before.

    Attributes
    ----------
    x : FloatArray, shape (n,)
        Where the points are.
    coefficients : FloatArray, shape (4, n - 1, ...)
        c0 to c3 of every cubic.
    """

    x: FloatArray
    coefficients: FloatArray

    @classmethod
    def through(cls, x: FloatArray, y: FloatArray) -> Pchip:
        """Return the curve through points: rising x (n,), two or more, and values y (n, ...)."""
        h = np.diff(x).reshape(-1, *(1,) * (y.ndim - 1))
        secant = np.diff(y, axis=0) / h
        slope = _slopes(h, secant)
        t = (slope[:-1] + slope[1:] - 2 * secant) / h
        return cls(x=x, coefficients=np.stack([t / h, (secant - slope[:-1]) / h - t, slope[:-1], y[:-1]]))

    def __call__(self, at: FloatArray) -> FloatArray:
        """Return the values, (m, ...), at some places (m,); the first and the last cubic go on beyond the ends."""
        piece = np.clip(np.searchsorted(self.x, at, side="right") - 1, 0, len(self.x) - 2)
        c = self.coefficients[:, piece]
        s = (at - self.x[piece]).reshape(-1, *(1,) * (c.ndim - 2))
        square = s * s
        return np.asarray(c[3] + c[2] * s + c[1] * square + c[0] * (square * s))

    def integral(self) -> float:
        """Return the integral of a curve of plain values from the first to the last point."""
        c, s = self.coefficients, np.diff(self.x)
        square = s * s
        cube = square * s
        parts = c[3] * s + c[2] * square * (1 / 2) + c[1] * cube * (1 / 3) + c[0] * (cube * s) * (1 / 4)
        return float(np.cumsum(parts)[-1])


def _slopes(h: FloatArray, secant: FloatArray) -> FloatArray:
    """Return the slopes at the points from their distances h and the secants between them (n - 1, ...)."""
    if len(secant) == 1:
        return np.concatenate([secant, secant])
    before, after = secant[:-1], secant[1:]
    turning = (np.sign(before) != np.sign(after)) | (before == 0) | (after == 0)
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = np.where(turning, 0.0, 1.0 / ((w1 / before + w2 / after) / (w1 + w2)))
    first = _end_slope(h[:1], h[1:2], secant[:1], secant[1:2])
    last = _end_slope(h[-1:], h[-2:-1], secant[-1:], secant[-2:-1])
    return np.concatenate([first, inner, last])


def _end_slope(h0: FloatArray, h1: FloatArray, m0: FloatArray, m1: FloatArray) -> FloatArray:
    """Return the slope at an end from the two distances and secants next to it, bounded so that nothing overshoots."""
    slope = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1)
    steep = (np.sign(m0) != np.sign(m1)) & (np.abs(slope) > 3.0 * np.abs(m0))
    return np.where(np.sign(slope) != np.sign(m0), 0.0, np.where(steep, 3.0 * m0, slope))

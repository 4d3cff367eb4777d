"""Arc length of a loop's parameter and back, to rounding.

The speed ``|d gamma/dt|`` of Eq. 1 has the period pi, so half a loop is all that is tabulated: Gauss-Legendre
quadrature panel by panel, and inside a panel from its left end; the way back is Newton's. It has that period for every
whole `wave` of a loop; for others the table holds from 0 to pi alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.angles import cosines_sines, sine

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.loop_shape import LoopShape

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_TOLERANCE: Final = 1e-13
_FIRST_PANELS: Final = 32
_MOST_NEWTON_STEPS: Final = 12


def derivatives(stitch: LoopShape, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the first and second derivative of Eq. 1 by t, each (n, 3) [loop widths]."""
    a, h, d, m = stitch.curvature, stitch.height, stitch.depth, stitch.wave
    (cosine_once, sine_once), (cosine_twice, sine_twice) = cosines_sines(t), cosines_sines(2.0 * t)
    cosine_wave, sine_wave = cosines_sines(m * t)
    course_second = -2.0 * a * sine_twice / np.pi
    second = np.stack([course_second, -h * cosine_once, -(m * m) * d * cosine_wave], axis=-1)
    return _first(stitch, sine_once, cosine_twice, sine_wave), second


def _first(stitch: LoopShape, sine_once: FloatArray, cosine_twice: FloatArray, sine_wave: FloatArray) -> FloatArray:
    """Return the first derivative from the sine of t, the cosine of 2 t and the sine of the wave."""
    course = (1.0 + 2.0 * stitch.curvature * cosine_twice) / (2.0 * np.pi)
    return np.stack([course, -stitch.height * sine_once, -stitch.wave * stitch.depth * sine_wave], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ArcTable:
    """Arc length of half a loop at evenly spaced t.

    Parameters
    ----------
    stitch : LoopShape
        The loop.
    knots : FloatArray
        (k + 1,) values of t from 0 to pi [rad].
    lengths : FloatArray
        (k + 1,) arc length from t = 0 to each knot [loop widths].
    """

    stitch: LoopShape
    knots: FloatArray
    lengths: FloatArray

    @property
    def loop_length(self) -> float:
        """Return the yarn length of one loop [loop widths]."""
        return 2.0 * float(self.lengths[-1])

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from parameter 0 to each t, (n,) -> (n,) [loop widths]."""
        halves, rest = np.divmod(t, np.pi)
        panel = np.clip(np.searchsorted(self.knots, rest, side="right") - 1, 0, self.knots.size - 2)
        arc_length: FloatArray = halves * self.lengths[-1] + self._within(panel, rest)
        return arc_length

    def parameter(self, s: FloatArray) -> FloatArray:
        """Return the parameter t at each arc length from t = 0, (n,) -> (n,) [rad]."""
        halves, rest = np.divmod(s, self.lengths[-1])
        panel = np.clip(np.searchsorted(self.lengths, rest, side="right") - 1, 0, self.knots.size - 2)
        left, right = self.knots[panel], self.knots[panel + 1]
        t: FloatArray = np.interp(rest, self.lengths, self.knots)
        for _ in range(_MOST_NEWTON_STEPS):
            before = t
            t = np.clip(t - (self._within(panel, t) - rest) / _speed(self.stitch, t), left, right)
            if np.all(np.abs(t - before) <= _TOLERANCE):
                break
        parameter: FloatArray = halves * np.pi + t
        return parameter

    def _within(self, panel: IndexArray, t: FloatArray) -> FloatArray:
        half_width = 0.5 * (t - self.knots[panel])
        points = self.knots[panel][:, None] + half_width[:, None] * (1.0 + _ABSCISSAE)
        within: FloatArray = self.lengths[panel] + half_width * _weighted(_speed(self.stitch, points))
        return within


@lru_cache(maxsize=64)
def arc_table(stitch: LoopShape) -> ArcTable:
    """Tabulate half a loop, with as many panels as 13 digits of its length ask for."""
    panels, total = _FIRST_PANELS, 0.0
    while True:
        table = _tabulate(stitch, panels)
        if abs(table.loop_length - total) <= _TOLERANCE * table.loop_length:
            return table
        panels, total = 2 * panels, table.loop_length


def yarn_per_loop(stitch: LoopShape) -> float:
    """Return the yarn length of one loop, turn-arounds left out [loop widths].

    Examples
    --------
    >>> from knitlab_core.knits.stitch import NAMED_STITCHES
    >>> round(yarn_per_loop(NAMED_STITCHES["stockinette-default"]), 3)
    4.777
    """
    return arc_table(stitch).loop_length


def tightest_bend(stitch: LoopShape) -> tuple[float, float]:
    """Return the largest curvature of a loop [1/loop width] and the parameter it is found at [rad].

    ``|gamma' x gamma''| / |gamma'|^3``; sampled at 4097 points of half a loop, well within 1e-5.
    """
    t = np.linspace(0.0, math.pi, 4097)
    first, second = derivatives(stitch, t)
    curvature = np.linalg.norm(np.cross(first, second), axis=-1) / np.linalg.norm(first, axis=-1) ** 3
    worst = int(np.argmax(curvature))
    return float(curvature[worst]), float(t[worst])


def _speed(stitch: LoopShape, t: FloatArray) -> FloatArray:
    (cosine_twice, _), (_, sine_wave) = cosines_sines(2.0 * t), cosines_sines(stitch.wave * t)
    speed: FloatArray = np.linalg.norm(_first(stitch, sine(t), cosine_twice, sine_wave), axis=-1)
    return speed


def _weighted(values: FloatArray) -> FloatArray:
    """Sum values (n, 16) at the abscissae; BLAS adds in an order that depends on the processor."""
    total: FloatArray = np.sum(values * _WEIGHTS, axis=-1)
    return total


def _tabulate(stitch: LoopShape, panels: int) -> ArcTable:
    knots = np.linspace(0.0, math.pi, panels + 1)
    half_width = 0.5 * np.diff(knots)
    points = knots[:-1, None] + half_width[:, None] * (1.0 + _ABSCISSAE)
    pieces = half_width * _weighted(_speed(stitch, points))
    return ArcTable(stitch=stitch, knots=knots, lengths=np.concatenate([[0.0], np.cumsum(pieces)]))

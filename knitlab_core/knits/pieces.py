"""Shape the two kinds of piece a yarn is made of: rows of loops and turn-arounds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from knitlab_core.angles import cosine, sine
from knitlab_core.knits.arclength import arc_table, derivatives

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.loop_shape import LoopShape


class Piece(Protocol):
    """Protocol of a curve by its own arc length, from 0 to `length` [loop widths]."""

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, d tangent/ds, (n,) -> (n, 3) [1/loop width]."""

    def place(self, s: float) -> str:
        """Return the place as text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Run through one row of loops; odd rows are knitted backwards.

    ``gamma(t) = [(t + a sin 2t)/2pi, h cos t + k w, d cos 2t]`` for t from -pi to (2N - 1) pi (Eq. 1 of the
    paper, with row k lifted by k w): loop j has its head at t = 2 pi j. A loop of another whole `wave` has that
    multiple of t in the last coordinate.

    Parameters
    ----------
    stitch : LoopShape
        The loop.
    row : int
        Number of the row k, from 0.
    loops : int
        Number of loops N.
    """

    stitch: LoopShape
    row: int
    loops: int

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return self.loops * arc_table(self.stitch).loop_length

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""
        return -1 if self.row % 2 else 1

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to each parameter, (n,) -> (n,)."""
        along = arc_table(self.stitch).arc_length(t + np.pi)
        return along if self.direction > 0 else self.length - along

    def parameter(self, s: FloatArray) -> FloatArray:
        """Return the parameter t at each arc length from the row's own start, (n,) -> (n,) [rad]."""
        along = s if self.direction > 0 else self.length - s
        return arc_table(self.stitch).parameter(along) - np.pi

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        t, stitch = self.parameter(s), self.stitch
        course = (t + stitch.curvature * sine(2.0 * t)) / (2.0 * np.pi)
        wale = stitch.height * cosine(t) + self.row * stitch.row_spacing
        return np.stack([course, wale, stitch.depth * cosine(stitch.wave * t)], axis=-1)

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        first, _ = derivatives(self.stitch, self.parameter(s))
        tangent: FloatArray = self.direction * first / np.linalg.norm(first, axis=-1, keepdims=True)
        return tangent

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width].

        ``(gamma'' - T (T . gamma'')) / |gamma'|^2``, the same in both directions.
        """
        first, second = derivatives(self.stitch, self.parameter(s))
        squared_speed = np.sum(first * first, axis=-1, keepdims=True)
        along = np.sum(first * second, axis=-1, keepdims=True) / squared_speed
        curvature: FloatArray = (second - along * first) / squared_speed
        return curvature

    def place(self, s: float) -> str:
        """Return row and loop as text, counted from 0."""
        t = float(self.parameter(np.array([s]))[0])
        loop = min(max(math.floor((t + math.pi) / (2.0 * math.pi)), 0), self.loops - 1)
        return f"row {self.row}, loop {loop}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """Lead from one row to the next by a semicircle that leaves along the course and comes back along it.

    Rows end where their yarn runs along the course, so tangents match at both ends.

    Parameters
    ----------
    centre : tuple of float
        Midway between the two ends [loop widths].
    radius : float
        Half of their distance [loop widths].
    side : {1, -1}
        +1 for a turn on the course+ side, -1 on the course- side.
    across : tuple of float
        Unit vector from its first end to its second, normal to the course.
    joins : str
        What it leads from and to, in the words of a knitter.
    """

    centre: tuple[float, float, float]
    radius: float
    side: int
    across: tuple[float, float, float]
    joins: str

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return math.pi * self.radius

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        return np.array(self.centre) + self.radius * self._outward(s)

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        angle = s / self.radius
        return self._combine(self.side * cosine(angle), sine(angle))

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width]."""
        return -self._outward(s) / self.radius

    def place(self, s: float) -> str:
        """Return what it joins as text, counted from 0."""
        part = "first" if s < 0.5 * self.length else "second"
        return f"turn-around {self.joins}, {part} half"

    def _outward(self, s: FloatArray) -> FloatArray:
        angle = s / self.radius
        return self._combine(self.side * sine(angle), -cosine(angle))

    def _combine(self, course: FloatArray, across: FloatArray) -> FloatArray:
        _, y, z = self.across
        return np.stack([course, y * across, z * across], axis=-1)

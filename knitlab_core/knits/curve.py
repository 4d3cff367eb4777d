"""Curve through given points, by its own arc length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray, IndexArray

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_STENCIL: Final = 5
_MOST_NEWTON_STEPS: Final = 12
_TOLERANCE: Final = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """Pass through points on cubics that share their tangents (Hermite), so the curve is C1.

    A tangent is that of the quartic through five neighbouring points, over their chord lengths: the error of the curve
    is of fourth order in the distance of the points. It is a `Piece`.

    Parameters
    ----------
    points : FloatArray
        (n, 3), five or more, neighbours apart [loop widths].
    knots : FloatArray
        (n,) chord length up to each point [loop widths].
    slopes : FloatArray
        (n, 3) derivative by chord length at each point [1].
    lengths : FloatArray
        (n,) arc length up to each point [loop widths].
    """

    points: FloatArray
    knots: FloatArray
    slopes: FloatArray
    lengths: FloatArray

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return float(self.lengths[-1])

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        return self._evaluated(s, 0)

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        first = self._evaluated(s, 1)
        tangent: FloatArray = first / np.linalg.norm(first, axis=-1, keepdims=True)
        return tangent

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width]; they jump a little at every point."""
        first, second = self._evaluated(s, 1), self._evaluated(s, 2)
        squared_speed = np.sum(first * first, axis=-1, keepdims=True)
        along = np.sum(first * second, axis=-1, keepdims=True) / squared_speed
        curvature: FloatArray = (second - along * first) / squared_speed
        return curvature

    def place(self, s: float) -> str:
        """Name the given points on either side, counted from 1."""
        before = int(np.clip(np.searchsorted(self.lengths, s, side="right"), 1, len(self.lengths) - 1))
        return f"points {before} to {before + 1}"

    def _evaluated(self, s: FloatArray, order: int) -> FloatArray:
        """Return the curve or a derivative of it by chord length at arc lengths, (n,) -> (n, 3)."""
        piece = np.clip(np.searchsorted(self.lengths, s, side="right") - 1, 0, len(self.lengths) - 2)
        return _hermite(self.points, self.knots, self.slopes, piece, self._parameter(piece, s), order)

    def _parameter(self, piece: IndexArray, s: FloatArray) -> FloatArray:
        """Return the share of its cubic's chord at which each arc length is found, by Newton's method."""
        chord, wanted = np.diff(self.knots)[piece], s - self.lengths[piece]
        share: FloatArray = np.clip(wanted / np.diff(self.lengths)[piece], 0.0, 1.0)
        for _ in range(_MOST_NEWTON_STEPS):
            before = share
            speed = np.linalg.norm(_hermite(self.points, self.knots, self.slopes, piece, share, 1), axis=-1)
            reached = _arc_lengths(self.points, self.knots, self.slopes, piece, share)
            share = np.clip(share - (reached - wanted) / (speed * chord), 0.0, 1.0)
            if np.all(np.abs(share - before) <= _TOLERANCE):
                break
        return share


@lru_cache(maxsize=4)
def curve_through(points: tuple[tuple[float, float, float], ...]) -> Curve:
    """Return the curve through points, five or more, no two neighbours in one place [loop widths]."""
    at = np.array(points)
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=-1))])
    slopes = _slopes(at, knots)
    pieces = np.arange(len(at) - 1)
    each = _arc_lengths(at, knots, slopes, pieces, np.ones(len(pieces)))
    lengths = np.concatenate([[0.0], np.cumsum(each)])
    return Curve(points=at, knots=knots, slopes=slopes, lengths=lengths)


def _slopes(points: FloatArray, knots: FloatArray) -> FloatArray:
    """Return the derivative (n, 3) of the quartic through each point and its four nearest along the curve."""
    count = len(points)
    first = np.clip(np.arange(count) - _STENCIL // 2, 0, count - _STENCIL)
    near = first[:, None] + np.arange(_STENCIL)
    own = np.arange(count) - first
    u = knots[near] - knots[:, None]
    slopes = np.zeros_like(points)
    for k in range(_STENCIL):
        others = [j for j in range(_STENCIL) if j != k]
        below = np.prod([u[:, k] - u[:, j] for j in others], axis=0)
        # Lagrange's basis at its own point has the sum of the reciprocals, at another the product without it.
        at_own = np.sum([1.0 / (u[:, k] - u[:, j]) for j in others], axis=0)
        elsewhere = np.zeros(count)
        for j in others:
            rest = np.prod([-u[:, i] for i in others if i != j], axis=0)
            elsewhere = np.where(own == j, rest, elsewhere)
        weight = np.where(own == k, at_own, elsewhere / below)
        slopes += weight[:, None] * points[near[:, k]]
    return slopes


def _hermite(
    points: FloatArray, knots: FloatArray, slopes: FloatArray, piece: IndexArray, share: FloatArray, order: int
) -> FloatArray:
    """Return points on cubics, or their derivatives by chord length, (n,) -> (n, 3); share runs from 0 to 1."""
    v, chord = share[:, None], np.diff(knots)[piece][:, None]
    p, q, m, n = points[piece], points[piece + 1], slopes[piece] * chord, slopes[piece + 1] * chord
    across = q - p
    b, c = 3.0 * across - 2.0 * m - n, m + n - 2.0 * across
    if order == 0:
        value: FloatArray = p + v * (m + v * (b + v * c))
    elif order == 1:
        value = (m + v * (2.0 * b + 3.0 * v * c)) / chord
    else:
        value = (2.0 * b + 6.0 * v * c) / chord**2
    return value


def _arc_lengths(
    points: FloatArray, knots: FloatArray, slopes: FloatArray, piece: IndexArray, share: FloatArray
) -> FloatArray:
    """Return the arc length from the start of each cubic to a share of it, (n,) -> (n,), by Gauss's quadrature."""
    half = 0.5 * share[:, None] * np.ones(len(_WEIGHTS))
    at = (half * (1.0 + _ABSCISSAE)).ravel()
    pieces = np.repeat(piece, len(_WEIGHTS))
    speed = np.linalg.norm(_hermite(points, knots, slopes, pieces, at, 1), axis=-1).reshape(half.shape)
    lengths: FloatArray = np.sum(speed * _WEIGHTS, axis=-1) * half[:, 0] * np.diff(knots)[piece]
    return lengths

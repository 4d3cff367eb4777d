"""Rib 1x1, knit and purl wales in turn: neighbouring loops of a row lie on different sides of the fabric.

The yarn changes sides once more in every sinker: ``z = d cos(5t/2)`` for ``d cos 2t``, which has the opposite sign one
loop farther on. Where a row begins and ends no loop follows; the half loop there is one of stockinette, so that turns
leave along the course.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final, NamedTuple

import numpy as np

from knitlab_core.angles import cosine, sine
from knitlab_core.arrays import BoolArray, FloatArray  # noqa: TC001 - a NamedTuple's fields are read at run time
from knitlab_core.knits.arclength import arc_table, derivatives
from knitlab_core.knits.loop_shape import LoopShape
from knitlab_core.knits.pieces import Turn
from knitlab_core.knits.stitch import Stitch

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits.planar import PlanarRow


class _Spot(NamedTuple):
    """Return where on a row some arc lengths are."""

    t: FloatArray
    """Parameter of the row [rad]."""
    edge: BoolArray
    """Whether each is on the half loop of stockinette at either end."""
    front: FloatArray
    """Sign of z on such a half loop: -1 where it ends a purl wale; elsewhere 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RibRow:
    """Run through one row of loops that face front and back in turn; odd rows are knitted backwards.

    ``gamma(t) = [(t + a sin 2t)/2pi, h cos t + k w, d cos(5t/2)]`` for t from 0 to 2 (N - 1) pi, loop j with its head
    at t = 2 pi j; before and after, from foot to first head and from last head to foot, z is ``d cos 2t`` with the
    sign of that loop. Curvature jumps at these two heads, tangents do not.

    Parameters
    ----------
    rib : Rib
        The loop.
    row : int
        Number of the row k, from 0.
    loops : int
        Number of loops N.
    """

    rib: Rib
    row: int
    loops: int

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        edge, inner = self._half_lengths
        return 2.0 * edge + 2.0 * (self.loops - 1) * inner

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""
        return -1 if self.row % 2 else 1

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to each parameter, (n,) -> (n,) [loop widths]."""
        half = np.clip(np.floor(t / np.pi) + 1.0, 0.0, 2.0 * self.loops - 1.0)
        from_head = np.abs(t - _head(half))
        edge, start, reach = self._stretch(half)
        tables = arc_table(self.rib.edge_loop), arc_table(self.rib)
        arc = np.where(edge, *(table.arc_length(from_head) for table in tables))
        along: FloatArray = start + np.where(half % 2.0 == 0.0, reach - arc, arc)
        return along if self.direction > 0 else self.length - along

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        spot, rib = self._spot(s), self.rib
        course = (spot.t + rib.curvature * sine(2.0 * spot.t)) / (2.0 * np.pi)
        wale = rib.height * cosine(spot.t) + self.row * rib.row_spacing
        out = np.where(spot.edge, rib.edge_loop.wave, rib.wave)
        return np.stack([course, wale, spot.front * rib.depth * cosine(out * spot.t)], axis=-1)

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        first, _ = self._derivatives(s)
        tangent: FloatArray = self.direction * first / np.linalg.norm(first, axis=-1, keepdims=True)
        return tangent

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width]; they jump at the first and the last head."""
        first, second = self._derivatives(s)
        squared_speed = np.sum(first * first, axis=-1, keepdims=True)
        along = np.sum(first * second, axis=-1, keepdims=True) / squared_speed
        curvature: FloatArray = (second - along * first) / squared_speed
        return curvature

    def place(self, s: float) -> str:
        """Return row and loop as text, counted from 0."""
        t = float(self._spot(np.array([s])).t[0])
        return f"row {self.row}, loop {min(max(math.floor((t + math.pi) / (2.0 * math.pi)), 0), self.loops - 1)}"

    @property
    def _half_lengths(self) -> tuple[float, float]:
        """Return the arc lengths of half a loop at the row's ends and of one between [loop widths]."""
        return 0.5 * arc_table(self.rib.edge_loop).loop_length, 0.5 * arc_table(self.rib).loop_length

    def _stretch(self, half: FloatArray) -> tuple[BoolArray, FloatArray, FloatArray]:
        """Return of half loops, counted from the row's left end, whether they end it, their start and their length."""
        at_edge, inner = self._half_lengths
        edge = (half == 0.0) | (half == 2.0 * self.loops - 1.0)
        start = np.where(half > 0.0, at_edge + (half - 1.0) * inner, 0.0)
        return edge, start, np.where(edge, at_edge, inner)

    def _spot(self, s: FloatArray) -> _Spot:
        along = s if self.direction > 0 else self.length - s
        at_edge, inner = self._half_lengths
        half = np.clip(np.floor((along - at_edge) / inner) + 1.0, 0.0, 2.0 * self.loops - 1.0)
        edge, start, reach = self._stretch(half)
        rising = half % 2.0 == 0.0
        arc = np.clip(np.where(rising, start + reach - along, along - start), 0.0, reach)
        tables = arc_table(self.rib.edge_loop), arc_table(self.rib)
        from_head = np.where(edge, *(table.parameter(arc) for table in tables))
        last = half == 2.0 * self.loops - 1.0
        return _Spot(
            t=_head(half) + np.where(rising, -from_head, from_head),
            edge=edge,
            front=np.where(last, front(self.loops - 1), 1.0),
        )

    def _derivatives(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the first and second derivative by the parameter, each (n, 3) [loop widths]."""
        spot = self._spot(s)
        mirror = np.stack([np.ones_like(s), np.ones_like(s), spot.front], axis=-1)
        loops = derivatives(self.rib.edge_loop, spot.t), derivatives(self.rib, spot.t)
        first, second = (np.where(spot.edge[:, None], at_edge, inner) for at_edge, inner in zip(*loops, strict=True))
        return first * mirror, second * mirror


def _head(half: FloatArray) -> FloatArray:
    """Return the parameter of the head that a half loop leads to or from [rad]."""
    head: FloatArray = 2.0 * np.pi * np.floor(0.5 * half)
    return head


def front(loop: int) -> float:
    """Return 1 for a knit wale, -1 for a purl one."""
    return -1.0 if loop % 2 else 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Rib(Stitch):
    """Knit rib 1x1: every other wale is purl, the first one knit. A `Fabric` with the numbers of `LoopShape`."""

    wave: ClassVar[float] = 2.5
    locking_error: ClassVar[float] = 0.04

    @property
    def edge_loop(self) -> LoopShape:
        """Return the loop of stockinette that a row begins and ends with half of."""
        return LoopShape(
            curvature=self.curvature,
            height=self.height,
            depth=self.depth,
            row_spacing=self.row_spacing,
            fibre_radius=self.fibre_radius,
        )

    @property
    def shapes(self) -> tuple[LoopShape, ...]:
        """Return the loops between and at the ends of rows."""
        return (self, self.edge_loop)

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; even ones run along +x, odd ones back."""
        return RibRow(rib=self, row=number, loops=loops)

    def turn(self, number: int, loops: int) -> Turn:
        """Return the turn-around from a row to the next, on the side of the fabric of the wale that it joins."""
        side = -1 if number % 2 else 1
        x, y = loops - 0.5 if side > 0 else -0.5, (number + 0.5) * self.row_spacing - self.height
        return Turn(
            centre=(x, y, self.depth * (front(loops - 1) if side > 0 else 1.0)),
            radius=0.5 * self.row_spacing,
            side=side,
            across=(0.0, 1.0, 0.0),
            joins=f"from row {number} to row {number + 1}",
        )


NAMED_RIBS: Final[Mapping[str, Rib]] = MappingProxyType(
    {"rib-1x1": Rib(curvature=1.5, height=0.80, depth=0.25, row_spacing=0.88, fibre_radius=0.050)}
)
"""Rib by name."""

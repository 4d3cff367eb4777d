"""Garter, knit and purl rows in turn: every row's heads lie on the other side of the fabric than those before.

A row holds the row below from one side and is held by the row above from the other. So its yarn changes sides twice
between foot and head, and once more than in stockinette: ``z = d cos 3t`` for ``d cos 2t``; the next row is that row
mirrored, ``z = -d cos 3t``. Feet of neighbouring rows are 2 d apart in z, and the turn-around between them is tilted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from knitlab_core.knits.pieces import Row, Turn
from knitlab_core.knits.stitch import Stitch

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.planar import PlanarRow


@dataclass(frozen=True, slots=True, kw_only=True)
class PurlRow:
    """Run through a row seen from the other side: a row of loops with front and back exchanged.

    Parameters
    ----------
    knit_row : PlanarRow
        The row as it is from the front.
    """

    knit_row: PlanarRow

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return self.knit_row.length

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""
        return self.knit_row.direction

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to each parameter, (n,) -> (n,) [loop widths]."""
        return self.knit_row.arc_length(t)

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        return _mirrored(self.knit_row.position(s))

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        return _mirrored(self.knit_row.tangent(s))

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width]."""
        return _mirrored(self.knit_row.curvature(s))

    def place(self, s: float) -> str:
        """Return row and loop as text, counted from 0."""
        return self.knit_row.place(s)


def _mirrored(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 3) with front and back exchanged."""
    mirrored: FloatArray = vectors * np.array([1.0, 1.0, -1.0])
    return mirrored


@dataclass(frozen=True, slots=True, kw_only=True)
class Garter(Stitch):
    """Knit garter: even rows as `Row`, odd rows mirrored. A `Fabric` with the numbers of `LoopShape`."""

    wave: ClassVar[float] = 3.0
    locking_error: ClassVar[float] = 0.04

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; even ones are knit, odd ones purl."""
        row = Row(stitch=self, row=number, loops=loops)
        return PurlRow(knit_row=row) if number % 2 else row

    def turn(self, number: int, loops: int) -> Turn:
        """Return the turn-around from a row to the next, w higher and on the other side of the fabric."""
        side = -1 if number % 2 else 1
        x, y = loops - 0.5 if side > 0 else -0.5, (number + 0.5) * self.row_spacing - self.height
        diameter = math.hypot(self.row_spacing, 2.0 * self.depth)
        return Turn(
            centre=(x, y, 0.0),
            radius=0.5 * diameter,
            side=side,
            # The feet of even rows are at z = -d, those of odd ones at z = d.
            across=(0.0, self.row_spacing / diameter, 2.0 * side * self.depth / diameter),
            joins=f"from row {number} to row {number + 1}",
        )


NAMED_GARTERS: Final[Mapping[str, Garter]] = MappingProxyType(
    {"garter": Garter(curvature=1.5, height=0.80, depth=0.25, row_spacing=1.00, fibre_radius=0.050)}
)
"""Garter by name: the default loop with its rows farther apart, for heads of one row meet legs of the next."""

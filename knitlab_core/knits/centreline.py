"""String pieces to one yarn, and name the spots on it where fixtures take hold."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.pieces import Piece

SiteSet: TypeAlias = Literal["wale+", "wale-", "course+", "course-", "pile+", "pile-"]
_END_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Mark one spot of the yarn on the knit's edge or face; it is an arc length, not a node.

    Parameters
    ----------
    set : {'wale+', 'wale-', 'course+', 'course-', 'pile+', 'pile-'}
        The edge (of a planar knit) or face (of a volumetric one) it belongs to.
    row, loop : int
        The loop or stitch it sits on, counted from 0, loops along +x, rows along +y.
    arc_length : float
        Where on the yarn [loop widths].
    layer : int
        Counted from 0 along +z; 0 in a planar knit.
    """

    set: SiteSet
    row: int
    loop: int
    arc_length: float
    layer: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Centreline:
    """Centreline of one contiguous yarn, by arc length.

    Parameters
    ----------
    pieces : tuple of Piece
        The pieces in the order of the yarn, each beginning where and as the last one ends (C1).
    sites : tuple of Site
        Boundary sites, each set ordered along its edge (+x or +y), on a face by layer, row and +x.

    Notes
    -----
    ``position``, ``tangent`` and ``curvature`` are all that a strand laid beside this curve needs.
    """

    pieces: tuple[Piece, ...]
    sites: tuple[Site, ...]
    starts: FloatArray = field(init=False, repr=False)
    """(p + 1,) arc length at the start of each piece, and the whole length [loop widths]."""

    def __post_init__(self) -> None:
        lengths = [piece.length for piece in self.pieces]
        object.__setattr__(self, "starts", np.concatenate([[0.0], np.cumsum(lengths)]))

    @property
    def length(self) -> float:
        """Return the length of the yarn [loop widths]."""
        return float(self.starts[-1])

    def position(self, s: FloatArray) -> FloatArray:
        """Return points at arc lengths s, (n,) -> (n, 3) [loop widths]."""
        return self._gather(s, lambda piece, local: piece.position(local))

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents at arc lengths s, (n,) -> (n, 3)."""
        return self._gather(s, lambda piece, local: piece.tangent(local))

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors at arc lengths s, (n,) -> (n, 3) [1/loop width].

        It jumps where a row and a turn-around meet; there the later piece's value is given.
        """
        return self._gather(s, lambda piece, local: piece.curvature(local))

    def place(self, s: float) -> str:
        """Return the place of arc length s as text: row and loop."""
        index = int(self._piece_index(np.array([s]))[0])
        return self.pieces[index].place(s - float(self.starts[index]))

    def _piece_index(self, s: FloatArray) -> IndexArray:
        index = np.searchsorted(self.starts, s, side="right") - 1
        return np.clip(index, 0, len(self.pieces) - 1)

    def _gather(self, s: FloatArray, evaluate: Callable[[Piece, FloatArray], FloatArray]) -> FloatArray:
        s = np.asarray(s, dtype=np.float64)
        slack = _END_TOLERANCE * self.length
        outside = ~((s >= -slack) & (s <= self.length + slack))
        if outside.any():
            raise SpecificationError("arc_length", float(s[outside][0]), f"0 to {self.length:g} loop widths")
        index = self._piece_index(s)
        order = np.argsort(index, kind="stable")
        bounds = np.searchsorted(index[order], np.arange(len(self.pieces) + 1))
        values = np.empty((s.size, 3))
        for piece in np.unique(index):
            chosen = order[bounds[piece] : bounds[piece + 1]]
            values[chosen] = evaluate(self.pieces[piece], s[chosen] - self.starts[piece])
        return values

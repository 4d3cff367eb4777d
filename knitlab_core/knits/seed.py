"""Seed, knit and purl in turn along the row and from row to row: each loop is on the other side than its neighbours.

A loop is held from the one side and holds from the other, as in garter, and its neighbours in the row are its mirror
image, as in rib: the yarn changes sides as often as garter's between foot and head and once more in every sinker,
``z = d cos(7t/2)``. The next row is that row mirrored. Rows begin and end with half a loop of garter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

from knitlab_core.knits.garter import Garter, PurlRow
from knitlab_core.knits.rib import Rib, RibRow, front

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits.pieces import Turn
    from knitlab_core.knits.planar import PlanarRow


@dataclass(frozen=True, slots=True, kw_only=True)
class Seed(Rib):
    """Knit seed: even rows begin with a knit loop, odd ones with a purl. A `Fabric` with the numbers of `LoopShape`."""

    wave: ClassVar[float] = 3.5

    @property
    def edge_loop(self) -> Garter:
        """Return the loop of garter that a row begins and ends with half of."""
        return Garter(
            curvature=self.curvature,
            height=self.height,
            depth=self.depth,
            row_spacing=self.row_spacing,
            fibre_radius=self.fibre_radius,
        )

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; odd ones run back, and have front and back exchanged."""
        row = RibRow(rib=self, row=number, loops=loops)
        return PurlRow(knit_row=row) if number % 2 else row

    def turn(self, number: int, loops: int) -> Turn:
        """Return the turn-around from a row to the next: that of garter, mirrored behind a loop that even rows purl."""
        turn = self.edge_loop.turn(number, loops)
        course, wale, pile = turn.across
        return turn if number % 2 else replace(turn, across=(course, wale, front(loops - 1) * pile))


NAMED_SEEDS: Final[Mapping[str, Seed]] = MappingProxyType(
    {"seed": Seed(curvature=1.5, height=0.80, depth=0.25, row_spacing=1.08, fibre_radius=0.050)}
)
"""Seed by name."""

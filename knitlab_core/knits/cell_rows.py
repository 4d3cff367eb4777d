"""Rows of a periodic cell, cut out of a knit, and the vectors after which they repeat.

A row goes on along the course: it leaves the cell on one side and enters on the other. Along the wale and the pile no
yarn leaves: rows and layers are held by the loops of their images.
"""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeAlias, TypeGuard

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fabric import Counts, Fabric
from knitlab_core.knits.planar import PlanarKnit
from knitlab_core.knits.volumetric import numbered_row, row_number
from knitlab_core.knits.volumetric_stitch import VolumetricStitch

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.planar import PlanarRow
    from knitlab_core.knits.volumetric_row import VolumetricRow

MARGIN: Final = 2
"""Loops beside the cell in the rows that it is cut from: some knits' rows end with loops of another shape."""

WIDEST: Final = 2
"""Loops along a row within which two may touch."""

DENSEST: Final = 6
"""Rows or layers next to one of them in which denser ones would overlap at once."""

LEANING: Final = "an even number: layers lean along the wale and against it in turn, so that the knit repeats after two"

_SAME: Final = 1e-6
"""How near places and directions must be that are to be one [loop widths], [1]."""


class PlanarFabric(Fabric, PlanarKnit, Protocol):
    """Protocol of a fabric of planar rows, which a periodic cell can be cut from."""


CellFabric: TypeAlias = PlanarFabric | VolumetricStitch
"""Fabric that a periodic cell can be cut from."""


def is_planar(fabric: Fabric) -> TypeGuard[PlanarFabric]:
    """Return whether a fabric is made of planar rows."""
    return "P" not in fabric.axes and hasattr(fabric, "row") and hasattr(fabric, "row_spacing")


def has_cells(fabric: Fabric) -> TypeGuard[CellFabric]:
    """Return whether a fabric is made of rows that repeat: planar ones, or those of a volumetric stitch."""
    return isinstance(fabric, VolumetricStitch) or is_planar(fabric)


class CutRow(NamedTuple):
    """The loops of a row that are cut out: the row, where they begin, and their yarn length [loop widths]."""

    row: PlanarRow | VolumetricRow
    start: float
    length: float

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""
        return self.row.direction

    def at(self, share: FloatArray) -> FloatArray:
        """Return the points (n, 3) at shares of the stretch."""
        return self.row.position(self.start + self.length * share)

    def along(self, share: FloatArray) -> FloatArray:
        """Return the unit tangents (n, 3) at shares of the stretch."""
        return self.row.tangent(self.start + self.length * share)


class Cut(NamedTuple):
    """A cell as cut.

    `rows`: layer by layer, row by row; `vectors`: (D, 3) after which they repeat, and `middle` (3,) of the cell [loop
    widths]; `reach`: (D,) so many cells away strands may touch.
    """

    rows: tuple[CutRow, ...]
    vectors: FloatArray
    middle: FloatArray
    reach: tuple[int, ...]


def cut_cell(knit: CellFabric, counts: Counts) -> Cut:
    """Cut the rows of a cell out of a knit.

    Raises
    ------
    SpecificationError
        If the knit does not repeat after so many loops, rows or layers.
    """
    cut = _volumetric(knit, counts) if isinstance(knit, VolumetricStitch) else _planar(knit, counts)
    for row in cut.rows:
        _check_goes_on(row, cut.vectors[0], counts.loops)
    return cut


def _planar(knit: PlanarKnit, counts: Counts) -> Cut:
    """Cut a cell of a planar knit."""
    rows, loops = counts.rows, counts.loops

    def of(number: int) -> CutRow:
        row = knit.row(number, loops + 2 * MARGIN)
        return _between(row, row.arc_length(np.pi * np.array([2.0 * MARGIN - 1.0, 2.0 * (MARGIN + loops) - 1.0])))

    vectors = np.array([[float(loops), 0.0, 0.0], [0.0, rows * knit.row_spacing, 0.0]])
    cut = tuple(of(row) for row in range(rows))
    _check_repeats(cut[0], of(rows), vectors[1], rows)
    middle = np.array([0.5 * (loops + 2 * MARGIN - 1), 0.5 * (rows - 1) * knit.row_spacing, 0.0])
    # Loops as high as two rows, and wider than one of their own.
    height = max(shape.height for shape in knit.shapes)
    return Cut(cut, vectors, middle, (_cells(WIDEST, loops), _cells(2.0 * (height + knit.fibre_radius), vectors[1, 1])))


def _volumetric(knit: VolumetricStitch, counts: Counts) -> Cut:
    """Cut a cell of a volumetric knit: its layers lean along +y and -y in turn, so that it repeats after two."""
    rows, loops, layers = counts

    def of(row: int, layer: int) -> CutRow:
        whole = numbered_row(knit, row_number(row, layer, rows + 1), rows + 1, loops + 2 * MARGIN)
        ends = np.array([MARGIN, MARGIN + loops])
        return _between(whole, whole.arc_length(ends, pile=False, t=np.full(2, -np.pi)))

    if layers % 2:
        raise SpecificationError("specimen.layers", layers, LEANING)
    lengths = 2.0 * loops, rows * knit.row_spacing, layers * knit.layer_spacing
    vectors = np.diag(lengths)
    cut = tuple(of(row, layer) for layer in range(layers) for row in range(rows))
    _check_repeats(cut[0], of(rows, 0), vectors[1], rows)
    middle = 0.5 * (np.array(lengths) - [0.0, knit.row_spacing, knit.layer_spacing]) + [2.0 * MARGIN - 0.5, 0.0, 0.0]
    wale, pile = _reach_over(knit)
    return Cut(cut, vectors, middle, (_cells(WIDEST, lengths[0]), _cells(wale, lengths[1]), _cells(pile, lengths[2])))


def with_edges(knit: CellFabric, counts: Counts) -> Counts:
    """Return the size of a knit with edges whose inside is that of a cell.

    All yarn of a volumetric one is searched for strands that overlap, so it has no more rows and layers than may touch.
    """
    if not isinstance(knit, VolumetricStitch):
        return Counts(counts.rows + 2, counts.loops + 2)
    wale, pile = _reach_over(knit)
    rows, layers = _cells(wale, knit.row_spacing), _cells(pile, knit.layer_spacing)
    # Layers lean to and fro in turn: each kind has those above it.
    return Counts(1 + min(rows, DENSEST), 3, 2 + min(layers, DENSEST))


def _reach_over(knit: VolumetricStitch) -> tuple[float, float]:
    """Return how far loops reach along wale and pile: over their height, and across it by their depth [loop widths]."""
    aside = 2.0 * (knit.depth + knit.fibre_radius)
    return knit.wale_height + aside, knit.pile_height + aside


def _between(row: PlanarRow | VolumetricRow, feet: FloatArray) -> CutRow:
    """Cut a row at the two feet between which its loops in the cell are."""
    return CutRow(row, float(feet.min()), float(abs(feet[1] - feet[0])))


def _cells(distance: float, length: float) -> int:
    """Return how many cells of a length a distance reaches over."""
    return ceil(distance / length - _SAME)


def _check_goes_on(row: CutRow, vector: FloatArray, loops: int) -> None:
    """Refuse a row whose end is not its start moved by one period."""
    ends = np.array([0.0, 1.0])
    first, last = row.at(ends)
    before, after = row.along(ends)
    if max(np.abs(last - first - row.direction * vector).max(), np.abs(after - before).max()) > _SAME:
        raise SpecificationError("specimen.loops", f"{loops} in a row", "a number after which the knit repeats")


def _check_repeats(first: CutRow, after: CutRow, vector: FloatArray, count: int) -> None:
    """Refuse so many rows after which the knit does not begin again."""
    share = np.linspace(0.0, 1.0, 33)
    other = after.at(share if first.direction == after.direction else share[::-1])
    if abs(first.length - after.length) > _SAME or np.abs(other - first.at(share) - vector).max() > _SAME:
        raise SpecificationError("specimen.rows", count, "a number after which the knit repeats")

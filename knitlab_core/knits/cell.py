"""Cut a periodic cell from a planar knit: rows without ends, which leave on one side and enter on the other."""

from __future__ import annotations

from math import ceil
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeGuard

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fabric import Counts, Fabric
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn
from knitlab_core.knits.planar import PlanarKnit, check_count
from knitlab_core.knits.specimen import Cell, Specimen, check_size

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.planar import PlanarRow

MARGIN: Final = 2
"""Loops beside the cell in the rows that it is cut from: some knits' rows end with loops of another shape."""

WIDEST: Final = 2
"""Loops along a row within which two may touch."""

_SWEEPS: Final = 48
"""Passes in which the control points of a closed spline are found; each divides the error by three."""

_SAME: Final = 1e-6
"""How near places and directions must be that are to be one [loop widths], [1]."""


class PlanarFabric(Fabric, PlanarKnit, Protocol):
    """Protocol of a fabric of planar rows, which a periodic cell can be cut from."""


def is_planar(fabric: Fabric) -> TypeGuard[PlanarFabric]:
    """Return whether a fabric is made of planar rows."""
    return "P" not in fabric.axes and hasattr(fabric, "row") and hasattr(fabric, "row_spacing")


def knit_cell(
    knit: PlanarFabric,
    *,
    loop_width: float,
    rows: int,
    loops: int,
    nodes_per_loop: int = 48,
    yarn: Yarn | None = None,
    contact_radius: float | None = None,
) -> Specimen:
    """Build a periodic cell of a planar knit.

    Parameters
    ----------
    knit : PlanarFabric
        The knit; it must repeat after so many rows and loops.
    loop_width : float
        Width of a loop, l [m].
    rows, loops : int
        1 to 200 each.
    nodes_per_loop : int
        8 to 1000.
    yarn : Yarn, optional
        Its fibres, seen as one rod; one of the knit's own radius unless given.
    contact_radius : float, optional
        Radius at which strands touch once they are relaxed [m]; by default that of the yarn as laid. Strands of it may
        overlap as laid.

    Returns
    -------
    Specimen
        Its strands are the rows, each with the first two nodes of the next period at its end; it has no sites.

    Raises
    ------
    SpecificationError
        If the knit does not repeat so, or each fibre were to be a rod of its own.
    GeometryError
        As `knit_specimen`.
    """
    check_size(loop_width, nodes_per_loop)
    check_count("specimen.rows", rows, most=200)
    check_count("specimen.loops", loops, most=200)
    fibres = Yarn(fibre_radius=knit.fibre_radius) if yarn is None else yarn
    if fibres.model == "bundle" and fibres.fibres > 1:
        raise SpecificationError("specimen.yarn.model", "bundle", "yarn in a periodic cell: one rod for all fibres")
    counts = Counts(rows + 2, loops + 2)
    line = knit.centreline(counts)
    knit.check_held(counts)
    if yarn is None:
        gap = knit.clearance(line, counts, loop_width=loop_width)
    else:
        gap = check_fibres(line, yarn, loop_width=loop_width).between
    cut, vectors = _cut_rows(knit, rows, loops)
    edges = max(8, round(cut[0].length / knit.loop_length(counts) * nodes_per_loop))
    laid = fibres.contact_radius * loop_width
    radius = laid if contact_radius is None else contact_radius
    return Specimen(
        nodes=_nodes(knit, cut, vectors, edges) * loop_width,
        arc_lengths=cut[0].length / edges * np.arange(edges + 2, dtype=np.float64) * loop_width,
        yarn=fibres,
        radius=radius,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=1,
        fabric=knit,
        centreline=line,
        yarn_length=rows * cut[0].length * loop_width,
        clearance=gap * loop_width - 2.0 * (radius - laid),
        sites=MappingProxyType({}),
        cell=Cell(vectors * loop_width, tuple((row.direction, 0) for row in cut), _reach(knit, rows, loops)),
    )


def _cut_rows(knit: PlanarKnit, rows: int, loops: int) -> tuple[list[_Stretch], FloatArray]:
    """Return the rows of a cell and its vectors (2, 3) [loop widths]; refuse a knit that does not repeat so."""
    vectors = np.array([[float(loops), 0.0, 0.0], [0.0, rows * knit.row_spacing, 0.0]])
    *cut, after = (_cut(knit, row, loops) for row in range(rows + 1))
    for row in (*cut, after):
        _check_goes_on(row, vectors[0])
    _check_repeats(cut[0], after, vectors[1], rows)
    return cut, vectors


def _nodes(knit: PlanarKnit, cut: list[_Stretch], vectors: FloatArray, edges: int) -> FloatArray:
    """Return the nodes of a cell about its middle, row by row, each with two of the next period [loop widths]."""
    middle = np.array([0.5 * (vectors[0, 0] + 2 * MARGIN - 1), 0.5 * (len(cut) - 1) * knit.row_spacing, 0.0])
    rows = []
    for row in cut:
        period = row.direction * vectors[0]
        own = closed_control_points(row.at(np.arange(edges) / edges), period) - middle
        rows.append(np.concatenate([own, own[:2] + period]))
    return np.concatenate(rows)


class _Stretch(NamedTuple):
    """The loops of a row that are cut out: the row, where they begin, and their yarn length [loop widths]."""

    row: PlanarRow
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


def _cut(knit: PlanarKnit, number: int, loops: int) -> _Stretch:
    """Cut the loops of a cell out of a row."""
    row = knit.row(number, loops + 2 * MARGIN)
    feet = row.arc_length(np.pi * np.array([2.0 * MARGIN - 1.0, 2.0 * (MARGIN + loops) - 1.0]))
    return _Stretch(row, float(feet.min()), float(abs(feet[1] - feet[0])))


def _reach(knit: PlanarKnit, rows: int, loops: int) -> tuple[int, int]:
    """Return how many cells away strands may touch: loops as high as two rows, and wider than one of their own."""
    height = max(shape.height for shape in knit.shapes)
    apart = ceil(2.0 * (height + knit.fibre_radius) / knit.row_spacing)
    return ceil(WIDEST / loops), ceil(apart / rows)


def _check_goes_on(row: _Stretch, vector: FloatArray) -> None:
    """Refuse a row whose end is not its start moved by one period."""
    ends = np.array([0.0, 1.0])
    first, last = row.at(ends)
    before, after = row.along(ends)
    if max(np.abs(last - first - row.direction * vector).max(), np.abs(after - before).max()) > _SAME:
        loops = round(float(vector[0]))
        raise SpecificationError("specimen.loops", f"{loops} in a row", "a number after which the knit repeats")


def _check_repeats(first: _Stretch, after: _Stretch, vector: FloatArray, rows: int) -> None:
    """Refuse rows after which the knit does not begin again."""
    share = np.linspace(0.0, 1.0, 33)
    other = after.at(share if first.direction == after.direction else share[::-1])
    if abs(first.length - after.length) > _SAME or np.abs(other - first.at(share) - vector).max() > _SAME:
        raise SpecificationError("specimen.rows", rows, "a number after which the knit repeats")


def closed_control_points(points: FloatArray, period: FloatArray) -> FloatArray:
    """Return nodes (n, 3) whose endless quadratic B-spline passes through points that repeat after a period (3,)."""
    nodes = points.copy()
    for _ in range(_SWEEPS):
        before, after = np.roll(nodes, 1, axis=0), np.roll(nodes, -1, axis=0)
        before[0] -= period
        after[-1] += period
        nodes = (points - 0.125 * (before + after)) / 0.75
    return nodes

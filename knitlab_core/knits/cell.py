"""A periodic cell of a knit: rows without ends, which leave on one side and enter on the other, as nodes in metres."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.cell_rows import CellFabric, Cut, cut_cell, with_edges
from knitlab_core.knits.fabric import Counts
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn
from knitlab_core.knits.planar import check_count
from knitlab_core.knits.specimen import Cell, Specimen, check_size

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

_SWEEPS: Final = 48
"""Passes in which the control points of a closed spline are found; each divides the error by three."""


def knit_cell(
    knit: CellFabric,
    *,
    loop_width: float,
    rows: int,
    loops: int,
    layers: int = 1,
    nodes_per_loop: int = 48,
    yarn: Yarn | None = None,
    contact_radius: float | None = None,
) -> Specimen:
    """Build a periodic cell of a planar or a volumetric knit.

    Parameters
    ----------
    knit : CellFabric
        The knit; it must repeat after so many rows, loops and layers.
    loop_width : float
        Width of a loop, l [m].
    rows, loops, layers : int
        1 to 200 each; in a volumetric knit stitches of two loops each, and layers, which lean to and fro in turn, are
        even. A planar knit has one layer, and does not repeat across itself.
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
        Its strands are the rows, layer by layer, each with the first two nodes of the next period at its end; it has
        no sites.

    Raises
    ------
    SpecificationError
        If the knit does not repeat so, or each fibre were to be a rod of its own.
    GeometryError
        As `knit_specimen`.
    """
    check_size(loop_width, nodes_per_loop)
    counts = Counts(rows, loops, layers)
    for name, count in zip(("rows", "loops", "layers"), counts, strict=True):
        check_count(f"specimen.{name}", count, most=200)
    fibres = Yarn(fibre_radius=knit.fibre_radius) if yarn is None else yarn
    if fibres.model == "bundle" and fibres.fibres > 1:
        raise SpecificationError("specimen.yarn.model", "bundle", "yarn in a periodic cell: one rod for all fibres")
    within = with_edges(knit, counts)
    line = knit.centreline(within)
    knit.check_held(within)
    gap = _gap(knit, within, yarn, loop_width)
    cut = cut_cell(knit, counts)
    edges = max(8, round(cut.rows[0].length / knit.loop_length(within) * nodes_per_loop))
    laid = fibres.contact_radius * loop_width
    radius = laid if contact_radius is None else contact_radius
    return Specimen(
        nodes=_nodes(cut, edges) * loop_width,
        arc_lengths=cut.rows[0].length / edges * np.arange(edges + 2, dtype=np.float64) * loop_width,
        yarn=fibres,
        radius=radius,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=layers,
        fabric=knit,
        centreline=line,
        yarn_length=len(cut.rows) * cut.rows[0].length * loop_width,
        clearance=gap * loop_width - 2.0 * (radius - laid),
        sites=MappingProxyType({}),
        cell=_cell(cut, counts, loop_width),
    )


@lru_cache(maxsize=16)
def _gap(knit: CellFabric, within: Counts, yarn: Yarn | None, loop_width: float) -> float:
    """Return the least distance between the surfaces of yarns [loop widths]; refuse yarns that overlap."""
    line = knit.centreline(within)
    if yarn is None:
        return knit.clearance(line, within, loop_width=loop_width)
    return check_fibres(line, yarn, loop_width=loop_width).between


def _cell(cut: Cut, counts: Counts, loop_width: float) -> Cell:
    """Return what repeats.

    Rows of one layer are alike and keep their distance in an even stretch: one link between two of them exerts no
    force. Layers are not alike. There every two rows that are neighbours, images too, have links, and as many as
    stitches: else those of larger cells would pull otherwise.
    """
    shifts = tuple((row.direction, *(0 for _ in cut.vectors[1:])) for row in cut.rows)
    if len(cut.vectors) == 2:
        pairs, stitches = tuple(pairwise(range(counts.rows))), 1
    else:
        number = np.arange(counts.layers * counts.rows).reshape(counts.layers, counts.rows)
        ahead = [(number, np.roll(number, -1, axis=along)) for along in (1, 0) if number.shape[along] > 1]
        pairs = tuple((int(a), int(b)) for one, other in ahead for a, b in zip(one.flat, other.flat, strict=True))
        stitches = counts.loops
    return Cell(cut.vectors * loop_width, shifts, cut.reach, pairs, stitches)


def _nodes(cut: Cut, edges: int) -> FloatArray:
    """Return the nodes of a cell about its middle, row by row, each with two of the next period [loop widths]."""
    rows = []
    for row in cut.rows:
        period = row.direction * cut.vectors[0]
        own = closed_control_points(row.at(np.arange(edges) / edges), period) - cut.middle
        rows.append(np.concatenate([own, own[:2] + period]))
    return np.concatenate(rows)


def closed_control_points(points: FloatArray, period: FloatArray) -> FloatArray:
    """Return nodes (n, 3) whose endless quadratic B-spline passes through points that repeat after a period (3,)."""
    nodes = points.copy()
    for _ in range(_SWEEPS):
        before, after = np.roll(nodes, 1, axis=0), np.roll(nodes, -1, axis=0)
        before[0] -= period
        after[-1] += period
        nodes = (points - 0.125 * (before + after)) / 0.75
    return nodes

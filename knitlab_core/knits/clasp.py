"""Return whether a knit is knitted: whether its loops hold each other.

A head holds a loop if the yarn of that loop goes through it: up between the head's legs on one side of its apex and
down again on the other. So single loops are taken, from foot to foot, and the yarn of the loop that is held on either
side of its apex, as far as the next apex; and it is counted how often this yarn passes through the surface between
the head's legs. No curve is closed through the knit, which would cross other strands once the knit is drawn out.
"""

from __future__ import annotations

from math import prod
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.knits.crossing import crossing_numbers

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
    from knitlab_core.knits.specimen import Specimen


def clasp_numbers(specimen: Specimen, nodes: FloatArray) -> IndexArray:
    """Return how often the yarn on both sides of every held loop's apex goes through the head that holds it.

    Parameters
    ----------
    specimen : Specimen
        Says which node belongs to which loop.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit; of a bundle the first fibre counts. With fewer than 24
        nodes per loop the polygon of the nodes cuts corners and may miss clasps.

    Returns
    -------
    IndexArray
        Planar: (rows - 1, loops, 2), of row k's head j and row k + 1's loop j, left and right of its apex. Others:
        (n, 2), those of rows and then those of layers, or of edges, of `joined_clasps`. In both all are 1 in size and
        left and right differ in sign; they stay so at any strain until a loop slips out of its head, or the yarn's end
        does. (0, 2) of a fabric that does not know its loops.
    """
    numbers = list(joined_clasps(specimen, nodes).values())
    if len(numbers) == 1:
        return numbers[0]
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *(one.reshape(-1, 2) for one in numbers)])


def joined_clasps(specimen: Specimen, nodes: FloatArray) -> Mapping[str, IndexArray]:
    """Return the clasp numbers by what is joined, ``rows`` or ``layers``.

    Parameters
    ----------
    specimen : Specimen
        Any.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    Mapping of str to IndexArray
        Each (..., 2), left and right of the held loop's apex; the shape before is that of the fabric's `clasps`.
    """
    return {joined: _numbers(nodes, places) for joined, places in clasp_nodes(specimen).items()}


def clasps_held(nodes: FloatArray, clasps: Mapping[str, ClaspNodes]) -> dict[str, int]:
    """Return how many clasps hold, by what is joined: the yarn goes up through the head on one side and down again.

    Parameters
    ----------
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.
    clasps : Mapping of str to ClaspNodes
        Where the clasps are, as `clasp_nodes` says it.
    """
    return {joined: int(np.sum(hold)) for joined, hold in clasps_hold(nodes, clasps).items()}


def clasps_hold(nodes: FloatArray, clasps: Mapping[str, ClaspNodes]) -> dict[str, BoolArray]:
    """Return which clasps hold, by what is joined; shapes are those of the fabric's `clasps`.

    Parameters
    ----------
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.
    clasps : Mapping of str to ClaspNodes
        Where the clasps are, as `clasp_nodes` says it.
    """
    found = {}
    for joined, places in clasps.items():
        left, right = np.moveaxis(_numbers(nodes, places), -1, 0)
        found[joined] = (np.abs(left) == 1) & (right == -left)
    return found


EDGES: Final[Mapping[str, str]] = MappingProxyType({"bound_off": "bound-off", "cast_on": "cast-on"})
"""Chained edges in words, by what their clasps are called."""


def clasp_kind(joined: str) -> str:
    """Return which clasps join what is joined, in words.

    Examples
    --------
    >>> clasp_kind("rows"), clasp_kind("bound_off")
    ('between rows', 'of the bound-off edge')
    """
    return f"of the {EDGES[joined]} edge" if joined in EDGES else f"between {joined}"


def clasp_place(joined: str, index: tuple[int, ...]) -> str:
    """Return the place of a clasp in words, from its index in the fabric's `clasps` of what is joined.

    Examples
    --------
    >>> clasp_place("rows", (0, 2)), clasp_place("rows", (1, 0, 2)), clasp_place("layers", (0, 1, 2))
    ('rows 0 and 1 at loop 2', 'rows 0 and 1 at stitch 2 of layer 1', 'layers 0 and 1 at stitch 2 of row 1')
    """
    if joined in EDGES:
        return f"clasp {index[0]} of the {EDGES[joined]} edge"
    if joined == "layers":
        layer, row, stitch = index
        return f"layers {layer} and {layer + 1} at stitch {stitch} of row {row}"
    *layers, row, loop = index
    where = f"stitch {loop} of layer {layers[0]}" if layers else f"loop {loop}"
    return f"rows {row} and {row + 1} at {where}"


def parted_at(hold: Mapping[str, BoolArray]) -> str:
    """Return in words which neighbouring rows or layers no clasp holds together; empty where all are held.

    A chained edge that lets go parts nothing by itself.

    Parameters
    ----------
    hold : Mapping of str to BoolArray
        Which clasps hold, as `clasps_hold` gives it.
    """
    for joined, held in hold.items():
        if joined in EDGES:
            continue
        pairs = held.ndim - 2 if joined == "rows" else 0
        others = tuple(axis for axis in range(held.ndim) if axis != pairs)
        loose = np.flatnonzero(~held.any(axis=others))
        if len(loose):
            return f"{joined} {loose[0]} and {loose[0] + 1}"
    return ""


def clasp_counts(specimen: Specimen) -> dict[str, int]:
    """Return how many clasps a printed knit has, by what is joined; those of a periodic cell are not counted."""
    if specimen.cell is not None:
        return {}
    clasps = specimen.fabric.clasps(specimen.centreline, specimen.counts)
    return {joined: prod(one.heads.shape[:-1]) for joined, one in clasps.items()}


class ClaspNodes(NamedTuple):
    """Hold which nodes are the heads of clasps, and the yarn that goes through them on both sides of its apex.

    Shorter stretches than others repeat their last node.
    """

    left: IndexArray
    """(..., n), a head from its first foot to its middle."""
    right: IndexArray
    """(..., n), a head from its last foot to its middle."""
    held: IndexArray
    """(..., 2, m), the held loop's yarn left and right of its apex."""


def clasp_nodes(specimen: Specimen) -> Mapping[str, ClaspNodes]:
    """Return the nodes of every clasp by what is joined, ``rows`` or ``layers``; none of a cell."""
    found: dict[str, ClaspNodes] = {}
    if specimen.cell is not None:
        return found
    for joined, clasps in specimen.fabric.clasps(specimen.centreline, specimen.counts).items():
        first, last = _nodes_between(specimen, *np.moveaxis(clasps.heads, -1, 0))
        half = np.abs(last - first) // 2
        sides = _nodes_between(specimen, clasps.held[..., :-1], clasps.held[..., 1:])
        found[joined] = ClaspNodes(
            left=_run(first, first + half * np.sign(last - first)),
            right=_run(last, last - half * np.sign(last - first)),
            held=_run(*sides),
        )
    return found


def _numbers(nodes: FloatArray, clasps: ClaspNodes) -> IndexArray:
    """Return the crossing number of every head and yarn (..., 2)."""
    left, right = nodes[clasps.left][..., None, :, :], nodes[clasps.right][..., None, :, :]
    return crossing_numbers(left, right, nodes[clasps.held])


def _nodes_between(specimen: Specimen, first: FloatArray, last: FloatArray) -> tuple[IndexArray, IndexArray]:
    """Return first and last nodes of the yarn between arc lengths [loop widths], the one next to its greater end in."""
    ends = np.sort(np.stack([first, last]), axis=0) * specimen.loop_width
    low, high = np.searchsorted(specimen.arc_lengths, ends)
    high = np.minimum(high, len(specimen.arc_lengths) - 1)
    return np.where(first < last, low, high), np.where(first < last, high, low)


def _run(first: IndexArray, last: IndexArray) -> IndexArray:
    """Return the numbers from one to another (..., n), both included; shorter runs than others repeat their last."""
    step = np.arange(1 + np.max(np.abs(last - first), initial=0))
    most = np.abs(last - first)[..., None]
    numbers: IndexArray = first[..., None] + np.sign(last - first)[..., None] * np.minimum(step, most)
    return numbers

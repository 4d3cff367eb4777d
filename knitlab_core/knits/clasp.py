"""Tell whether a knit is knitted: whether its loops hold each other.

Whole rows have linking number 0 even in true stockinette. So single loops are taken: a head is closed far
below, the sinker of the next row beside it far above, and the Gauss linking number of the two is +1 or -1
exactly if the one holds the other. In a volumetric knit "above" is where the head points: along +y or -y for
wale loops, along +z for pile loops; half a loop down to its foot is what its neighbour's head holds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.knits.linking import linking_number
from knitlab_core.knits.pieces import Row
from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch, widest_parameter
from knitlab_core.knits.stockinette import arc_length_at
from knitlab_core.knits.volumetric import numbered_row, row_number
from knitlab_core.knits.volumetric_row import wale_sign
from knitlab_core.knits.volumetric_stitch import VolumetricStitch

if TYPE_CHECKING:
    from knitlab_core.knits.specimen import Specimen

_FAR: Final = 10.0
_SAMPLES: Final = 65
_WALE: Final = np.array([0.0, 1.0, 0.0])
_PILE: Final = np.array([0.0, 0.0, 1.0])


def clasp_number(head: FloatArray, sinker: FloatArray, above: FloatArray = _WALE) -> int:
    """Return the linking number of a head, closed far below, and a sinker, closed far above.

    Parameters
    ----------
    head, sinker : FloatArray
        Open polygons (n, 3) and (m, 3) along x, any unit.
    above : FloatArray
        Unit vector (3,) along which the head points: the wale unless said otherwise.

    Returns
    -------
    int
        +1 or -1 if they hold each other, 0 if not.
    """
    both = np.concatenate([head, sinker])
    far = _FAR * float(np.ptp(both, axis=0).max()) * above
    return round(linking_number(_closed(head, -far), _closed(sinker, far)))


def stitch_clasp(stitch: Stitch) -> int:
    """Return the clasp number of a head and the next row's sinker on its right, from Eq. 1 itself.

    Every other clasp of a planar stockinette is this one moved or mirrored; and so is every clasp of wale loops or of
    pile loops in a volumetric knit, with the planar stitch that they are loops of.
    """
    head_span, _, right_span = _spans(stitch, 0, 2)
    rows = [Row(stitch=stitch, row=row, loops=2) for row in (0, 1)]
    head, sinker = (
        row.position(row.arc_length(np.linspace(*span, _SAMPLES)))
        for row, span in zip(rows, (head_span, right_span), strict=True)
    )
    return clasp_number(head, sinker)


def clasp_numbers(specimen: Specimen, nodes: FloatArray) -> IntArray:
    """Return the clasp number of every head with the sinkers on its two sides.

    Parameters
    ----------
    specimen : Specimen
        Says which node belongs to which loop.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit; with fewer than 24 nodes per loop the polygon of the
        nodes cuts corners and may miss clasps.

    Returns
    -------
    IntArray
        Planar: (rows - 1, loops, 2), of row k's head j and row k + 1's sinker at its left, at its right. Volumetric:
        (n, 2), the rows of `wale_clasps` and then those of `pile_clasps`. In both all are 1 in size and left and
        right differ in sign; they cannot change while strands do not cross.
    """
    if isinstance(specimen.stitch, VolumetricStitch):
        both = (wale_clasps(specimen, specimen.stitch, nodes), pile_clasps(specimen, specimen.stitch, nodes))
        return np.concatenate([numbers.reshape(-1, 2) for numbers in both])
    if not isinstance(specimen.stitch, Stitch):
        return np.zeros((0, 2), dtype=np.int64)
    numbers = np.zeros((specimen.rows - 1, specimen.loops, 2), dtype=np.int64)
    for row, loop, side in np.ndindex(numbers.shape):
        head_span, *sinker_spans = _spans(specimen.stitch, loop, specimen.loops)
        head = nodes[_node_range(specimen, specimen.stitch, row, head_span)]
        sinker = nodes[_node_range(specimen, specimen.stitch, row + 1, sinker_spans[side])]
        numbers[row, loop, side] = clasp_number(head, sinker)
    return numbers


def wale_clasps(specimen: Specimen, stitch: VolumetricStitch, nodes: FloatArray) -> IntArray:
    """Return the clasp number of every wale head with the wale loop of the row that is knitted through it.

    Parameters
    ----------
    specimen : Specimen
        A volumetric one.
    stitch : VolumetricStitch
        Its stitch.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    IntArray
        (layers, rows - 1, loops, 2): between rows k and k + 1 of a layer, with the left and the right half of the
        held loop. The head is row k's where wale loops point along +y, row k + 1's where along -y.
    """
    numbers = np.zeros((specimen.layers, specimen.rows - 1, specimen.loops, 2), dtype=np.int64)
    spans = _spans(stitch.wale_loop, 0, 1)
    for layer, row in np.ndindex(numbers.shape[:2]):
        sign = wale_sign(layer)
        holding, held = (row, row + 1) if sign > 0 else (row + 1, row)
        heads, *halves = (
            _loop_nodes(specimen, stitch, (of_row, layer), span, pile=False)
            for of_row, span in zip((holding, held, held), spans, strict=True)
        )
        numbers[layer, row] = [
            [clasp_number(nodes[heads[loop]], nodes[half[loop]], sign * _WALE) for half in halves]
            for loop in range(specimen.loops)
        ]
    return numbers


def pile_clasps(specimen: Specimen, stitch: VolumetricStitch, nodes: FloatArray) -> IntArray:
    """Return the clasp number of every pile head with the pile loop of the layer above.

    Parameters
    ----------
    specimen : Specimen
        A volumetric one.
    stitch : VolumetricStitch
        Its stitch.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    IntArray
        (layers - 1, rows, loops, 2): of layer m's head with the left and the right half of layer m + 1's loop.
    """
    numbers = np.zeros((specimen.layers - 1, specimen.rows, specimen.loops, 2), dtype=np.int64)
    spans = _spans(stitch.pile_loop, 0, 1)
    for layer, row in np.ndindex(numbers.shape[:2]):
        heads, *halves = (
            _loop_nodes(specimen, stitch, (row, of_layer), span, pile=True)
            for of_layer, span in zip((layer, layer + 1, layer + 1), spans, strict=True)
        )
        numbers[layer, row] = [
            [clasp_number(nodes[heads[loop]], nodes[half[loop]], _PILE) for half in halves]
            for loop in range(specimen.loops)
        ]
    return numbers


def _spans(stitch: Stitch, loop: int, loops: int) -> tuple[tuple[float, float], ...]:
    """Return the parameter spans of a head, of the sinker on its left and of the one on its right.

    Each is cut where its neck is narrowest, or at the row's end (of a single loop: at its feet); from there a
    straight way out meets nothing.
    """
    widest, apex = widest_parameter(stitch), 2.0 * np.pi * loop
    neck = np.pi - widest
    start, end = -np.pi, (2.0 * loops - 1.0) * np.pi
    left = (max(apex - np.pi - neck, start), apex - widest)
    right = (apex + widest, min(apex + np.pi + neck, end))
    return (apex - neck, apex + neck), left, right


def _node_range(specimen: Specimen, stitch: Stitch, row: int, span: tuple[float, float]) -> IntArray:
    """Return the nodes of a span of a row, in the order of growing t on every row."""
    arcs = arc_length_at(stitch, specimen.loops, row, np.array(span)) * specimen.loop_width
    low, high = np.searchsorted(specimen.arc_lengths, np.sort(arcs))
    return np.arange(low, high) if row % 2 == 0 else np.arange(low, high)[::-1]


def _loop_nodes(
    specimen: Specimen, stitch: VolumetricStitch, at: tuple[int, int], span: tuple[float, float], *, pile: bool
) -> list[IntArray]:
    """Return the nodes of a span of each loop of a row and layer, in the order of growing t."""
    row, layer = at
    number = row_number(row, layer, specimen.rows)
    piece = numbered_row(stitch, number, specimen.rows, specimen.loops)
    loops = np.arange(specimen.loops)
    ends = [piece.arc_length(loops, pile=pile, t=np.full(loops.size, t)) for t in span]
    arcs = (specimen.centreline.starts[2 * number] + np.sort(ends, axis=0)) * specimen.loop_width
    low, high = np.searchsorted(specimen.arc_lengths, arcs)
    return [np.arange(first, last)[:: piece.direction] for first, last in zip(low, high, strict=True)]


def _closed(arc: FloatArray, far: FloatArray) -> FloatArray:
    return np.concatenate([arc, [arc[-1] + far, arc[0] + far]])

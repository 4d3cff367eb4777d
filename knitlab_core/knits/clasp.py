"""Tell whether a knit is knitted: whether its loops hold each other.

A head holds a loop if the yarn of that loop goes through it: up between the head's legs on one side of its apex and
down again on the other. So single loops are taken, from foot to foot, and the yarn of the loop that is held on either
side of its apex, as far as the next apex; and it is counted how often this yarn passes through the surface between
the head's legs. No curve is closed through the knit, which would cross other strands once the knit is drawn out.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.knits.crossing import crossing_number
from knitlab_core.knits.pieces import Row
from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch
from knitlab_core.knits.volumetric import row_number
from knitlab_core.knits.volumetric_row import VolumetricRow, wale_sign
from knitlab_core.knits.volumetric_stitch import VolumetricStitch

if TYPE_CHECKING:
    from knitlab_core.knits.specimen import Specimen

_SAMPLES: Final = 65


class _Loops(NamedTuple):
    """Where the loops of a row are on the yarn: arc lengths [loop widths] in the order of growing t on every row."""

    feet: FloatArray
    """(n + 1,) where loops begin and end."""
    apices: FloatArray
    """(n + 2,) of the loops; the first and the last are the middles of the turn-arounds, or the yarn's ends."""


def stitch_clasp(stitch: Stitch) -> int:
    """Return the clasp number of a head and the next row's yarn on the right of its apex, from Eq. 1 itself.

    Every other clasp of a planar stockinette is this one moved or mirrored; and so is every clasp of wale loops or of
    pile loops in a volumetric knit, with the planar stitch that they are loops of.
    """
    rows = [Row(stitch=stitch, row=row, loops=2) for row in (0, 1)]
    head, held = (
        row.position(row.arc_length(np.linspace(*span, _SAMPLES)))
        for row, span in zip(rows, ((-np.pi, np.pi), (0.0, 2.0 * np.pi)), strict=True)
    )
    return crossing_number(head, held)


def clasp_numbers(specimen: Specimen, nodes: FloatArray) -> IntArray:
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
    IntArray
        Planar: (rows - 1, loops, 2), of row k's head j and row k + 1's loop j, left and right of its apex. Volumetric:
        (n, 2), the rows of `wale_clasps` and then those of `pile_clasps`. In both all are 1 in size and left and
        right differ in sign; they stay so at any strain until a loop slips out of its head, or the yarn's end does.
    """
    if isinstance(specimen.stitch, VolumetricStitch):
        both = (wale_clasps(specimen, nodes), pile_clasps(specimen, nodes))
        return np.concatenate([numbers.reshape(-1, 2) for numbers in both])
    if not isinstance(specimen.stitch, Stitch):
        return np.zeros((0, 2), dtype=np.int64)
    numbers = np.zeros((specimen.rows - 1, specimen.loops, 2), dtype=np.int64)
    for row, loop in np.ndindex(numbers.shape[:2]):
        numbers[row, loop] = _clasp(specimen, nodes, (row, row + 1), loop)
    return numbers


def wale_clasps(specimen: Specimen, nodes: FloatArray) -> IntArray:
    """Return the clasp numbers of every wale head with the wale loop of the row that is knitted through it.

    Parameters
    ----------
    specimen : Specimen
        A volumetric one.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    IntArray
        (layers, rows - 1, loops, 2): between rows k and k + 1 of a layer, left and right of the held loop's apex. The
        head is row k's where wale loops point along +y, row k + 1's where along -y.
    """
    numbers = np.zeros((specimen.layers, specimen.rows - 1, specimen.loops, 2), dtype=np.int64)
    for layer, row, stitch in np.ndindex(numbers.shape[:3]):
        pair = (row, row + 1) if wale_sign(layer) > 0 else (row + 1, row)
        holding, held = (row_number(of_row, layer, specimen.rows) for of_row in pair)
        numbers[layer, row, stitch] = _clasp(specimen, nodes, (holding, held), 2 * stitch)
    return numbers


def pile_clasps(specimen: Specimen, nodes: FloatArray) -> IntArray:
    """Return the clasp numbers of every pile head with the pile loop of the layer above.

    Parameters
    ----------
    specimen : Specimen
        A volumetric one.
    nodes : FloatArray
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    IntArray
        (layers - 1, rows, loops, 2): of layer m's head with layer m + 1's loop, left and right of its apex.
    """
    numbers = np.zeros((specimen.layers - 1, specimen.rows, specimen.loops, 2), dtype=np.int64)
    for layer, row, stitch in np.ndindex(numbers.shape[:3]):
        holding, held = (row_number(row, of_layer, specimen.rows) for of_layer in (layer, layer + 1))
        numbers[layer, row, stitch] = _clasp(specimen, nodes, (holding, held), 2 * stitch + 1)
    return numbers


def _clasp(specimen: Specimen, nodes: FloatArray, numbers: tuple[int, int], loop: int) -> list[int]:
    """Return the two clasp numbers of a loop of two rows, the holding and the held one, counted along the yarn."""
    holding, held = (_loops(specimen, number) for number in numbers)
    head = nodes[_nodes_between(specimen, holding.feet[loop], holding.feet[loop + 1])]
    around = held.apices[loop : loop + 3]
    return [crossing_number(head, nodes[_nodes_between(specimen, *ends)]) for ends in pairwise(around)]


def _loops(specimen: Specimen, number: int) -> _Loops:
    """Return where the loops of a row are, counted along the yarn."""
    line = specimen.centreline
    piece, start = line.pieces[2 * number], line.starts[2 * number]
    if isinstance(piece, VolumetricRow):
        stitch = np.arange(piece.loops)
        begin, apex, end = (
            np.stack([piece.arc_length(stitch, pile=pile, t=np.full(stitch.size, t)) for pile in (False, True)], axis=1)
            for t in (-np.pi, 0.0, np.pi)
        )
        feet, apices = np.append(begin.ravel(), end[-1, -1]), apex.ravel()
    elif isinstance(piece, Row):
        half_turns = np.pi * np.arange(-1.0, 2.0 * piece.loops)
        feet, apices = piece.arc_length(half_turns[::2]), piece.arc_length(half_turns[1::2])
    else:
        raise TypeError(piece)
    before, after = max(2 * number - 1, 0), min(2 * number + 2, len(line.pieces))
    ends = 0.5 * np.array([line.starts[before] + start, line.starts[2 * number + 1] + line.starts[after]])
    ends = ends[:: piece.direction]
    return _Loops(feet=start + feet, apices=np.concatenate([ends[:1], start + apices, ends[1:]]))


def _nodes_between(specimen: Specimen, first: float, last: float) -> IntArray:
    """Return the nodes from one arc length [loop widths] to another, the one next to its greater end included."""
    low, high = np.searchsorted(specimen.arc_lengths, np.sort([first, last]) * specimen.loop_width)
    nodes: IntArray = np.arange(low, min(high + 1, len(specimen.arc_lengths)))
    return nodes if first < last else nodes[::-1]

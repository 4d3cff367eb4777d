"""Return whether a knit is knitted: whether its loops hold each other.

A head holds a loop if the yarn of that loop goes through it: up between the head's legs on one side of its apex and
down again on the other. So single loops are taken, from foot to foot, and the yarn of the loop that is held on either
side of its apex, as far as the next apex; and it is counted how often this yarn passes through the surface between
the head's legs. No curve is closed through the knit, which would cross other strands once the knit is drawn out.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.knits.crossing import crossing_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray, IndexArray
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
        Planar: (rows - 1, loops, 2), of row k's head j and row k + 1's loop j, left and right of its apex. Volumetric:
        (n, 2), those of rows and then those of layers of `joined_clasps`. In both all are 1 in size and left and right
        differ in sign; they stay so at any strain until a loop slips out of its head, or the yarn's end does. (0, 2)
        of a fabric that does not know its loops.
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
    found = {}
    for joined, clasps in specimen.fabric.clasps(specimen.centreline, specimen.counts).items():
        numbers = np.zeros((*clasps.heads.shape[:-1], 2), dtype=np.int64)
        for place in np.ndindex(numbers.shape[:-1]):
            head = nodes[_nodes_between(specimen, *clasps.heads[place])]
            sides = pairwise(clasps.held[place])
            numbers[place] = [crossing_number(head, nodes[_nodes_between(specimen, *ends)]) for ends in sides]
        found[joined] = numbers
    return found


def _nodes_between(specimen: Specimen, first: float, last: float) -> IndexArray:
    """Return the nodes from one arc length [loop widths] to another, the one next to its greater end included."""
    low, high = np.searchsorted(specimen.arc_lengths, np.sort([first, last]) * specimen.loop_width)
    nodes: IndexArray = np.arange(low, min(high + 1, len(specimen.arc_lengths)))
    return nodes if first < last else nodes[::-1]

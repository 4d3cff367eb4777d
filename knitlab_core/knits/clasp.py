"""Tell whether a knit is knitted: whether its loops hold each other.

Whole rows have linking number 0 even in true stockinette. So single loops are taken: a head is closed far
below, the sinker of the next row beside it far above, and the Gauss linking number of the two is +1 or -1
exactly if the one holds the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.knits.pieces import Row
from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch, widest_parameter
from knitlab_core.knits.stockinette import arc_length_at

if TYPE_CHECKING:
    from knitlab_core.knits.specimen import Specimen

_FAR: Final = 10.0
_SAMPLES: Final = 65


def linking_number(first: FloatArray, second: FloatArray) -> float:
    """Return the Gauss linking number of two closed polygons, to rounding.

    ``Lk = 1/4pi sum_ij Omega_ij``, Omega_ij the solid angle of the parallelogram that the differences of edge
    i and edge j span, in two triangles by Van Oosterom and Strackee's formula.

    Parameters
    ----------
    first, second : FloatArray
        Corners (n, 3) and (m, 3), any unit; the last joins the first. The polygons must not touch.

    Returns
    -------
    float
        A whole number but for rounding [1].

    References
    ----------
    Klenin and Langowski, "Computation of writhe in modeling of supercoiled DNA", Biopolymers 54 (2000);
    Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    p, q = first[:, None], second[None, :]
    p_next, q_next = np.roll(first, -1, axis=0)[:, None], np.roll(second, -1, axis=0)[None, :]
    a, b, c, d = q - p, q - p_next, q_next - p_next, q_next - p
    solid_angles = _half_solid_angle(a, b, c) + _half_solid_angle(a, c, d)
    return float(np.sum(solid_angles)) / (2.0 * np.pi)


def clasp_number(head: FloatArray, sinker: FloatArray) -> int:
    """Return the linking number of a head, closed far below, and a sinker, closed far above.

    Parameters
    ----------
    head, sinker : FloatArray
        Open polygons (n, 3) and (m, 3) along x with the wale along y, any unit.

    Returns
    -------
    int
        +1 or -1 if they hold each other, 0 if not.
    """
    both = np.concatenate([head, sinker])
    far = np.array([0.0, _FAR * float(np.ptp(both, axis=0).max()), 0.0])
    below, above = _closed(head, -far), _closed(sinker, far)
    return round(linking_number(below, above))


def stitch_clasp(stitch: Stitch) -> int:
    """Return the clasp number of a head and the next row's sinker on its right, from Eq. 1 itself.

    Every other clasp of a planar stockinette is this one moved or mirrored.
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
        Node positions (N, 3), as built or deformed, any unit.

    Returns
    -------
    IntArray
        (rows - 1, loops, 2): of row k's head j and row k + 1's sinker at its left, at its right. In stockinette
        all are 1 in size and left and right differ in sign; they cannot change while strands do not cross.
    """
    numbers = np.zeros((specimen.rows - 1, specimen.loops, 2), dtype=np.int64)
    for row, loop, side in np.ndindex(numbers.shape):
        head_span, *sinker_spans = _spans(specimen.stitch, loop, specimen.loops)
        head = nodes[_node_range(specimen, row, head_span)]
        sinker = nodes[_node_range(specimen, row + 1, sinker_spans[side])]
        numbers[row, loop, side] = clasp_number(head, sinker)
    return numbers


def _spans(stitch: Stitch, loop: int, loops: int) -> tuple[tuple[float, float], ...]:
    """Return the parameter spans of a head, of the sinker on its left and of the one on its right.

    Each is cut where its neck is narrowest; from there a straight way out meets nothing.
    """
    widest, apex = widest_parameter(stitch), 2.0 * np.pi * loop
    neck = np.pi - widest
    start, end = -np.pi, (2.0 * loops - 1.0) * np.pi
    left = (max(apex - np.pi - neck, start), apex - widest)
    right = (apex + widest, min(apex + np.pi + neck, end))
    return (apex - neck, apex + neck), left, right


def _node_range(specimen: Specimen, row: int, span: tuple[float, float]) -> IntArray:
    """Return the nodes of a span of a row, in the order of growing t on every row."""
    arcs = arc_length_at(specimen.stitch, specimen.loops, row, np.array(span)) * specimen.loop_width
    low, high = np.searchsorted(specimen.arc_lengths, np.sort(arcs))
    return np.arange(low, high) if row % 2 == 0 else np.arange(low, high)[::-1]


def _closed(arc: FloatArray, far: FloatArray) -> FloatArray:
    return np.concatenate([arc, [arc[-1] + far, arc[0] + far]])


def _half_solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    size_a, size_b, size_c = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    triple = np.sum(a * np.cross(b, c), axis=-1)
    projections = np.sum(a * b, axis=-1) * size_c + np.sum(b * c, axis=-1) * size_a + np.sum(c * a, axis=-1) * size_b
    angle: FloatArray = np.arctan2(triple, size_a * size_b * size_c + projections)
    return angle

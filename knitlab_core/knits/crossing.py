"""Count how often a curve passes through the surface that a loop spans."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from knitlab_core.arrays import BoolArray, FloatArray


def crossing_number(loop: FloatArray, curve: FloatArray) -> int:
    """Return how often a curve passes through the ladder between the two halves of a loop, signed by its direction.

    The ladder has a rung from each corner of the loop to the one as far from the loop's other end, and two triangles
    between rungs. It is between the loop's legs whatever way they are bent, turned or drawn out, so the number
    changes only where the curve passes the loop itself, leaves past the last rung, or has an end drawn through.

    Parameters
    ----------
    loop, curve : FloatArray
        Corners (n, 3) and (m, 3) of open polygons, any unit.

    Returns
    -------
    int
        +1 for each passage along the normal that the loop's direction turns about right-handedly, -1 for each against.
    """
    # In a loop of an odd number of corners both sides end at the middle one, and the last triangle is empty.
    half = (len(loop) + 1) // 2
    left, right = loop[:half], loop[::-1][:half]
    start, end = curve[:-1], curve[1:]
    # Each edge of the ladder is looked at once: a segment through it is in one of its two triangles, never in both.
    rung = _passes(start, end, left, right)
    diagonal = _passes(start, end, left[1:], right[:-1])
    up, down = _passes(start, end, left[:-1], left[1:]), _passes(start, end, right[1:], right[:-1])
    first = _inside(up, diagonal, ~rung[:, :-1]), (left[:-1], left[1:], right[:-1])
    second = _inside(rung[:, 1:], down, ~diagonal), (left[1:], right[1:], right[:-1])
    total = 0
    for inside, (a, b, c) in (first, second):
        normal = np.cross(b - a, c - a)
        behind, before = (np.sum((point[:, None] - a) * normal, axis=-1) >= 0.0 for point in (start, end))
        total += int(np.sum(inside & before & ~behind)) - int(np.sum(inside & behind & ~before))
    return total


def _passes(start: FloatArray, end: FloatArray, a: FloatArray, b: FloatArray) -> BoolArray:
    """Return on which side segments (m, 3) pass edges (n, 3) from a to b, (m, n): the sign of a tetrahedron."""
    volume = np.sum((end - start)[:, None] * np.cross(a - start[:, None], b - start[:, None]), axis=-1)
    passes: BoolArray = volume >= 0.0
    return passes


def _inside(first: BoolArray, second: BoolArray, third: BoolArray) -> BoolArray:
    """Return which lines of segments go through triangles: they pass all three edges on the same side."""
    inside: BoolArray = (first == second) & (second == third)
    return inside

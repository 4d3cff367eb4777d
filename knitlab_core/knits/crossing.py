"""Count how often a curve passes through the surface that a loop spans."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from knitlab_core.arrays import BoolArray, FloatArray, IndexArray


def crossing_number(loop: FloatArray, curve: FloatArray) -> int:
    """Return how often a curve passes through the ladder between the two halves of a loop, signed by its direction.

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
    return int(crossing_numbers(loop[None, :half], loop[None, ::-1][:, :half], curve[None])[0])


def crossing_numbers(left: FloatArray, right: FloatArray, curve: FloatArray) -> IndexArray:
    """Return how often curves pass through the ladders between the two halves of loops, signed by their directions.

    A ladder has a rung from each corner of the loop to the one as far from the loop's other end, and two triangles
    between rungs. It lies between the loop's legs whatever way they are bent, turned or drawn out, so the number
    changes only where the curve passes the loop itself, leaves past the last rung, or has an end drawn through.

    Parameters
    ----------
    left, right : FloatArray
        Ends of the rungs (k, ..., n, 3), from the loop's first and last corner to its middle, any unit; the last rung
        may be given several times.
    curve : FloatArray
        Corners (k, ..., m, 3) of open polygons; the last may be given several times.

    Returns
    -------
    IndexArray
        Numbers (k, ...).
    """
    # Lines are compared by moments about a point of the loop, so that no digits are lost far from the origin.
    centre = left[..., :1, :]
    left, right, curve = left - centre, right - centre, curve - centre
    start, end = curve[..., :-1, :], curve[..., 1:, :]
    line = np.concatenate([np.cross(start, end), end - start], axis=-1)
    # Each edge of the ladder is looked at once: a segment through it is in one of its two triangles, never in both.
    rung = _passes(line, left, right)
    first, last = left[..., :-1, :], left[..., 1:, :]
    low, high = right[..., :-1, :], right[..., 1:, :]
    diagonal, up, down = _passes(line, last, low), _passes(line, first, last), _passes(line, high, low)
    lower = (up == diagonal) & (diagonal != rung[..., :-1])
    upper = (down == rung[..., 1:]) & (down != diagonal)
    return _through(start, end, lower, (first, last, low)) + _through(start, end, upper, (last, high, low))


def _passes(line: FloatArray, a: FloatArray, b: FloatArray) -> BoolArray:
    """Tell on which side lines (..., m, 6), moment and direction, pass edges (..., n, 3) from a to b: (..., m, n)."""
    edge = np.concatenate([b - a, np.cross(a, b)], axis=-1)
    passes: BoolArray = line @ np.swapaxes(edge, -1, -2) >= 0.0
    return passes


def _through(
    start: FloatArray, end: FloatArray, inside: BoolArray, triangle: tuple[FloatArray, FloatArray, FloatArray]
) -> IndexArray:
    """Return how often segments (..., m, 3) go through triangles (..., n, 3) whose edges their lines pass inside."""
    *which, segment, step = np.nonzero(inside)
    begin, finish = start[(*which, segment)], end[(*which, segment)]
    shape = (*inside.shape[:-2], inside.shape[-1], 3)
    a, b, c = (np.broadcast_to(corner, shape)[(*which, step)] for corner in triangle)
    normal = np.cross(b - a, c - a)
    behind, before = (np.sum((point - a) * normal, axis=-1) >= 0.0 for point in (begin, finish))
    numbers = np.zeros(inside.shape[:-2], dtype=np.int64)
    np.add.at(numbers, tuple(which), before.astype(np.int64) - behind)
    return numbers

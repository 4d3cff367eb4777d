"""Find what the beam hits at every pixel, and how open the sky is above it.

Kernels on pictures of the height [pixel] of what is seen; where nothing is, it is `NOTHING`. Columns count from the
left edge, rows from the upper one, both in pixels, and the middle of the first pixel is at 0.5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.jit import kernel

if TYPE_CHECKING:
    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray

NOTHING: Final = -1e9


@kernel
def draw_tube(
    points: FloatArray,
    tangents: FloatArray,
    joined: npt.NDArray[np.bool_],
    radius: float,
    height: npt.NDArray[np.float32],
    facing: npt.NDArray[np.float32],
) -> None:
    """Draw a round tube along points where it is the highest so far.

    Parameters
    ----------
    points, tangents : FloatArray, shape (n, 3)
        Column, row and height [pixel], and unit vectors along the tube there.
    joined : array of bool, shape (n - 1,)
        Where a point and the next are of one piece.
    radius : float
        Of the tube [pixel].
    height, facing : array of float32, shape (rows, columns)
        Height of what is seen [pixel], and the cosine between its surface's normal and the beam; changed in place.
    """
    rows, columns = height.shape
    for k in range(len(points) - 1):
        if not joined[k]:
            continue
        ax, ay, az = points[k, 0], points[k, 1], points[k, 2]
        ux, uy, uz = points[k + 1, 0] - ax, points[k + 1, 1] - ay, points[k + 1, 2] - az
        length = np.sqrt(ux * ux + uy * uy + uz * uz)
        if length == 0.0:
            continue
        ux, uy, uz = ux / length, uy / length, uz / length
        along = max(1.0 - uz * uz, 1e-12)
        left = max(0, int(np.ceil(min(ax, points[k + 1, 0]) - radius - 0.5)))
        right = min(columns - 1, int(np.floor(max(ax, points[k + 1, 0]) + radius - 0.5)))
        top = max(0, int(np.ceil(min(ay, points[k + 1, 1]) - radius - 0.5)))
        bottom = min(rows - 1, int(np.floor(max(ay, points[k + 1, 1]) + radius - 0.5)))
        for i in range(top, bottom + 1):
            dy = i + 0.5 - ay
            for j in range(left, right + 1):
                dx = j + 0.5 - ax
                g = dx * ux + dy * uy
                inside = g * g * uz * uz - along * (dx * dx + dy * dy - g * g - radius * radius)
                if inside < 0.0:
                    continue
                # Where the ray leaves the cylinder; beyond its ends, the ball there.
                s = (g * uz + np.sqrt(inside)) / along
                t = g + uz * s
                if t < 0.0 or t > length:
                    t = 0.0 if t < 0.0 else length
                    bx, by = dx - t * ux, dy - t * uy
                    ball = radius * radius - bx * bx - by * by
                    if ball < 0.0:
                        continue
                    s = t * uz + np.sqrt(ball)
                z = az + s
                if z <= height[i, j]:
                    continue
                height[i, j] = z
                # The tangent runs on evenly between points, so that pieces do not show.
                share = t / length
                tx = (1.0 - share) * tangents[k, 0] + share * tangents[k + 1, 0]
                ty = (1.0 - share) * tangents[k, 1] + share * tangents[k + 1, 1]
                tz = (1.0 - share) * tangents[k, 2] + share * tangents[k + 1, 2]
                nx, ny, nz = dx - t * ux, dy - t * uy, s - t * uz
                off = (nx * tx + ny * ty + nz * tz) / (tx * tx + ty * ty + tz * tz)
                nx, ny, nz = nx - off * tx, ny - off * ty, nz - off * tz
                facing[i, j] = max(0.0, nz / np.sqrt(nx * nx + ny * ny + nz * nz))


@kernel
def draw_block(
    origin: FloatArray,
    steps: FloatArray,
    low: FloatArray,
    high: FloatArray,
    window: IntArray,
    height: npt.NDArray[np.float32],
    facing: npt.NDArray[np.float32],
    hit: npt.NDArray[np.bool_],
) -> None:
    """Draw a block with faces along course, wale and pile where it is the highest so far.

    Parameters
    ----------
    origin : FloatArray, shape (3,)
        Place of column 0, row 0 and height 0 [m].
    steps : FloatArray, shape (3, 3)
        What one column, one row and one unit of height are there [m].
    low, high : FloatArray, shape (3,)
        Corners of the block [m].
    window : IntArray, shape (4,)
        First and last row, and column, in which it can be seen; last ones not included.
    height, facing : array of float32, shape (rows, columns)
        As in `draw_tube`.
    hit : array of bool, shape (rows, columns)
        Set where the block is seen.
    """
    pixel = np.sqrt(steps[2, 0] ** 2 + steps[2, 1] ** 2 + steps[2, 2] ** 2)
    for i in range(window[0], window[1]):
        for j in range(window[2], window[3]):
            lower, upper, seen = -1e30, 1e30, 0
            for c in range(3):
                at = origin[c] + (j + 0.5) * steps[0, c] + (i + 0.5) * steps[1, c]
                slope = steps[2, c]
                if abs(slope) < 1e-9 * pixel:
                    if at < low[c] or at > high[c]:
                        upper = -1e30
                    continue
                enter, leave = (low[c] - at) / slope, (high[c] - at) / slope
                if enter > leave:
                    enter, leave = leave, enter
                lower = max(lower, enter)
                if leave < upper:
                    upper, seen = leave, c
            if lower <= upper and upper > height[i, j]:
                height[i, j] = upper
                facing[i, j] = abs(steps[2, seen]) / pixel
                hit[i, j] = True


@kernel
def openness(
    height: npt.NDArray[np.float32],
    around: npt.NDArray[np.float32],
    offsets: IntArray,
    reaches: FloatArray,
    weights: FloatArray,
    found: npt.NDArray[np.float32],
) -> None:
    """Fill the share of electrons that find their way out, 0 to 1.

    In every direction what rises highest hides the sky up to its angle h; of electrons that leave as the cosine
    to the beam, cos² h pass over it.

    Parameters
    ----------
    height : array of float32, shape (rows, columns)
        Height of what is seen [pixel].
    around : array of float32, shape (m, rows, columns)
        Mean height of what lies around a pixel, for each distance looked at: the farther, the wider [pixel].
    offsets : IntArray, shape (n, m, 2)
        Rows and columns from a pixel to where it looks, by direction and distance.
    reaches : FloatArray, shape (m,)
        The distances [pixel].
    weights : FloatArray, shape (n,)
        How much each direction counts; 1 in all.
    found : array of float32, shape (rows, columns)
        The result.
    """
    rows, columns = height.shape
    for i in range(rows):
        for j in range(columns):
            here, total = height[i, j], 0.0
            for k in range(len(weights)):
                steepest = 0.0
                for m in range(len(reaches)):
                    y = min(max(i + offsets[k, m, 0], 0), rows - 1)
                    x = min(max(j + offsets[k, m, 1], 0), columns - 1)
                    steepest = max(steepest, (around[m, y, x] - here) / reaches[m])
                total += weights[k] / (1.0 + steepest * steepest)
            found[i, j] = total


def tangents_of(points: FloatArray, sizes: IntArray) -> FloatArray:
    """Return unit vectors along pieces of a line at their points, shape (n, 3)."""
    along = [np.gradient(piece, axis=0) for piece in np.split(points, np.cumsum(sizes)[:-1])]
    joined = np.concatenate(along)
    return np.asarray(joined / np.linalg.norm(joined, axis=1, keepdims=True))

"""Rasterising of round tubes into pictures of the height of what is seen.

Columns count from the left edge, rows from the upper one, both in pixels; the middle of the first pixel is at 0.5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.jit import inline_kernel, kernel

if TYPE_CHECKING:
    import numpy.typing as npt

    from app.views.tubes import Tube
    from rigs.axes import FloatArray, IntArray

NOTHING: Final = -1e9
"""Height where nothing is."""


@inline_kernel
def _columns(left: int, right: int, x: float, ux: float, behind: float, ahead: float) -> tuple[int, int]:
    """Return the first and last of the columns in which ux (column - x) is between two distances [pixel]."""
    if ux * ux <= 1e-6:
        return left, right
    one, other = behind / ux, ahead / ux
    first, last = np.ceil(min(one, other) + x - 0.5), np.floor(max(one, other) + x - 0.5)
    return max(left, int(first)), min(right, int(last))


@kernel
def draw_tube(
    points: FloatArray,
    tangents: FloatArray,
    values: FloatArray,
    joined: npt.NDArray[np.bool_],
    reaches: FloatArray,
    radius: float,
    height: npt.NDArray[np.float32],
    normal: npt.NDArray[np.float32],
    value: npt.NDArray[np.float32],
) -> None:
    """Draw a round tube along points where it is the highest so far.

    Parameters
    ----------
    points, tangents : FloatArray, shape (n, 3)
        Column, row and height [pixel], and unit vectors along the tube there.
    values : FloatArray, shape (n,)
        A value at every point, which runs on evenly between them.
    joined : array of bool, shape (n - 1,)
        Where a point and the next are of one piece.
    reaches : FloatArray, shape (n - 1, 2)
        How far beyond a segment's first and last point what is seen of it reaches along it [pixel], as `reaches_of`.
    radius : float
        Of the tube [pixel].
    height, value : array of float32, shape (rows, columns)
        Height of what is seen [pixel], and its value; changed in place.
    normal : array of float32, shape (3, rows, columns)
        Unit vector out of its surface there: to the right, downwards and to the eye; changed in place.
    """
    rows, columns = height.shape
    for k in range(len(points) - 1):
        if not joined[k]:
            continue
        before, after = reaches[k, 0], reaches[k, 1]
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
            first, last = _columns(left, right, ax, ux, -before - dy * uy, length * along + after - dy * uy)
            for j in range(first, last + 1):
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
                size = np.sqrt(nx * nx + ny * ny + nz * nz)
                normal[0, i, j], normal[1, i, j], normal[2, i, j] = nx / size, ny / size, max(0.0, nz / size)
                value[i, j] = (1.0 - share) * values[k] + share * values[k + 1]


def tangents_of(points: FloatArray, sizes: IntArray) -> FloatArray:
    """Return unit tangents of a polyline at its points, shape (n, 3)."""
    along = [np.gradient(piece, axis=0) for piece in np.split(points, np.cumsum(sizes)[:-1])]
    joined = np.concatenate(along)
    return np.asarray(joined / np.linalg.norm(joined, axis=1, keepdims=True))


def joined(yarn: Tube) -> npt.NDArray[np.bool_]:
    """Return whether every two consecutive points belong to one piece, (n - 1,)."""
    found = np.ones(len(yarn.points) - 1, dtype=np.bool_)
    found[np.cumsum(yarn.sizes)[:-1] - 1] = False
    return found


def reaches_of(points: FloatArray, joined: npt.NDArray[np.bool_], radius: float) -> FloatArray:
    """Return how far beyond its two points a segment is visible along its projection, (n - 1, 2) [pixel].

    At an end of a piece that is the radius of the ball there. At a joint the ball shows in the wedge between two
    segments alone; of a segment that leans to the eye its round end shows too.
    """
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1, keepdims=True)
    along = step / np.where(length > 0.0, length, 1.0)
    # Tangent of half the angle between two segments.
    bend = np.linalg.norm(along[1:] - along[:-1], axis=1) / np.maximum(
        np.linalg.norm(along[1:] + along[:-1], axis=1), 1e-9
    )
    wedge = np.where(joined[1:] & joined[:-1], bend, 1.0)
    found = np.stack([np.append(1.0, wedge), np.append(wedge, 1.0)], axis=1)
    return np.asarray(radius * np.minimum(found + np.abs(along[:, 2:]), 1.0) + 1.0)

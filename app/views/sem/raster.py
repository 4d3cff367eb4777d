"""Depth raster: what the beam hits at every pixel, and how open the sky is above it.

Kernels on pictures of the height [pixel] of what is seen; where nothing is, it is `NOTHING`. Columns count from the
left edge, rows from the upper one, both in pixels, and the middle of the first pixel is at 0.5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.jit import kernel

if TYPE_CHECKING:
    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray


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
        Height of what is seen [pixel], and the cosine between its surface's normal and the beam; changed in place.
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
    """Compute the share of electrons that escape at every pixel, 0 to 1.

    In every direction what rises highest hides the sky up to its angle h; of electrons that leave as the cosine
    to the beam, cos² h pass over it.

    Parameters
    ----------
    height : array of float32, shape (rows, columns)
        Height of what is seen [pixel].
    around : array of float32, shape (m, rows, columns)
        Mean height around a pixel, for each distance looked at: the farther, the wider [pixel].
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

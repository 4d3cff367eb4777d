"""Pictures of a periodic cell: the cell with the images around it, and its outline."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from app.views.tubes import Tube
from rigs.axes import COORDINATE, DIRECTIONS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from app.records.reader import RunReader
    from app.views.cameras import View
    from app.views.tubes import Window
    from knitlab_core.knits import Specimen
    from rigs.axes import FloatArray
    from rigs.record import Frame

SHOWN: Final = {2: 0.8, 3: 0.6}
"""How much of the images is shown: a picture reaches so many cells to each side of the cell's middle, by directions."""


def vectors_at(run: RunReader, frames: Sequence[Frame]) -> list[FloatArray]:
    """Return the vectors (D, 3) of the cell at some frames [m]; empty where the specimen has edges."""
    columns = run.trace.columns
    axes = [axis for axis in DIRECTIONS if f"cell_{axis}" in columns]
    found = []
    for frame in frames if axes else ():
        row = int(np.argmin(np.abs(columns["time"] - frame.time)))
        vectors = np.zeros((len(axes), 3))
        for vector, along in product(axes, axes):
            name = f"cell_{vector}" if vector == along else f"cell_{vector}{along}"
            if name in columns:
                vectors[COORDINATE[vector], COORDINATE[along]] = columns[name][row]
        found.append(vectors)
    return found


def vectors_of(specimen: Specimen) -> FloatArray | None:
    """Return the vectors (D, 3) of the cell of a specimen as made [m]; None where it has edges."""
    return None if specimen.cell is None else specimen.cell.vectors


def with_images(cell: Tube, vectors: FloatArray, view: View) -> Tube:
    """Return the tubes of a cell, seen from somewhere, with those of the cells around it [mm]."""
    around = np.array(list(product((-1, 0, 1), repeat=len(vectors)))) @ vectors
    shifts = 1e3 * view.seen(around)
    return Tube(
        points=np.concatenate([cell.points + shift for shift in shifts]),
        values=np.tile(cell.values, len(shifts)),
        radius=cell.radius,
        sizes=np.tile(cell.sizes, len(shifts)),
    )


def middle_of(nodes: FloatArray, view: View) -> FloatArray:
    """Return the middle of a cell's yarn in a picture (2,) [mm]."""
    middle: FloatArray = 1e3 * view.seen(np.asarray(nodes).mean(axis=0))[:2]
    return middle


def window_of(middles: Sequence[FloatArray], cells: Sequence[FloatArray], view: View) -> Window:
    """Return the window x0, x1, y0, y1 [mm] that shows every cell with a part of its images."""
    reach = [SHOWN[len(vectors)] * 1e3 * np.abs(view.seen(vectors)[:, :2]).sum(axis=0) for vectors in cells]
    low = np.min([middle - far for middle, far in zip(middles, reach, strict=True)], axis=0)
    high = np.max([middle + far for middle, far in zip(middles, reach, strict=True)], axis=0)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def outline(axes: Axes, middle: FloatArray, vectors: FloatArray, view: View) -> None:
    """Draw the edges of a cell about its middle [mm]."""
    seen = 1e3 * view.seen(vectors)[:, :2]
    corners = np.array(list(product((-0.5, 0.5), repeat=len(seen))))
    for k, vector in enumerate(seen):
        for corner in corners[corners[:, k] < 0.0]:
            start = middle + corner @ seen
            x, y = np.stack([start, start + vector], axis=-1)
            axes.plot(x, y, "--", color="black", lw=1.2, zorder=4)

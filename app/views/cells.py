"""Pictures of a periodic cell: the cell with the images around it, and its outline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.views.tubes import Tube

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from app.records.reader import RunReader
    from app.views.tubes import Window
    from knitlab_core.knits import Specimen
    from rigs.axes import FloatArray
    from rigs.record import Frame

SHOWN: Final = 0.8
"""How much of the images is shown: a picture reaches so many cells to each side of the cell's middle."""

Lengths = tuple[float, float]
"""Lengths of a cell along course and wale [m]."""


def lengths_at(run: RunReader, frames: Sequence[Frame]) -> list[Lengths]:
    """Return the lengths of the cell at some frames [m]; empty where the specimen has edges."""
    columns = run.trace.columns
    if "cell_C" not in columns:
        return []
    rows = [int(np.argmin(np.abs(columns["time"] - frame.time))) for frame in frames]
    return [(float(columns["cell_C"][row]), float(columns["cell_W"][row])) for row in rows]


def lengths_of(specimen: Specimen) -> Lengths | None:
    """Return the lengths of the cell of a specimen as made [m]; None where it has edges."""
    if specimen.cell is None:
        return None
    course, wale = specimen.cell.vectors
    return float(course[0]), float(wale[1])


def with_images(cell: Tube, lengths: Lengths) -> Tube:
    """Return the tubes of a cell with those of the eight cells around it [mm]."""
    shifts = [np.array([1e3 * x * lengths[0], 1e3 * y * lengths[1], 0.0]) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    return Tube(
        points=np.concatenate([cell.points + shift for shift in shifts]),
        values=np.tile(cell.values, len(shifts)),
        radius=cell.radius,
        sizes=np.tile(cell.sizes, len(shifts)),
    )


def middle_of(nodes: FloatArray) -> FloatArray:
    """Return the middle of a cell's yarn in the plane (2,) [mm]."""
    middle: FloatArray = 1e3 * np.asarray(nodes)[:, :2].mean(axis=0)
    return middle


def window_of(middles: Sequence[FloatArray], lengths: Sequence[Lengths]) -> Window:
    """Return the window x0, x1, y0, y1 [mm] that shows every cell with a part of its images."""
    reach = [SHOWN * 1e3 * np.array(one) for one in lengths]
    low = np.min([middle - far for middle, far in zip(middles, reach, strict=True)], axis=0)
    high = np.max([middle + far for middle, far in zip(middles, reach, strict=True)], axis=0)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def outline(axes: Axes, middle: FloatArray, lengths: Lengths) -> None:
    """Draw the outline of a cell about its middle [mm]."""
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - imported when a picture is wanted

    width, height = 1e3 * lengths[0], 1e3 * lengths[1]
    corner = middle[0] - 0.5 * width, middle[1] - 0.5 * height
    axes.add_patch(Rectangle(corner, width, height, fill=False, linestyle="--", linewidth=1.2, zorder=4))

"""Pictures of layers: single ones to scale, and a sheet of several."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from app.records.folder import whole_file
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from app.printing.slices import Layer
    from rigs.axes import FloatArray

MOST_PIXELS: Final = 20_000_000
_INK, _PAPER = "#1f4e79", "#ffffff"
_PANEL = 2.6
_DPI = 200


class Window(NamedTuple):
    """Part of the tray that a picture shows [mm], and its resolution."""

    width: float
    height: float
    margin: float
    pixel: float

    @property
    def shape(self) -> tuple[int, int]:
        """Return the rows and columns of pixels."""
        rows, columns = (math.ceil((side + 2.0 * self.margin) / self.pixel) for side in (self.height, self.width))
        return rows, columns


def window(bounds: FloatArray, pixel: float) -> Window:
    """Return the window on everything between two corners of the tray.

    Raises
    ------
    SpecificationError
        If a picture would have more than `MOST_PIXELS`.
    """
    width, height = (float(side) for side in bounds[1, :2])
    found = Window(width, height, 0.03 * max(width, height), pixel)
    rows, columns = found.shape
    if rows * columns > MOST_PIXELS:
        allowed = f"at most {MOST_PIXELS} pixels: a smaller knit, or a printer of coarser resolution"
        raise SpecificationError("slices", f"{columns} x {rows} pixels", allowed)
    return found


def raster(layer: Layer, view: Window) -> NDArray[np.bool_]:
    """Rasterise a layer's outline: a pixel is on if its middle is inside, first row at the top.

    Each piece of outline adds its sense to the pixels right of where it crosses their row's middle; where the sum
    is above 0 there is material, once or, where fibres overlap, more often.

    Parameters
    ----------
    layer : Layer
        The section.
    view : Window
        The pixels.

    Returns
    -------
    array of bool, shape (rows, columns)
    """
    rows, columns = view.shape
    pieces = (layer.outline + view.margin) / view.pixel - 0.5
    lower = np.where((pieces[:, 0, 1] <= pieces[:, 1, 1])[:, None, None], pieces, pieces[:, ::-1])
    sense = np.where(pieces[:, 0, 1] > pieces[:, 1, 1], 1, -1)
    first = np.ceil(lower[:, 0, 1]).astype(np.int64)
    crossed = np.ceil(lower[:, 1, 1]).astype(np.int64) - first
    piece = np.repeat(np.arange(len(pieces)), crossed)
    row = np.arange(len(piece)) - np.repeat(np.cumsum(crossed) - crossed, crossed) + first[piece]
    (x0, y0), (x1, y1) = lower[piece, 0].T, lower[piece, 1].T
    column = np.ceil(x0 + (x1 - x0) * (row - y0) / (y1 - y0)).astype(np.int64)
    winding = np.zeros((rows, columns), dtype=np.int32)
    np.add.at(winding, (row, column), sense[piece])
    filled: NDArray[np.bool_] = np.cumsum(winding, axis=1, dtype=np.int32)[::-1] > 0
    return filled


def write_layer(layer: Layer, view: Window, path: Path) -> Path:
    """Write one layer, a pixel per dot of the printer, with a strip below: scale bar, number, height and scale."""
    from matplotlib.figure import Figure  # noqa: PLC0415 (imported when a picture is wanted)

    rows, columns = view.shape
    strip = 70
    figure = Figure(figsize=(columns / 100, (rows + strip) / 100), dpi=100, facecolor=_PAPER)
    axes = figure.add_axes((0.0, strip / (rows + strip), 1.0, rows / (rows + strip)))
    _fill(axes, layer, view)
    axes.set_axis_off()
    bar = _round_length(view.width / 5)
    below = figure.add_axes((0.0, 0.0, 1.0, strip / (rows + strip)), xlim=(0, columns), ylim=(0, strip))
    below.set_axis_off()
    below.fill_between([20, 20 + bar / view.pixel], 46, 54, color="black", linewidth=0)
    words = f"{_length(bar)} | layer {layer.number}, z = {_length(layer.height)} | {1 / view.pixel:.4g} px/mm"
    below.text(20, 12, words, fontsize=13)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=100)
    return path


def write_sheet(layers: Sequence[Layer], view: Window, path: Path, title: str) -> Path:
    """Write a sheet of layers, from the tray upwards, with one scale bar."""
    from matplotlib.figure import Figure  # noqa: PLC0415 (as above)

    columns = math.ceil(math.sqrt(len(layers)))
    rows = math.ceil(len(layers) / columns)
    shape = view.shape[0] / view.shape[1]
    figure = Figure(figsize=(_PANEL * columns, (_PANEL * shape + 0.3) * rows + 0.9), layout="constrained")
    figure.suptitle(title, fontsize=11)
    grid = list(np.atleast_1d(figure.subplots(rows, columns)).ravel())
    for axes in grid[len(layers) :]:
        axes.set_axis_off()
    for axes, layer in zip(grid, layers, strict=False):
        _fill(axes, layer, view)
        axes.set(xticks=[], yticks=[])
        axes.set_title(f"layer {layer.number}, z = {_length(layer.height)}\n{layer.area:.4g} mm²", fontsize=8)
    bar = _round_length(view.width / 3)
    grid[0].plot([0.0, bar], [-0.5 * view.margin] * 2, color="black", linewidth=3, solid_capstyle="butt")
    figure.supxlabel(f"bar: {_length(bar)}; section areas in mm²; {1 / view.pixel:.4g} px/mm", fontsize=9)
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=_DPI, facecolor=_PAPER)
    return path


def _fill(axes: Axes, layer: Layer, view: Window) -> None:
    """Draw a layer's pixels at their place on the tray."""
    from matplotlib.colors import ListedColormap  # noqa: PLC0415 (as above)

    rows, columns = view.shape
    left = bottom = -view.margin
    extent = (left, left + columns * view.pixel, bottom, bottom + rows * view.pixel)
    colours = ListedColormap([_PAPER, _INK])
    # Every pixel shows where there is one for each dot; a smaller picture averages them.
    axes.imshow(raster(layer, view), cmap=colours, vmin=0, vmax=1, extent=extent, interpolation_stage="rgba")


def _round_length(length: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that is not above a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))


def _length(length: float) -> str:
    """Return a length [mm] as text, in µm below 0.1 mm."""
    return f"{length:.4g} mm" if length >= 0.1 else f"{1e3 * length:.4g} µm"

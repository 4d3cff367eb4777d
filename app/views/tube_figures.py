"""Figures of tubes side by side, with one scale of colours and one of lengths."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.views.cameras import FROM_ABOVE
from app.views.curve_styles import TITLE
from app.views.curves import prefixed
from app.views.tube_images import tube_images
from app.views.tubes import fit_window

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from app.views.cameras import View
    from app.views.tubes import Tube, Window
    from rigs.axes import FloatArray


#: Light to dark, and from both sides of zero for values with signs; both sound for colour-blind readers.
HEIGHTS = "YlGnBu"


SIGNED = "coolwarm"


#: Least range of the colours [%]: what is less is the noise of rounding.
LEAST_STRAIN = 0.01


def draw(
    tubes: Sequence[Tube],
    titles: Sequence[str],
    label: str,
    add: Callable[[Figure], None],
    *,
    signed: bool = False,
    view: View = FROM_ABOVE,
    window: Window | None = None,
) -> Figure:
    """Draw tubes side by side, with one colour scale and one length scale.

    Parameters
    ----------
    tubes : sequence of Tube
        What to draw.
    titles : sequence of str
        One per tube.
    label : str
        Words beside the colour bar.
    add : callable
        Adds what belongs on top, before the page is laid out.
    signed : bool
        Whether values have signs, and their colours part at zero.
    view : View
        How the tubes were turned to the eye.
    window : tuple of 4 floats, optional
        What is shown, x0, x1, y0, y1 [mm]; by default all of the tubes.

    Returns
    -------
    Figure
        Its first axes are the tubes'.
    """
    from matplotlib import colormaps  # noqa: PLC0415 - imported when a picture is wanted
    from matplotlib.cm import ScalarMappable  # noqa: PLC0415
    from matplotlib.colors import Normalize  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    from app.views.plotting import DPI, PixelImage, lay_out  # noqa: PLC0415

    window = fit_window(tubes) if window is None else window
    width, height = window[1] - window[0], window[3] - window[2]
    colours = SIGNED if signed else HEIGHTS
    (low, high), limits = colour_limits(np.concatenate([one.values for one in tubes]), signed=signed)
    scale = ScalarMappable(Normalize(*limits), colours)
    panel = 4.6 if len(tubes) > 1 else 6.2
    heading = 0.7 + 0.3 * max(title.count("\n") for title in titles)
    figure = Figure(figsize=(panel * len(tubes) + 1.4, panel * height / width + heading), layout="constrained")
    row = list(np.atleast_1d(figure.subplots(1, len(tubes), sharey=True)))
    for axes, title in zip(row, titles, strict=True):
        _dress(axes, title, window)
        view.dress(axes)
    for axes in row[1:]:
        axes.set_ylabel("")
    bar = figure.colorbar(scale, cax=row[-1].inset_axes((1.03, 0.0, 0.035, 1.0)))
    bar.ax.set_ylim(low, high)
    bar.set_label(label, fontsize=12)
    _fit_units(row, max(width, height))
    add(figure)
    # Laid out now, so that an image has the pixels its place on the page has.
    lay_out(figure)
    pixels = DPI * row[0].get_position().width * figure.get_figwidth() / width
    table = colormaps[colours](np.arange(256))[:, :3]
    for axes, image in zip(row, tube_images(tubes, window, pixels=pixels, limits=limits, table=table), strict=True):
        axes.add_artist(PixelImage(image))
    return figure


def colour_limits(values: FloatArray, *, signed: bool) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends of the colour bar, and the values of the first and the last colour of its map.

    Of values with signs zero has the middle colour, and the same distance from it the same strength of colour.
    """
    low, high = (float(value) for value in np.percentile(values, [0.2, 99.8]))
    if not signed:
        return (low, max(high, low + 1e-6)), (low, max(high, low + 1e-6))
    low, high = min(low, 0.0), max(high, 0.0)
    if high - low < LEAST_STRAIN:
        low, high = -LEAST_STRAIN, LEAST_STRAIN
    size = max(-low, high)
    return (low, high), (-size, size)


def _fit_units(row: Sequence[Axes], extent: float) -> None:
    """Write lengths in the unit that suits an extent [mm]."""
    factor, letter = prefixed(1e-3 * extent)
    if letter == "m":
        return
    for axes in row:
        for one in (axes.xaxis, axes.yaxis):
            one.set_major_formatter(lambda value, _: f"{1e-3 * factor * value:g}".replace("-", "\N{MINUS SIGN}"))
            one.set_label_text(one.get_label_text().replace("[mm]", f"[{letter}m]"))


def _dress(axes: Axes, title: str, window: tuple[float, float, float, float]) -> None:
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    axes.set_title(title, fontsize=13, y=TITLE)
    axes.tick_params(length=3, labelsize=10)
    for side in axes.spines.values():
        side.set_color("#bbbbbb")

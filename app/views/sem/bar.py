"""Data bar under an image: a scale of a round length, and the imaging parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from app.views.sem.units import metric, rounded

if TYPE_CHECKING:
    import numpy.typing as npt

    from app.views.sem.view import View

LONGEST: Final = 0.17
"""Length of the scale at most, over the image's width."""

MARGIN: Final = 0.012
"""Free space at the left edge, over the image's width."""

WHITE: Final = 255


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """Scale bar of an image: its length [m] and [pixel], and its first column and row in the bar."""

    length: float
    pixels: int
    column: int
    row: int


def scale_of(view: View) -> Scale:
    """Return the longest scale of 1, 2 or 5 times a power of ten that fits."""
    length = rounded(LONGEST * view.width * view.pixel)
    return Scale(
        length=length,
        pixels=round(length / view.pixel),
        column=round(MARGIN * view.width),
        row=view.height - view.bar + round(0.68 * view.bar),
    )


def with_bar(grey: npt.NDArray[np.uint8], view: View, columns: tuple[tuple[str, str], ...]) -> npt.NDArray[np.uint8]:
    """Draw the data bar over the lowest rows of an image, as the instrument does.

    Parameters
    ----------
    grey : array of uint8, shape (rows, columns)
        The image.
    view : View
        Gives the scale.
    columns : tuple of (str, str)
        Upper and lower line of every column of text.
    """
    made = grey.copy()
    top, bar = view.height - view.bar, view.bar
    strip = Image.new("L", (view.width, bar), 0)
    pen, font = ImageDraw.Draw(strip), _font(round(0.29 * bar))
    scale = scale_of(view)
    pen.text((scale.column + 0.5 * scale.pixels, 0.34 * bar), metric(scale.length, 3), WHITE, font, anchor="mm")
    begin = MARGIN + LONGEST + 0.03
    # Columns are as wide as their text, with equal spaces between them.
    widths = [max(pen.textlength(line, font) for line in column) for column in columns]
    space = ((1.0 - begin - MARGIN) * view.width - sum(widths)) / max(1, len(columns) - 1)
    left = begin * view.width
    for column, width in zip(columns, widths, strict=True):
        for line, at in zip(column, (0.3, 0.72), strict=True):
            pen.text((left, at * bar), line, WHITE, font, anchor="lm")
        left += width + space
    made[top:] = np.asarray(strip)
    made[top : top + 1] = WHITE
    thick, tick = max(2, round(0.05 * bar)), round(0.16 * bar)
    ends = (scale.column, scale.column + scale.pixels - thick)
    made[scale.row : scale.row + thick, scale.column : scale.column + scale.pixels] = WHITE
    for end in ends:
        made[scale.row - tick : scale.row + tick + thick, end : end + thick] = WHITE
    return made


def _font(size: int) -> ImageFont.FreeTypeFont:
    """Return the sans-serif font that comes with matplotlib, of a size [pixel]."""
    import matplotlib as mpl  # noqa: PLC0415 - half a second that other commands need not wait

    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), size)

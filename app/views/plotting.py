"""Layout and writing of matplotlib figures, each step once; matplotlib by itself repeats the layout."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.artist import Artist

from app.records.folder import whole_file
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.backend_bases import RendererBase
    from matplotlib.figure import Figure

DPI: Final = 160
"""Pixels of a figure along an inch."""

SCREEN: Final = 90
"""Pixels along an inch in a notebook."""

COMPRESSION: Final = {"compress_level": 3}
"""Of PNG files: half the usual time for a tenth more bytes."""


def lay_out(figure: Figure) -> None:
    """Lay out a finished figure; from now on its parts stay where they are."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        for axes in figure.axes:
            axes.apply_aspect()
        figure.set_layout_engine("none")


def save(figure: Figure, path: Path) -> Path:
    """Write a figure, atomically, in the format of the file's suffix.

    Raises
    ------
    SpecificationError
        If matplotlib writes no such format.
    """
    kind, kinds = path.suffix.lstrip(".").lower(), figure.canvas.get_supported_filetypes()
    if kind not in kinds:
        raise SpecificationError("file of a figure", path.name, f"a name that ends in .{', .'.join(sorted(kinds))}")
    lay_out(figure)
    options: dict[str, Any] = {"pil_kwargs": COMPRESSION} if kind == "png" else {}
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=DPI, facecolor="white", **options)
    return path


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure that a notebook shows.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    """

    figure: Figure

    def _repr_png_(self) -> bytes:
        content = io.BytesIO()
        lay_out(self.figure)
        self.figure.savefig(content, dpi=SCREEN, facecolor="white", pil_kwargs=COMPRESSION)
        return content.getvalue()

    def html(self) -> str:
        """Return it as part of a page."""
        content = base64.b64encode(self._repr_png_()).decode()
        return f"<img alt='curves of the test' style='max-width:100%' src='data:image/png;base64,{content}'>"

    def save(self, path: Path | str) -> Path:
        """Write it as PNG, atomically."""
        return save(self.figure, Path(path))


class PixelImage(Artist):
    """An image with as many pixels as the place of its axes on the page.

    Parameters
    ----------
    image : array of uint8, shape (rows, columns, 3)
        RGB.
    """

    zorder = 2

    def __init__(self, image: npt.NDArray[np.uint8]) -> None:
        super().__init__()
        rows, columns, _ = image.shape
        self._pixels = np.full((rows, columns, 4), 255, dtype=np.uint8)
        self._pixels[..., :3] = image[::-1]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of pixels."""
        rows, columns, _ = self._pixels.shape
        return rows, columns

    def draw(self, renderer: RendererBase) -> None:
        """Draw the pixels on the page."""
        if self.axes is None:
            return
        box, graphics = self.axes.bbox, renderer.new_gc()
        renderer.draw_image(graphics, round(box.x0), round(box.y0), self._pixels)
        graphics.restore()

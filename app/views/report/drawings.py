"""Plots and pictures of a run inside a page: inline SVG, and PNG as data."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

from markupsafe import Markup

if TYPE_CHECKING:
    from collections.abc import Callable

_HEAD: Final = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_LEFT_OUT: Final = re.compile(r"<!--.*?-->|<metadata>.*?</metadata>", re.DOTALL)
_NAMES: Final = re.compile(r'(\bid="|href="#|url\(#)')
_SIZE: Final = re.compile(r'(<svg[^>]*?) width="[^"]*"', re.DOTALL)
_HEIGHT: Final = re.compile(r'(<svg[^>]*?) height="[^"]*"', re.DOTALL)


def inline_svg(draw: Callable[[Path], object], label: str, name: str) -> Markup:
    """Return a plot as inline SVG of the page's width.

    Parameters
    ----------
    draw : callable
        Writes the figure to a path, in the format of its suffix.
    label : str
        What the plot shows, for readers of screens.
    name : str
        What the names inside begin with, so that several plots in a page do not share them.
    """
    from matplotlib import rc_context  # noqa: PLC0415 (only where something is drawn)

    with TemporaryDirectory(prefix="knitlab-report-") as folder, rc_context({"svg.hashsalt": name}):
        path = Path(folder) / "figure.svg"
        draw(path)
        text = path.read_text(encoding="utf-8")
    text = _LEFT_OUT.sub("", _HEAD.sub("", text, count=1))
    text = _NAMES.sub(rf"\g<1>{name}-", text)
    for size in (_SIZE, _HEIGHT):
        text = size.sub(r"\1", text, count=1)
    # matplotlib escapes the texts of users; the label is escaped here.
    return Markup(text).replace(  # noqa: S704
        Markup("<svg"), Markup('<svg role="img" aria-label="{}"').format(label), 1
    )


def picture(draw: Callable[[Path], object]) -> str:
    """Return a picture as a data address.

    Parameters
    ----------
    draw : callable
        Writes the picture to a path, in the format of its suffix.
    """
    with TemporaryDirectory(prefix="knitlab-report-") as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        content = path.read_bytes()
    return f"data:image/png;base64,{base64.b64encode(content).decode()}"

"""Texts of users in figures, drawn as written: no formulas between dollars, letters of other scripts."""

from __future__ import annotations

import warnings
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from matplotlib.text import Text

FAMILIES: Final = (
    "Noto Sans CJK SC",
    "Noto Sans Devanagari",
    "Microsoft YaHei",
    "Malgun Gothic",
    "Nirmala UI",
    "PingFang SC",
    "Hiragino Sans",
    "Arial Unicode MS",
)
"""Fonts of common systems for letters that matplotlib's own font has not, in the order in which they are tried."""


def write_plainly(texts: Iterable[Text]) -> None:
    """Draw all texts of a figure literally, character by character."""
    for text in texts:
        text.set_parse_math(False)
        text.set_fontfamily(list(_families()))


@contextmanager
def boxes_allowed() -> Iterator[None]:
    """Draw a box for a letter that no font has, without a warning: the record has the name too."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        yield


@lru_cache(maxsize=1)
def _families() -> tuple[str, ...]:
    """Return matplotlib's own font, and those of `FAMILIES` that are installed."""
    from matplotlib.font_manager import get_font_names  # noqa: PLC0415 - imported when a plot is wanted

    installed = set(get_font_names())
    return ("DejaVu Sans", *(name for name in FAMILIES if name in installed))

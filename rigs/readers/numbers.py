"""Numbers as countries and instruments write them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from rigs.logs.alemnis import PREFIXES

if TYPE_CHECKING:
    from collections.abc import Iterable

_SPACES: Final = " \u00a0\u202f'\u2019"
_END: Final = r"(?:[eE][-+]?\d{1,3})?"


def _pattern(decimal: str) -> re.Pattern[str]:
    other = "," if decimal == "." else "."
    mark = re.escape(decimal)
    # A group of thousands never begins with 0: 0,123 is no 123. All marks of a number are the same.
    grouped = rf"[1-9]\d{{0,2}}(?P<mark>[{re.escape(other)}{_SPACES}])\d{{3}}(?:(?P=mark)\d{{3}})*"
    return re.compile(rf"[-+\u2212]?(?:(?:{grouped}|\d+)(?:{mark}\d*)?|{mark}\d+){_END}")


PATTERNS: Final = {decimal: _pattern(decimal) for decimal in ".,"}
"""Numbers by the mark of their decimals."""

_SIZES: Final = {**dict(PREFIXES), "µ": 1e-6, "μ": 1e-6, "k": 1e3, "f": 1e-15}
_PREFIXED: Final = re.compile(rf"([-+]?[\d.]+{_END})\s*([{''.join(_SIZES)}])")
_CLOCK: Final = re.compile(r"(-?)(\d+):([0-5]?\d):([0-5]?\d(?:[.,]\d*)?)")
_REMOVED: Final = {mark: str.maketrans("", "", _SPACES + ("," if mark == "." else ".")) for mark in ".,"}


def decimal_of(fields: Iterable[str], delimiter: str) -> str:
    """Return the mark of decimals in some fields: that with which most of them are numbers.

    Where both are as good, as in ``1,234`` alone, it is the comma between semicolons, and else the point.

    Examples
    --------
    >>> decimal_of(["1.234,5", "7"], ";"), decimal_of(["1,234.5", "7"], ","), decimal_of(["1,234"], ";")
    (',', '.', ',')
    """
    # Between commas a comma in a field stands in quotes: it marks thousands, unless only decimals make sense of it.
    order = ",." if delimiter == ";" else ".,"
    texts = list(fields)
    return max(order, key=lambda mark: sum(PATTERNS[mark].fullmatch(text) is not None for text in texts))


def number(text: str, decimal: str) -> float | None:
    """Return the number that a field shows, nan of an empty one, and None if it shows none.

    Read are marks of decimals and thousands, SI prefixes and times of a clock (in seconds).

    Examples
    --------
    >>> number("1,234.5", "."), number("1.234,5", ","), number("-1.42m", "."), number("-00:00:06.135", ".")
    (1234.5, 1234.5, -0.00142, -6.135)
    >>> number("1,23.5", "."), number("Load", ".")
    (None, None)
    """
    if not text:
        return float("nan")
    if PATTERNS[decimal].fullmatch(text):
        return float(text.translate(_REMOVED[decimal]).replace(",", ".").replace("\u2212", "-"))
    if prefixed := _PREFIXED.fullmatch(text):
        try:
            # One rounding, as of the number that was meant.
            return float(f"{float(prefixed[1]) * _SIZES[prefixed[2]]:.15g}")
        except ValueError:
            return None
    if clock := _CLOCK.fullmatch(text):
        seconds = 3600.0 * int(clock[2]) + 60.0 * int(clock[3]) + float(clock[4].replace(",", "."))
        return -seconds if clock[1] else seconds
    return None

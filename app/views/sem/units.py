"""Lengths and times in the microscope's notation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from datetime import datetime

PREFIXES: Final = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"), (1e-12, "pm"))
MONTHS: Final = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
ROUND: Final = (1.0, 2.0, 5.0)
#: So that a length that is round but for the last bit stays it.
SLACK: Final = 1.0 + 1e-9


def metric(length: float, digits: int) -> str:
    """Return a length [m] in the unit that suits it.

    Examples
    --------
    >>> metric(5e-5, 3), metric(2.791e-7, 4)
    ('50 µm', '279.1 nm')
    """
    factor, unit = next((one for one in PREFIXES if length * SLACK >= one[0]), PREFIXES[-1])
    return f"{length / factor:.{digits}g} {unit}"


def rounded(length: float) -> float:
    """Return the largest of 1, 2 or 5 times a power of ten that is not above a length.

    Examples
    --------
    >>> rounded(0.7), rounded(20.0)
    (0.5, 20.0)
    """
    power = 10.0 ** math.floor(math.log10(length * SLACK))
    return power * max(one for one in ROUND if one * power <= length * SLACK)


def magnification(value: float) -> str:
    """Return a magnification.

    Examples
    --------
    >>> magnification(1000.0), magnification(400.0), magnification(2.5)
    ('1.00 K X', '400 X', '2.5 X')
    """
    return f"{value / 1e3:.2f} K X" if value * SLACK >= 1e3 else f"{value:.3g} X"


def date(moment: datetime) -> str:
    """Return a date, with the month in English whatever the locale."""
    return f"{moment.day} {MONTHS[moment.month - 1]} {moment.year}"


def clock(moment: datetime) -> str:
    """Return a time of the day."""
    return moment.strftime("%H:%M:%S")

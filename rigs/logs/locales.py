"""Say how a country writes numbers and dates, and put a dialect into it.

Assumed: where the comma marks decimals the semicolon stands between fields, as spreadsheets of that country read it,
thousands are not marked, and headings stay English. The files are UTF-8 without a byte-order mark.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from datetime import datetime

    from rigs.logs.writer import Dialect


@dataclass(frozen=True, slots=True, kw_only=True)
class Locale:
    """Hold the marks of a country.

    Attributes
    ----------
    name : str
        Its language.
    delimiter, decimal, thousands : str
        What stands between fields, before decimals and after thousands.
    day : str
        How a date is written, for `datetime.strftime`.
    half_days : bool
        Whether a day has twelve hours, twice.
    """

    name: str
    delimiter: str
    decimal: str
    thousands: str
    day: str
    half_days: bool = False

    def date(self, moment: datetime) -> str:
        """Return a date and a time to the minute, as on the clock of the laboratory."""
        if self.half_days:
            half = "AM" if moment.hour < 12 else "PM"
            return f"{moment.strftime(self.day)} {(moment.hour - 1) % 12 + 1}:{moment.minute:02d} {half}"
        return f"{moment.strftime(self.day)} {moment.hour:02d}:{moment.minute:02d}"


EN: Final = Locale(name="en", delimiter=",", decimal=".", thousands=",", day="%d/%m/%Y", half_days=True)
LOCALES: Final[Mapping[str, Locale]] = {
    "en": EN,
    "de": Locale(name="de", delimiter=";", decimal=",", thousands="", day="%d.%m.%Y"),
    "fr": Locale(name="fr", delimiter=";", decimal=",", thousands="", day="%d/%m/%Y"),
}


def localised(dialect: Dialect, name: str) -> Dialect:
    """Return a dialect as a machine of another country writes it.

    Raises
    ------
    SpecificationError
        If the locale is unknown, or the dialect is the same everywhere.
    """
    if name not in LOCALES:
        raise SpecificationError("locale", name, f"one of {', '.join(LOCALES)}")
    locale = LOCALES[name]
    if locale == dialect.locale:
        return dialect
    if dialect.delimiter != dialect.locale.delimiter:
        raise SpecificationError("locale", name, f"{dialect.locale.name} for {dialect.name}, the same everywhere")
    return replace(dialect, delimiter=locale.delimiter, locale=locale)

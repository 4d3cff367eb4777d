"""Description of a log file: columns, preamble, marks of a country; the writer follows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime

Channels: TypeAlias = "Mapping[str, Sequence[object]]"
"""Values of a part of a log by the channel's name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Locale:
    """Marks of a country in numbers and dates.

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """Form in which a value is printed.

    Attributes
    ----------
    form : str or None
        Format specification of a number, ``.3f``, with a comma where thousands are marked; None for text.
    unit : str
        Unit that a number is shown in, one of `rigs.logs.units.UNITS`; empty where it is shown as it is.
    trimmed : bool
        Whether zeros that end a number's decimals are left out.
    quoted : bool
        Whether it always stands in quotes; if not, only where it must.
    """

    form: str | None = None
    unit: str = ""
    trimmed: bool = False
    quoted: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Column(Form):
    """Column of a log.

    Attributes
    ----------
    name : str
        Heading, byte for byte; ``{unit}`` stands for the unit.
    channel : str
        Channel that it shows.
    below : str or None
        What stands below the heading, with ``{unit}`` too; None where no column of the dialect has a unit there.
    """

    name: str
    channel: str
    below: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact(Form):
    """Place of a fact of the test above the table: its name among the facts."""

    fact: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Bytes of a log file.

    Attributes
    ----------
    name : str
        What users call it.
    columns : tuple of Column
        The columns, in order.
    preamble : tuple of tuple of (str or Fact)
        Lines above the headings, field by field; an empty one is a blank line. One whose fact is None is left out.
    delimiter, line_end, quote : str
        What stands between fields, after lines and, where a text needs it, around a text.
    encoding : str
        Character set.
    locale : Locale
        How numbers and dates are written.
    """

    name: str
    columns: tuple[Column, ...]
    preamble: tuple[tuple[str | Fact, ...], ...] = ()
    delimiter: str = ","
    line_end: str = "\r\n"
    quote: str = '"'
    encoding: str = "utf-8"
    locale: Locale = EN

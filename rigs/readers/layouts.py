"""Order of columns in files without headings: that of the dialect of our logs which the rows fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.logs.catalogue import LOGS
from rigs.logs.strokes import OUTWARD, RETURN
from rigs.readers.numbers import decimal_of, number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.logs.dialect import Column, Dialect

LOOKED_AT: Final = 50
_SEGMENTS: Final = {float(OUTWARD), float(RETURN)}


def layout_of(rows: Sequence[Sequence[str]], delimiter: str) -> list[tuple[str, str]] | None:
    """Return heading and unit of every column of rows without headings; None if they fit no dialect, or several.

    Told apart are dialects by the number of their columns, by those that hold texts, times of a clock or the two
    segment identities of Bluehill 3. Units are those in which a dialect writes unless it is told otherwise.
    """
    fitting = {
        tuple((column.name.format(unit=column.unit), column.unit) for column in log.dialect.columns)
        for log in LOGS.values()
        if _fits(log.dialect, rows[:LOOKED_AT], delimiter)
    }
    return list(fitting.pop()) if len(fitting) == 1 else None


def _fits(dialect: Dialect, rows: Sequence[Sequence[str]], delimiter: str) -> bool:
    if any(len(row) != len(dialect.columns) for row in rows):
        return False
    decimal = decimal_of([field for row in rows for field in row], delimiter)
    return all(_holds(column, [row[k] for row in rows], decimal) for k, column in enumerate(dialect.columns))


def _holds(column: Column, fields: Sequence[str], decimal: str) -> bool:
    """Return whether some fields may be those of a column."""
    values = [number(field, decimal) for field in fields]
    if column.name in {"SetName", "Cycle"}:
        return all(value is None for value in values) or column.name == "SetName"
    if any(":" in field for field in fields) != column.channel.endswith(" time"):
        return False
    segments = all(value in _SEGMENTS for value in values)
    return None not in values and segments == (column.channel == "Segment")

"""Order of columns in files without headings: that of the dialect of our logs which the rows fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.logs.catalogue import LOGS
from rigs.logs.strokes import OUTWARD, RETURN
from rigs.protocol.catalogue import CATALOGUE
from rigs.readers.numbers import decimal_of, number

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigs.axes import Axis
    from rigs.logs.dialect import Column, Dialect
    from rigs.logs.logged import Log

LOOKED_AT: Final = 50
_SEGMENTS: Final = {float(OUTWARD), float(RETURN)}


def layout_of(rows: Sequence[Sequence[str]], delimiter: str) -> list[tuple[str, str]] | None:
    """Return heading and unit of every column of rows without headings; None if they fit no dialect, or several.

    Told apart are dialects by the number of their columns, by those that hold texts, times of a clock or the two
    segment identities of Bluehill 3. Units are those in which a dialect writes unless it is told otherwise. Where a log
    has columns for each axis, they are those of a rig that drives several.
    """
    known = (log.of_axes(axes) for log in LOGS.values() for axes in _axes_of(log))
    fitting = {
        tuple((column.name.format(unit=column.unit), column.unit) for column in dialect.columns)
        for dialect in known
        if _fits(dialect, rows[:LOOKED_AT], delimiter)
    }
    return list(fitting.pop()) if len(fitting) == 1 else None


def _axes_of(log: Log) -> Iterator[tuple[Axis, ...]]:
    """Yield the axes that a log may have columns of."""
    if log.axis_columns is None:
        yield ()
        return
    for rig in CATALOGUE.values():
        if not rig.mounts_one and {drive.machine for drive in rig.drives.values()} == {*log.machines}:
            yield rig.axes


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

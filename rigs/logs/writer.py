"""Write a table in a dialect: the description says how, the channels say what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Describe one column of a log.

    Attributes
    ----------
    name : str
        Heading, byte for byte.
    channel : str
        Channel that it shows.
    scale : float
        Factor from the channel's SI unit to the column's.
    form : str or None
        Format specification of a number, ``.3f``; None for text.
    unit : str or None
        What stands below the heading; None where no column of the dialect has a unit there.
    trimmed : bool
        Whether zeros that end a number's decimals are left out.
    """

    name: str
    channel: str
    scale: float = 1.0
    form: str | None = None
    unit: str | None = None
    trimmed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Describe the bytes of a log file.

    Attributes
    ----------
    name : str
        What users call it.
    columns : tuple of Column
        The columns, in order.
    delimiter, line_end, quote : str
        What stands between fields, after lines and, where a text needs it, around a text.
    encoding : str
        Character set.
    """

    name: str
    columns: tuple[Column, ...]
    delimiter: str = ","
    line_end: str = "\r\n"
    quote: str = '"'
    encoding: str = "utf-8"


def write_log(dialect: Dialect, channels: Mapping[str, Sequence[object]]) -> Iterator[bytes]:
    r"""Yield the file line by line: headings, units where the dialect has them, one line a row.

    Parameters
    ----------
    dialect : Dialect
        The description.
    channels : mapping of str to sequence, each of length n
        Numbers in SI units, or texts, by the channel's name.

    Yields
    ------
    bytes
        One line with its end.

    Raises
    ------
    SpecificationError
        If a channel is missing or not as long as the others.

    Examples
    --------
    >>> dialect = Dialect(name="d", columns=(Column(name="F_mN", channel="F", scale=1e3, form=".1f"),))
    >>> list(write_log(dialect, {"F": [0.0021]}))
    [b'F_mN\r\n', b'2.1\r\n']
    """
    for column in dialect.columns:
        if column.channel not in channels:
            expected = f"a channel {column.channel!r} for column {column.name!r}"
            raise SpecificationError(f"log.{dialect.name}", sorted(channels), expected)
    shown = [channels[column.channel] for column in dialect.columns]
    if len({len(values) for values in shown}) != 1:
        raise SpecificationError(f"log.{dialect.name}", [len(values) for values in shown], "channels of one length")
    yield _line(dialect, [column.name for column in dialect.columns])
    if any(column.unit is not None for column in dialect.columns):
        yield _line(dialect, [column.unit or "" for column in dialect.columns])
    for row in zip(*shown, strict=True):
        fields = [_field(column, value) for column, value in zip(dialect.columns, row, strict=True)]
        yield _line(dialect, fields)


def _field(column: Column, value: object) -> str:
    if column.form is None:
        return str(value)
    text = format(float(str(value)) * column.scale, column.form)
    if column.trimmed and "." in text:
        text = text.rstrip("0").rstrip(".")
    # Instruments do not print a negative zero.
    return text.lstrip("-") if not any(digit in text for digit in "123456789") else text


def _line(dialect: Dialect, fields: Sequence[str]) -> bytes:
    special = (dialect.delimiter, dialect.quote, "\r", "\n")
    quoted = [
        dialect.quote + text.replace(dialect.quote, 2 * dialect.quote) + dialect.quote
        if any(mark in text for mark in special)
        else text
        for text in fields
    ]
    return (dialect.delimiter.join(quoted) + dialect.line_end).encode(dialect.encoding)

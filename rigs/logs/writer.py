"""Writer of a table in a dialect.

The one writer of every log that is text. `headings` and `columns_of` give its parts, for sheets.
"""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

from knitlab_core.errors import SpecificationError
from rigs.logs.dialect import Fact, Form
from rigs.logs.units import factor

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigs.logs.dialect import Channels, Column, Dialect, Locale


def write_log(
    dialect: Dialect, parts: Iterable[Channels], facts: Mapping[str, object] | None = None
) -> Iterator[bytes]:
    r"""Yield the file line by line: preamble, headings, units where the dialect has them, one line a row.

    Parameters
    ----------
    dialect : Dialect
        The description.
    parts : iterable of mapping of str to sequence, each of length n
        Numbers in SI units, or texts, by the channel's name; one part of the log after the other.
    facts : mapping of str to object
        Numbers in SI units, texts and dates that the preamble shows; a line whose fact is None is left out.

    Yields
    ------
    bytes
        One line with its end.

    Raises
    ------
    SpecificationError
        If a channel or a fact is missing, or a channel not as long as the others.

    Examples
    --------
    >>> from rigs.logs.dialect import Column, Dialect
    >>> dialect = Dialect(name="d", columns=(Column(name="F_{unit}", channel="F", unit="mN", form=".1f"),))
    >>> list(write_log(dialect, [{"F": [0.0021]}]))
    [b'F_mN\r\n', b'2.1\r\n']
    """
    for line in headings(dialect, facts):
        yield _line(dialect, [_quoted(dialect, form, text) for form, text in line])
    for channels in parts:
        shown = [
            [_quoted(dialect, column, text) for text in texts(column, values, dialect.locale)]
            for column, values in zip(dialect.columns, columns_of(dialect, channels), strict=True)
        ]
        for row in zip(*shown, strict=True):
            yield _line(dialect, row)


def _line(dialect: Dialect, fields: Iterable[str]) -> bytes:
    return (dialect.delimiter.join(fields) + dialect.line_end).encode(dialect.encoding)


def headings(dialect: Dialect, facts: Mapping[str, object] | None = None) -> Iterator[list[tuple[Form, str]]]:
    """Yield the lines above the numbers field by field: how each is printed, and its text; as `write_log` does."""
    plain, known = Form(), {} if facts is None else facts
    for line in dialect.preamble:
        if any(isinstance(part, Fact) and known.get(part.fact, part) is None for part in line):
            continue
        yield [(plain, part) if isinstance(part, str) else (part, _fact(dialect, part, known)) for part in line]
    yield [(plain, column.name.format(unit=column.unit)) for column in dialect.columns]
    if any(column.below is not None for column in dialect.columns):
        yield [(plain, (column.below or "").format(unit=column.unit)) for column in dialect.columns]


def columns_of(dialect: Dialect, channels: Channels) -> list[Sequence[object]]:
    """Return what the columns of a dialect show of a part of a log, each of one length."""
    shown = [_channel(dialect, column, channels) for column in dialect.columns]
    if len({len(values) for values in shown}) != 1:
        raise SpecificationError(f"log.{dialect.name}", [len(values) for values in shown], "channels of one length")
    return shown


def texts(form: Form, values: Sequence[object], locale: Locale) -> list[str]:
    """Return values as they are printed; what is the same again is printed once."""
    known: dict[object, str] = {}
    found = []
    for value in values:
        text = known.get(value)
        if text is None:
            text = known[value] = _text(form, value, locale)
        found.append(text)
    return found


def _channel(dialect: Dialect, column: Column, channels: Mapping[str, Sequence[object]]) -> Sequence[object]:
    if column.channel not in channels:
        expected = f"a channel {column.channel!r} for column {column.name!r}"
        raise SpecificationError(f"log.{dialect.name}", sorted(channels), expected)
    return channels[column.channel]


def _fact(dialect: Dialect, part: Fact, facts: Mapping[str, object]) -> str:
    if part.fact not in facts:
        raise SpecificationError(f"log.{dialect.name}", sorted(facts), f"a fact {part.fact!r}")
    return _text(part, facts[part.fact], dialect.locale)


def _text(form: Form, value: object, locale: Locale) -> str:
    if isinstance(value, datetime):
        return locale.date(value)
    if form.form is None:
        return str(value)
    text = format((value if isinstance(value, float) else float(str(value))) * factor(form.unit), form.form)
    if form.trimmed and "." in text:
        text = text.rstrip("0").rstrip(".")
    # Instruments do not print a negative zero.
    text = text.lstrip("-") if text.startswith("-") and not any(digit in text for digit in "123456789") else text
    return text.translate({ord("."): locale.decimal, ord(","): locale.thousands})


def _quoted(dialect: Dialect, form: Form, text: str) -> str:
    if form.quoted or any(mark in text for mark in (dialect.delimiter, dialect.quote, "\r", "\n")):
        return dialect.quote + text.replace(dialect.quote, 2 * dialect.quote) + dialect.quote
    return text

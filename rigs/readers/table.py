"""Table of a measured file: its headings and units, wherever they stand, and its columns in SI units."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import chain, islice
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import FormatError
from rigs.readers.headings import DIMENSIONS, Heading, by_unit, factor_to_si, is_force, meaning, unit_below
from rigs.readers.layouts import layout_of
from rigs.readers.numbers import decimal_of, number
from rigs.readers.source import is_number, read_lines

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigs.axes import FloatArray
    from rigs.readers.source import Line

LOOKED_AT: Final = 200
"""Lines within which the headings are looked for."""

_PART: Final = r"(?:.* : )?"
_GAUGE: Final = re.compile(rf"{_PART}(?:length|.*ga(?:u)?ge length.*|messlänge|einspannlänge|l0)", re.IGNORECASE)
_AREA: Final = re.compile(rf"{_PART}(?:area|cross-section(?:al area)?|querschnitt(?:sfläche)?)", re.IGNORECASE)
_WIDTH: Final = re.compile(rf"{_PART}(?:width|breite)", re.IGNORECASE)
_THICKNESS: Final = re.compile(rf"{_PART}(?:thickness|dicke)", re.IGNORECASE)
_LABEL: Final = re.compile(rf"{_PART}(?:specimen (?:label|id)|proben-?(?:beschriftung|name)|probe)", re.IGNORECASE)
_AREAS: Final = {"mm^2": 1e-6, "mm²": 1e-6, "mm2": 1e-6, "cm^2": 1e-4, "cm²": 1e-4, "m^2": 1.0}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadColumn:
    """Column of a file.

    Attributes
    ----------
    heading : Heading
        What it means.
    values : FloatArray, shape (n,)
        Numbers in SI units; ``nan`` where a field is empty, or the column is one of texts.
    texts : tuple of str, length n
        The fields as they stand in the file.
    """

    heading: Heading
    values: FloatArray
    texts: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadTable:
    """Table of a file.

    Attributes
    ----------
    columns : tuple of ReadColumn
        In their order.
    label : str
        What the file calls its specimen; empty if it does not.
    gauge_length, area : float
        Gauge length [m] and section [m²] that the lines above the table give; ``nan`` if they do not. It is given
        as an area, or as width and thickness.
    lines : tuple of int, length n
        Line of the file of each row.
    """

    columns: tuple[ReadColumn, ...]
    label: str
    gauge_length: float
    area: float
    lines: tuple[int, ...]


def read_table(
    path: Path,
    *,
    delimiter: str | None = None,
    decimal: str | None = None,
    headings: Mapping[str, Heading] | None = None,
) -> ReadTable:
    """Read the table of a measured file.

    Parameters
    ----------
    path : Path
        Text or workbook.
    delimiter, decimal : str or None
        What stands between fields and before decimals; None to tell it from the file.
    headings : mapping of str to Heading, optional
        What headings mean that do not say so themselves: by their text, or of a file without headings by the column's
        number, from ``1``. A unit that is not given is that of the file.

    Raises
    ------
    FormatError
        With the line, and the column where there is one, if the file is not such a table.
    """
    lines, between = read_lines(path, delimiter)
    given = headings or {}
    named = _heading_line(lines, given)
    columns = _layout(lines, given, path, between) if named is None else _meanings(path, lines[named], given)
    body = lines if named is None else lines[named + 1 :]
    body, columns = _units_below(body, columns, path)
    header = None if named is None else lines[named].fields
    rows = [line for line in body if not _is_repeated(line, header, columns)]
    if not rows:
        raise FormatError(path, lines[-1].number if lines else 1, "rows of numbers below the headings")
    _require_width(path, rows, len(columns))
    mark = decimal or decimal_of(chain.from_iterable(line.fields for line in islice(rows, 2000)), between)
    above = [] if named is None else lines[:named]
    return ReadTable(
        columns=tuple(_column(path, rows, k, heading, mark) for k, heading in enumerate(columns)),
        label=_fact(above, _LABEL),
        gauge_length=_length(above, _GAUGE, mark),
        area=_area(above, mark),
        lines=tuple(line.number for line in rows),
    )


def _heading_line(lines: Sequence[Line], given: Mapping[str, Heading]) -> int | None:
    """Return the line of the headings: the first with two or more that are known, or else one above units.

    None if there is no such line; one with a number is none.
    """
    texts = [k for k, line in enumerate(lines[:LOOKED_AT]) if not any(map(is_number, line.fields))]
    for k in texts:
        if sum(field in given or meaning(field).quantity != "other" for field in lines[k].fields) > 1:
            return k
    return next((k for k in texts if _is_above_units(lines, k)), None)


def _is_above_units(lines: Sequence[Line], k: int) -> bool:
    """Return whether the line below is one of as many units, a force among them, in brackets."""
    below = lines[k + 1].fields if k + 1 < len(lines) else []
    units = [unit_below(field) for field in below]
    bracketed = all(not field or field[0] in "([" for field in below)
    return bracketed and len(below) == len(lines[k].fields) > 1 and any(unit and is_force(unit) for unit in units)


def _meanings(path: Path, line: Line, given: Mapping[str, Heading]) -> list[Heading]:
    missing = [name for name in given if name not in line.fields]
    if missing:
        raise FormatError(
            path, line.number, f"a column {missing[0]!r}, as the mapping says; found {', '.join(line.fields)}"
        )
    return [
        replace(given[field], text=field, unit=given[field].unit or meaning(field).unit)
        if field in given
        else meaning(field)
        for field in line.fields
    ]


def _layout(lines: Sequence[Line], given: Mapping[str, Heading], path: Path, between: str) -> list[Heading]:
    """Return what the columns of a file without headings mean: by a mapping by number, or as a dialect of our logs."""
    if not lines:
        raise FormatError(path, 1, "a table of numbers, but the file is empty")
    width = len(lines[0].fields)
    if given:
        wrong = [name for name in given if not name.isdigit() or not 1 <= int(name) <= width]
        if wrong:
            raise FormatError(path, lines[0].number, f"a heading {wrong[0]!r}, or columns by number, 1 to {width}")
        return [given.get(str(k), Heading(text=str(k), quantity="other")) for k in range(1, width + 1)]
    found = layout_of([line.fields for line in lines[:LOOKED_AT]], between)
    if found is None:
        wanted = (
            "headings with time, displacement or force, a dialect of knitlab, or a mapping of the columns (--mapping)"
        )
        raise FormatError(path, lines[0].number, wanted)
    return [meaning(text) if not unit else replace(meaning(text), unit=unit) for text, unit in found]


def _units_below(body: list[Line], columns: list[Heading], path: Path) -> tuple[list[Line], list[Heading]]:
    """Return the rows below a line of units, and the headings with those; every unit must be known then."""
    first = body[0] if body else None
    if first is not None and len(first.fields) == len(columns) and not any(map(is_number, first.fields)):
        units = [unit_below(field) for field in first.fields]
        if any(units) and all(unit is not None for unit in units):
            known: list[Heading] = []
            taken = {one.quantity for one in columns}
            for one, unit in zip(columns, units, strict=True):
                known.append(by_unit(one, unit or "", taken))
                taken.add(known[-1].quantity)
            columns, body = known, body[1:]
    for k, heading in enumerate(columns):
        if heading.quantity in DIMENSIONS and heading.unit and factor_to_si(heading.quantity, heading.unit) is None:
            line = first.number if first else 1
            allowed = f"a unit of {DIMENSIONS[heading.quantity]} in column {k + 1} ({heading.text})"
            raise FormatError(path, line, f"{allowed}, found {heading.unit!r}")
    return body, columns


def _is_repeated(line: Line, header: list[str] | None, columns: Sequence[Heading]) -> bool:
    """Return whether a line repeats the headings, or the units below them."""
    if line.fields == header:
        return True
    return (
        header is not None
        and not any(map(is_number, line.fields))
        and all(
            unit_below(field) in {None, "", heading.unit} and unit_below(field) is not None
            for field, heading in zip(line.fields, columns, strict=False)
        )
        and any(line.fields)
    )


def _require_width(path: Path, rows: Sequence[Line], width: int) -> None:
    for line in rows:
        extra = line.fields[width:]
        if len(line.fields) < width or any(extra):
            raise FormatError(path, line.number, f"{width} columns, found {len(line.fields)}")


def _column(path: Path, rows: Sequence[Line], place: int, heading: Heading, decimal: str) -> ReadColumn:
    texts = tuple(line.fields[place] for line in rows)
    if heading.quantity in {"other", "phase"} or (heading.quantity == "cycle" and "-" in texts[0]):
        values = [value if (value := number(text, decimal)) is not None else float("nan") for text in texts]
        return ReadColumn(heading=heading, values=np.array(values), texts=texts)
    found = []
    for line, text in zip(rows, texts, strict=True):
        value = number(text, decimal)
        if value is None:
            where = f"in column {place + 1} ({heading.text})"
            raise FormatError(path, line.number, f"a number {where}, found {text[:40]!r}")
        found.append(value)
    factor = factor_to_si(heading.quantity, heading.unit) if heading.unit else 1.0
    return ReadColumn(heading=heading, values=np.array(found) * (1.0 if factor is None else factor), texts=texts)


def _fact(above: Sequence[Line], pattern: re.Pattern[str]) -> str:
    found = (line.fields[1] for line in above if len(line.fields) > 1 and pattern.fullmatch(line.fields[0]))
    return next(found, "")


def _length(above: Sequence[Line], pattern: re.Pattern[str], decimal: str) -> float:
    """Return the length of a line such as ``Dimension : Length, 45.0, mm`` [m]; nan if there is none."""
    return next(_values(above, pattern, decimal, lambda unit: factor_to_si("travel", unit)), float("nan"))


def _area(above: Sequence[Line], decimal: str) -> float:
    """Return the section that is given as an area, or as width and thickness [m²]; nan if it is not."""
    sides = _length(above, _WIDTH, decimal) * _length(above, _THICKNESS, decimal)
    return next(_values(above, _AREA, decimal, _AREAS.get), sides)


def _values(
    above: Sequence[Line], pattern: re.Pattern[str], decimal: str, factor_of: Callable[[str], float | None]
) -> Iterator[float]:
    """Yield the values of lines of a name, a number and a unit, in SI units."""
    for line in above:
        if len(line.fields) > 2 and pattern.fullmatch(line.fields[0]):
            value, factor = number(line.fields[1], decimal), factor_of(line.fields[2].strip("()[]"))
            if value is not None and factor is not None:
                yield value * factor

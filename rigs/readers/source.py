"""Files as lines of fields: text in any usual encoding between commas, semicolons or tabs, and workbooks."""

from __future__ import annotations

import codecs
import csv
import io
from dataclasses import dataclass
from itertools import chain, islice
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import FormatError, SpecificationError
from rigs.readers.numbers import PATTERNS, number

if TYPE_CHECKING:
    from pathlib import Path

DELIMITERS: Final = ("\t", ";", ",")
"""In the order in which they are looked for: where the comma marks decimals another one stands between fields."""

SHEETS: Final = (".xlsx", ".xlsm")
LOOKED_AT: Final = 400
"""Lines by which the delimiter is told."""

_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


@dataclass(frozen=True, slots=True)
class Line:
    """Line of a file: its number, from 1, and its fields."""

    number: int
    fields: list[str]


def read_lines(path: Path, delimiter: str | None = None) -> tuple[list[Line], str]:
    """Return the lines of a file that are not blank, and what stands between their fields.

    Parameters
    ----------
    path : Path
        Text, or a workbook, of which the first sheet is read.
    delimiter : str or None
        What stands between fields; None to tell it from the file.

    Raises
    ------
    FormatError
        If it is no text, or a quote is not closed.
    SpecificationError
        If it is a workbook and openpyxl is not installed.
    OSError
        If it cannot be read.
    """
    if path.suffix.lower() in SHEETS:
        return _sheet_lines(path), "\t"
    text = decoded(path.read_bytes(), path)
    between = delimiter_of(text) if delimiter is None else delimiter
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=between, strict=True)
    found: list[Line] = []
    try:
        found.extend(Line(reader.line_num, [field.strip() for field in fields]) for fields in reader)
    except csv.Error as error:
        raise FormatError(path, reader.line_num, f"fields between {between!r}, but {error}") from error
    return [line for line in found if any(line.fields)], between


def decoded(data: bytes, path: Path | str = "file") -> str:
    r"""Return the text of a file: by its byte-order mark, as UTF-8, or else as Windows-1252.

    Examples
    --------
    >>> decoded(b"\xef\xbb\xbfTime"), decoded("µm".encode("cp1252")), decoded("N".encode("utf-16"))
    ('Time', 'µm', 'N')
    """
    marked = next((encoding for mark, encoding in _MARKS if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(marked)
    except UnicodeDecodeError:
        text = _decoded(data, marked if marked != "utf-8" else "cp1252", path)
    if "\0" in text:
        raise FormatError(path, text[: text.index("\0")].count("\n") + 1, "text, but a byte 0x00 is none")
    return text


def _decoded(data: bytes, encoding: str, path: Path | str) -> str:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise FormatError(path, line, f"text, but byte 0x{data[error.start]:02x} is none in {encoding}") from error


def delimiter_of(text: str) -> str:
    r"""Return what stands between the fields: that with which most of them are numbers.

    Examples
    --------
    >>> delimiter_of("Zeit;Kraft\n0,1;2,5\n"), delimiter_of("Time,Load\n0.1,2.5\n"), delimiter_of("a;b,1,2\n")
    (';', ',', ',')
    """
    lines = [line for line in islice(io.StringIO(text, newline=""), LOOKED_AT) if line.strip()]

    def fields(mark: str) -> tuple[int, int]:
        try:
            numbers = sum(map(is_number, chain.from_iterable(csv.reader(lines, delimiter=mark))))
        except csv.Error:  # a field without end: who reads the lines says where
            numbers = 0
        return numbers, sum(mark in line for line in lines)

    return max(DELIMITERS, key=fields)


def is_number(field: str) -> bool:
    """Return whether a field shows a number in any country."""
    text = field.strip()
    return bool(text) and any(number(text, mark) is not None for mark in PATTERNS)


def _sheet_lines(path: Path) -> list[Line]:
    try:
        import openpyxl  # noqa: PLC0415 (optional)
    except ImportError as error:
        raise SpecificationError("openpyxl", "not installed", "pip install 'knitlab[tables]' for workbooks") from error
    from zipfile import BadZipFile  # noqa: PLC0415

    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    except (BadZipFile, KeyError, ValueError, openpyxl.utils.exceptions.InvalidFileException) as error:
        raise FormatError(path, 1, f"a workbook that can be read, but {error}") from error
    with_numbers = enumerate(book.worksheets[0].iter_rows(values_only=True), start=1)
    lines = [Line(number, ["" if cell is None else str(cell).strip() for cell in row]) for number, row in with_numbers]
    book.close()
    return [line for line in lines if any(line.fields)]

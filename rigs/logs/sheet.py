"""Write a table as a workbook of one sheet."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Final

from xlsxwriter import Workbook

from knitlab_core.errors import SpecificationError
from rigs.logs.writer import columns_of, headings

if TYPE_CHECKING:
    from collections.abc import Iterable
    from datetime import datetime

    from rigs.logs.dialect import Channels, Dialect

MOST_LINES: Final = 1_048_576
"""Lines of a sheet."""


def write_sheet(dialect: Dialect, parts: Iterable[Channels], created: datetime) -> bytes:
    """Return a workbook with one sheet: a line of headings, one line a row; texts as texts, numbers as numbers.

    Parameters
    ----------
    dialect : Dialect
        Gives the columns.
    parts : iterable of mapping of str to sequence, each of length n
        Texts, and numbers in the columns' units, by the channel's name; one part of the log after the other.
    created : datetime
        When the test began, which the file says of itself; the same run gives the same bytes.

    Raises
    ------
    SpecificationError
        If a sheet has not so many lines.
    """
    stream = io.BytesIO()
    # Rows go to a temporary file as they are written; texts are then in their cells and not in a table of all.
    book = Workbook(stream, {"constant_memory": True})
    book.set_properties({"created": created.replace(tzinfo=None)})
    sheet = book.add_worksheet()
    (names,) = headings(dialect)
    for column, (_, text) in enumerate(names):
        sheet.write_string(0, column, text)
    row = 1
    for channels in parts:
        shown = columns_of(dialect, channels)
        if row + len(shown[0]) > MOST_LINES:
            raise SpecificationError(f"log.{dialect.name}", "more", f"{MOST_LINES - 1} rows or fewer in a workbook")
        for number, line in enumerate(zip(*shown, strict=True), start=row):
            for column, value in enumerate(line):
                if isinstance(value, str):
                    sheet.write_string(number, column, value)
                else:
                    sheet.write_number(number, column, float(str(value)))
        row += len(shown[0])
    book.close()
    return stream.getvalue()

"""Write a table as a workbook of one sheet."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from xlsxwriter import Workbook

from rigs.logs.writer import cells

if TYPE_CHECKING:
    from datetime import datetime

    from rigs.logs.logged import Channels
    from rigs.logs.writer import Dialect


def write_sheet(dialect: Dialect, channels: Channels, created: datetime) -> bytes:
    """Return a workbook with one sheet: a line of headings, one line a row; texts as texts, numbers as numbers.

    Parameters
    ----------
    dialect : Dialect
        Gives the columns.
    channels : mapping of str to sequence, each of length n
        Texts, and numbers in the columns' units, by the channel's name.
    created : datetime
        When the test began, which the file says of itself; the same run gives the same bytes.
    """
    stream = io.BytesIO()
    book = Workbook(stream, {"in_memory": True})
    book.set_properties({"created": created.replace(tzinfo=None)})
    sheet = book.add_worksheet()
    headings, *_ = cells(dialect, dict.fromkeys(channels, ()))
    for column, (_, text) in enumerate(headings):
        sheet.write_string(0, column, text)
        shown = channels[dialect.columns[column].channel]
        for row, value in enumerate(shown, start=1):
            if isinstance(value, str):
                sheet.write_string(row, column, value)
            else:
                sheet.write_number(row, column, float(str(value)))
    book.close()
    return stream.getvalue()

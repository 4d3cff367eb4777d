"""Tables of figures as files: CSV and Parquet."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING, Any, Final

from app.records.folder import whole_file, write_whole
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigs.analysis.table import Cell, Table

SUFFIXES: Final = (".csv", ".parquet")


def write_table(table: Table, path: Path) -> Path:
    """Write a table as CSV or Parquet, by the suffix of the file, atomically.

    Numbers have all their digits; in CSV ``nan`` is an empty field.

    Raises
    ------
    SpecificationError
        If the suffix is another, or Parquet is asked for and pyarrow is not installed.
    """
    if path.suffix not in SUFFIXES:
        raise SpecificationError("--out", path.name, f"a file that ends with {' or '.join(SUFFIXES)}")
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".csv":
        return write_whole(path, _csv_lines(table))
    arrow, parquet = _arrow()
    with whole_file(path) as temporary:
        columns = dict(zip(table.headings(), table.columns.values(), strict=True))
        parquet.write_table(arrow.table({name: list(values) for name, values in columns.items()}), temporary)
    return path


def _csv_lines(table: Table) -> Iterator[bytes]:
    for line in (table.headings(), *([_shown(cell) for cell in row] for row in table.rows())):
        buffer = io.StringIO()
        csv.writer(buffer, lineterminator="\n").writerow(line)
        yield buffer.getvalue().encode()


def _shown(cell: Cell) -> str:
    return "" if isinstance(cell, float) and cell != cell else str(cell)  # noqa: PLR0124 (nan is not itself)


def _arrow() -> tuple[Any, Any]:
    try:
        import pyarrow as pa  # noqa: PLC0415 (optional)
        from pyarrow import parquet as pq  # noqa: PLC0415
    except ImportError as error:
        raise SpecificationError("pyarrow", "not installed", "pip install 'knitlab[tables]' for Parquet") from error
    return pa, pq

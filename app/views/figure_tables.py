"""Tables of figures in a terminal, or as JSON."""

from __future__ import annotations

from itertools import islice
from math import isfinite
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Final

from rich.measure import Measurement
from rich.table import Table

from app.views.labels import shortened
from app.views.tables import console_of, print_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.analysis.table import Cell
    from rigs.analysis.table import Table as Figures

_MOST_ROWS: Final = 60
PIVOTED: Final = ("results", "comparison")
"""Tables of one figure a row."""

_TURNED: Final = 6
"""Rows up to which a table that is too wide is turned on its side."""


def print_table(found: Figures, *, as_json: bool) -> None:
    """Print a table of figures: its first rows in a terminal, all of them as JSON, ``nan`` as null."""
    if as_json:
        rows = [[_plain(cell) for cell in row] for row in found.rows()]
        print_json({"table": found.name, "columns": found.headings(), "rows": rows})
        return
    if found.name in PIVOTED:
        _print_figures(found, spread=found.name == "results")
        return
    kept = [
        k for k, column in enumerate(found.columns.values()) if any(cell != "" for cell in column) or not len(found)
    ]
    heads = [found.headings()[k] for k in kept]
    rows_shown = [[_shown(row[k]) for k in kept] for row in islice(found.rows(), _MOST_ROWS)]
    table = _table(heads, rows_shown)
    if _width(table) > console_of().width and len(found) <= _TURNED:
        table = _table(
            ["", *map(str, range(1, len(rows_shown) + 1))],
            [list(line) for line in zip(heads, *rows_shown, strict=True)],
        )
    _print(table)
    if len(found) > _MOST_ROWS:
        console_of().print(f"... and {len(found) - _MOST_ROWS} rows more: --out writes them all")


def _print_figures(found: Figures, *, spread: bool) -> None:
    """Print figures as frames do: a row a figure, a column a specimen, then mean and standard deviation."""
    names = list(dict.fromkeys(map(str, found.columns["name"])))
    values: dict[tuple[Cell, Cell, Cell, Cell], dict[str, float]] = {}
    for name, axis, cycle, figure, value, unit, *_ in found.rows():
        values.setdefault((axis, cycle, figure, unit), {})[str(name)] = float(value)
    # Repeats of one file are told apart by what follows its name.
    files = {name.rpartition(", ")[0] for name in names}
    shown = [name.rpartition(", ")[2] for name in names] if len(files) == 1 else names
    rows = [
        [
            *map(str, (axis, cycle or "", figure)),
            *(_shown(of.get(name, float("nan"))) for name in names),
            *(_spread(of) if spread and len(names) > 1 else []),
            str(unit),
        ]
        for (axis, cycle, figure, unit), of in values.items()
    ]
    _print(
        _table(
            [
                "axis",
                "cycle",
                "figure",
                *map(shortened, shown),
                *(["mean", "deviation"] if spread and len(names) > 1 else []),
                "unit",
            ],
            rows,
        )
    )


def _spread(of: dict[str, float]) -> list[str]:
    """Return mean and sample standard deviation of a figure; of a single one there is no deviation."""
    values = list(of.values())
    return [_shown(fmean(values)), _shown(stdev(values)) if len(values) > 1 else ""]


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table()
    for heading in headings:
        table.add_column(heading, no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


def _width(table: Table) -> int:
    console = console_of()
    return Measurement.get(console, console.options.update(width=10_000), table).maximum


def _print(table: Table) -> None:
    """Print a table with whole lines, longer than the terminal where it must be."""
    console = console_of()
    console.width = max(console.width, _width(table))
    console.print(table, soft_wrap=True)


def _plain(cell: Cell) -> Cell | None:
    return None if isinstance(cell, float) and not isfinite(cell) else cell


def _shown(cell: Cell) -> str:
    """Return a cell as text; four digits of a number, nothing of one that is not known."""
    if isinstance(cell, float):
        return f"{cell:.4g}" if isfinite(cell) else ""
    return str(cell)

"""Points of a sweep and what they came to, as a table and as CSV."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from dataclasses import dataclass
from math import isnan, nan
from typing import TYPE_CHECKING, Final

from rigs.analysis.table import Table

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from app.records.results import Figure
    from app.schemas.sweep import Point, Scalar
    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.analysis.table import Cell
    from rigs.record import End

_QUANTITY: Final = re.compile(r"[+-]?\.?\d[\d.]*(?:[eE][+-]?\d+)?\s*[A-Za-zµμ%°]*(?:\s*/\s*[A-Za-zµμ]+)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class PointResult:
    """How one point of a sweep ended.

    Attributes
    ----------
    point : Point
        Its values and label.
    folder : Path
        Its run folder.
    outcome : End
        How it ended.
    message : str
        One line for the user; empty when there is nothing to add.
    figures : tuple of (name, value, unit)
        What it came to.
    skipped : bool
        Whether it had been run before.
    crossings : tuple of LimitCrossing
        Where a fibre passed a limit of its material.
    losses : tuple of ClaspLoss
        Where clasps let go.
    """

    point: Point
    folder: Path
    outcome: End
    message: str
    figures: tuple[Figure, ...]
    skipped: bool
    crossings: tuple[LimitCrossing, ...] = ()
    losses: tuple[ClaspLoss, ...] = ()


def sweep_table(points: Sequence[PointResult]) -> Table:
    """Return a row for every point: values, outcome, every figure of any point; ``nan`` where it has none."""
    every = dict.fromkeys((name, unit) for point in points for name, _, unit in point.figures)
    columns: dict[str, list[Cell]] = {"point": [one.point.label for one in points]}
    for name in points[0].point.values if points else ():
        key = f"{name} (parameter)" if name in {"point", "outcome", "message"} else name
        columns[key] = [one.point.values[name] for one in points]
    columns["outcome"] = [one.outcome for one in points]
    columns["message"] = [one.message for one in points]
    found = [{(name, unit): value for name, value, unit in one.figures} for one in points]
    units = {}
    for name, unit in every:
        key = f"{name} (figure)" if name in columns else name
        columns[key], units[key] = [figures.get((name, unit), nan) for figures in found], unit
    return Table(name="sweep", columns=columns, units=units)


def as_csv(table: Table) -> str:
    """Return a table of points as CSV; texts of users are no formulas, and what is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(table.headings())
    for label, *row in table.rows():
        cells = ["" if isinstance(value, float) and isnan(value) else safe_cell(value) for value in row]
        writer.writerow([label, *cells])
    return text.getvalue()


def safe_cell(value: Scalar) -> Scalar:
    """Return a value as a cell that no spreadsheet evaluates as a formula; a negative quantity is none."""
    if not isinstance(value, str) or _QUANTITY.fullmatch(value):
        return value
    return f"'{value}" if unicodedata.normalize("NFKC", value).lstrip().startswith(("=", "+", "-", "@")) else value

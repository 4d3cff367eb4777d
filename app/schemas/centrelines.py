"""Read a centreline from CSV, and write one.

    x [mm], y [mm], z [mm], site
    -4.0, -6.4, 2.0, course-
    -3.87, -6.39, 1.98,

One row a point, in the order of the yarn; units are in the header, or once as ``unit`` in the protocol. ``l`` is the
loop width. Columns ``site`` and ``strand`` may be left out.
"""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING, Final

from app.schemas.errors import ProtocolError, Spot, nearest, shown
from app.schemas.units import parse
from knitlab_core.errors import UnitError
from knitlab_core.knits.own_centreline import MOST_POINTS, SITE_SETS, OwnCentreline

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from knitlab_core.knits import SiteSet

LOOP_WIDTHS: Final = "l"
"""Unit of a coordinate that is counted in loop widths."""

COLUMNS: Final = "x, y, z with their unit, such as x [mm], and if wanted site and strand"
_NAMES: Final = ("x", "y", "z", "site", "strand")


class _Table:
    """Place in a CSV, for errors."""

    def __init__(self, path: str, before: int) -> None:
        self.path, self.before = path, before

    def refuse(self, line: int, column: str, found: str, expected: str) -> ProtocolError:
        """Return an error on a line of the CSV, counted from 1."""
        return ProtocolError(self.path, Spot(line=self.before + line, column=1), column, found, expected)


def read_centreline(
    text: str, path: str, *, before: int, unit: str | None, loop_width: float, fibre_radius: float
) -> OwnCentreline:
    """Return the fabric of a CSV text.

    Parameters
    ----------
    text : str
        The CSV.
    path : str
        Its file, for errors.
    before : int
        Lines of that file before its first.
    unit : str, optional
        Unit of coordinates whose header names none.
    loop_width : float
        l [m].
    fibre_radius : float
        r [loop widths].

    Raises
    ------
    ProtocolError
        For what is wrong with a line, with file and line.
    """
    table = _Table(path, before)
    rows = csv.reader(io.StringIO(text), skipinitialspace=True)
    numbered = ((rows.line_num, row) for row in rows if any(cell.strip() for cell in row))
    try:
        columns, scales = _header(table, numbered, unit, loop_width)
        points, sites = _points(table, numbered, columns, scales)
    except csv.Error as error:
        raise table.refuse(rows.line_num, "centreline", f"text that is not CSV ({error})", "CSV") from error
    return OwnCentreline(points=tuple(points), sites=tuple(sites), fibre_radius=fibre_radius)


def written_centreline(fabric: OwnCentreline) -> str:
    """Return the CSV text of a centreline, in loop widths, to the last bit."""
    named = dict(fabric.sites)
    rows = [f"{x!r},{y!r},{z!r},{named.get(number, '')}" for number, (x, y, z) in enumerate(fabric.points)]
    header = ",".join([*(f"{name} [{LOOP_WIDTHS}]" for name in "xyz"), "site"])
    return "\n".join([header, *rows, ""])


def _header(
    table: _Table, numbered: Iterator[tuple[int, list[str]]], unit: str | None, loop_width: float
) -> tuple[Mapping[str, int], Mapping[str, float]]:
    """Return the place of each column, and what a number of x, y and z is multiplied by to be in loop widths."""
    line, cells = next(numbered, (1, []))
    columns: dict[str, int] = {}
    scales: dict[str, float] = {}
    for place, cell in enumerate(cells):
        name, _, own = (part.strip(" ]") for part in cell.partition("["))
        if name not in _NAMES or name in columns:
            again = "twice" if name in columns else f"as a column{nearest(name, _NAMES)}"
            raise table.refuse(line, "header", f"{shown(cell)} {again}", COLUMNS)
        columns[name] = place
        if name in {"x", "y", "z"}:
            scales[name] = _scale(table, line, name, own or unit or "", loop_width)
    missing = [name for name in "xyz" if name not in columns]
    if missing:
        raise table.refuse(line, "header", f"no column {missing[0]}", COLUMNS)
    return columns, scales


def _scale(table: _Table, line: int, name: str, unit: str, loop_width: float) -> float:
    """Return what a number of a unit is multiplied by to be in loop widths."""
    if unit == LOOP_WIDTHS:
        return 1.0
    try:
        return parse(f"1 {unit}", "length") / loop_width
    except UnitError as error:
        found = f"the unit {shown(unit)}" if unit else "no unit"
        raise table.refuse(line, name, found, f"a unit of length, such as {name} [mm], or l for loop widths") from error


def _points(
    table: _Table, numbered: Iterator[tuple[int, list[str]]], columns: Mapping[str, int], scales: Mapping[str, float]
) -> tuple[list[tuple[float, float, float]], list[tuple[int, SiteSet]]]:
    """Return the points [loop widths], and which of them are sites."""
    points: list[tuple[float, float, float]] = []
    sites: list[tuple[int, SiteSet]] = []
    strand: str | None = None
    for line, cells in numbered:
        if len(points) == MOST_POINTS:
            raise table.refuse(line, "centreline", "more points", f"{MOST_POINTS} points or fewer")
        if len(cells) < len(columns):
            raise table.refuse(line, "centreline", f"{len(cells)} values", f"{len(columns)}, one of each column")
        x, y, z = (_number(table, line, cells[columns[name]], name) * scales[name] for name in "xyz")
        named = cells[columns["site"]].strip() if "site" in columns else ""
        if named and named not in SITE_SETS:
            expected = f"{', '.join(SITE_SETS)} or nothing{nearest(named, SITE_SETS)}"
            raise table.refuse(line, "site", shown(named), expected)
        if named:
            sites.append((len(points), named))
        points.append((x, y, z))
        strand = _same_strand(table, line, cells, columns, strand)
    return points, sites


def _number(table: _Table, line: int, cell: str, column: str) -> float:
    """Return a coordinate as it is written."""
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise table.refuse(line, column, shown(cell.strip()), "a number")
    return number


def _same_strand(
    table: _Table, line: int, cells: Sequence[str], columns: Mapping[str, int], before: str | None
) -> str | None:
    """Return the strand of a row; a second one is refused."""
    if "strand" not in columns:
        return None
    strand = cells[columns["strand"]].strip()
    if before is not None and strand != before:
        raise table.refuse(line, "strand", f"a second strand, {shown(strand)}", "one: a knit here is of one yarn")
    return strand

"""Tables of waveforms and of yarn between plates: CSV files beside a protocol, put into its data as points.

The first line names two columns with their units, ``time (s),strain (%)`` or ``compression (mm),force (mN/mm)``; each
other line is a point.
"""

from __future__ import annotations

import csv
import math
import re
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from app.schemas.document import MAX_VALUES, dotted
from app.schemas.errors import ProtocolError, Spot, shown
from app.schemas.files_beside import TABLE
from app.schemas.step_parts import MEASURES
from app.schemas.units import parse
from knitlab_core.errors import SpecificationError, UnitError
from rigs.protocol.targets import require_level, require_time
from rigs.protocol.waveform import MOST_POINTS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from app.schemas.document import Data, Document, Place
    from app.schemas.errors import Faults
    from app.schemas.files_beside import FilesBeside, NamedText
    from app.schemas.units import Dimension
    from rigs.protocol.targets import Control

#: Values of a protocol with its tables: the record has them in one text, which is read with twice as many at most.
_MOST_VALUES: Final = MAX_VALUES // 2

_HEAD: Final = re.compile(r"\s*([a-z]+)\s*\(([^()]*)\)\s*")
_PLATES: Final = "compression (mm),force (mN/mm)"
_EXAMPLES: Final = {"strain": "%", "displacement": "mm", "force": "N"}


def with_tables(document: Document, data: Data, files: FilesBeside, faults: Faults) -> tuple[Data, tuple[str, ...]]:
    """Return the data of a protocol with points in the place of the tables that its waveforms and its yarn name.

    Parameters
    ----------
    document : Document
        The protocol's text.
    data : Data
        Its data, parameters replaced.
    files : FilesBeside
        The files that it may name.
    faults : Faults
        Takes what is wrong with a table.

    Returns
    -------
    data : Data
        A table with mistakes stays named, that of a yarn is replaced by other numbers.
    tables : tuple of str
        The tables that were put in.
    """
    work = _Inlining(document, files, faults)
    if not isinstance(data, dict):
        return data, ()
    made: dict[str, Data] = {**data}
    if isinstance(specimen := data.get("specimen"), dict):
        made["specimen"] = work.specimen(specimen)
    if isinstance(steps := data.get("steps"), list):
        made["steps"] = work.steps(steps, ("steps",))
    count = _count(made) if work.points else 0
    if count > _MOST_VALUES:
        found, expected = f"{count} values", f"{_MOST_VALUES} or fewer in a protocol with its tables, 3 for each row"
        faults.found.append(ProtocolError(document.path, document.spot(("steps",)), "steps", found, expected))
        return data, ()
    return made, tuple(work.points)


class _Inlining:
    """Read the tables that the yarn and steps name, also those inside `repeat`, each once."""

    def __init__(self, document: Document, files: FilesBeside, faults: Faults) -> None:
        self.document, self.files, self.faults = document, files, faults
        self.points: dict[str, Data] = {}

    def specimen(self, specimen: dict[str, Data]) -> Data:
        """Return the specimen, with the rows of the table that the compression of its yarn names."""
        yarn = specimen.get("yarn")
        law = yarn.get("compression") if isinstance(yarn, dict) else None
        table = law.get("table") if isinstance(law, dict) else None
        if not isinstance(yarn, dict) or not isinstance(law, dict) or not isinstance(table, str):
            return specimen
        place = ("specimen", "yarn", "compression", "table")
        rows = self.faults.of(lambda: self.read(table, rows_of, place), None)
        # A table with mistakes is replaced by numbers of a yarn, to find more of them.
        law = {"exponent": 2.0, "rigidity": "1 N/m"} if rows is None else {**law, "table": rows}
        return {**specimen, "yarn": {**yarn, "compression": law}}

    def steps(self, steps: list[Data], place: Place) -> list[Data]:
        """Return the steps of a list, those of repeats too."""
        return [self.step(step, (*place, number)) for number, step in enumerate(steps)]

    def step(self, step: Data, place: Place) -> Data:
        """Return one step."""
        if not isinstance(step, dict) or len(step) != 1:
            return step
        ((name, body),) = step.items()
        if not isinstance(body, dict):
            return step
        if name == "repeat" and isinstance(inner := body.get("steps"), list):
            return {name: {**body, "steps": self.steps(inner, (*place, name, "steps"))}}
        table, kind = body.get("table"), body.get("kind", "strain")
        if name != "waveform" or not isinstance(table, str) or "points" in body or kind not in MEASURES:
            return step
        read = partial(points_of, kind=kind)  # type: ignore[arg-type]
        points = self.faults.of(lambda: self.read(table, read, (*place, name, "table")), None)
        if points is None:
            return step
        rest = {key: value for key, value in body.items() if key != "table"}
        return {name: {**rest, "points": points}}

    def read(self, name: str, rows: Callable[[NamedText], list[Data]], place: Place) -> Data:
        """Return the points of a table."""
        if name not in self.points:
            try:
                table = self.files.read(name, TABLE)
            except ProtocolError:
                raise
            except SpecificationError as error:
                spot = self.document.spot(place)
                raise ProtocolError(
                    self.document.path, spot, dotted(place), shown(error.found), error.expected
                ) from error
            self.points[name] = rows(table)
        return self.points[name]


def points_of(table: NamedText, kind: Control) -> list[Data]:
    """Return the points of a table as a protocol has them: ``[["0.0 s", 0.05], ...]``, strains as pure numbers.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line with file, line and column.
    """
    path, rows = table.path, _lines_of(table, _head_of(kind))
    units = _units(path, *rows[0], (("time", "time"), (kind, MEASURES[kind])), _head_of(kind))
    points = [_point(path, line, cells, units, kind) for line, cells in rows[1:]]
    _require_rising(path, [line for line, _ in rows[1:]], [time for time, _ in points])
    return [[f"{time!r} s", value if kind == "strain" else f"{value!r} {_si(kind)}"] for time, value in points]


def rows_of(table: NamedText) -> list[Data]:
    """Return the rows of a table of a yarn between plates as a protocol has them: ``[["0.0001 m", "0.2 N/m"], ...]``.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line with file, line and column.
    """
    path, ((first, names), *lines) = table.path, _lines_of(table, _PLATES)
    units = _units(path, first, names, (("compression", "length"), ("force", "line force")), _PLATES)
    rows: list[Data] = []
    before = (-math.inf, -math.inf)
    for line, cells in lines:
        length, force = _numbers(path, line, cells, units, ("length", "line force"), "a compression and a force")
        for column, (value, last) in enumerate(zip((length, force), before, strict=True)):
            if not value > last:
                raise _refusal(path, line, cells, column, shown(cells[column].strip()), "more than in the row before")
        before = length, force
        rows.append([f"{length!r} m", f"{force!r} N/m"])
    return rows


def _lines_of(table: NamedText, head: str) -> list[tuple[int, list[str]]]:
    """Return the number and the cells of every line of a table that is not empty, its head among them."""
    path, text = table
    lines = csv.reader(text.splitlines())
    rows: list[tuple[int, list[str]]] = []
    try:
        for cells in lines:
            if cells:
                rows.append((lines.line_num, cells))
            if len(rows) > MOST_POINTS + 1:
                raise _refusal(path, lines.line_num, [], 0, "more", f"{MOST_POINTS} points or fewer")
    except csv.Error as error:
        raise _refusal(path, lines.line_num, [], 0, f"text that is not CSV ({error})", "CSV") from error
    if len(rows) < 3:
        found = "nothing" if not rows else f"{len(rows) - 1} points"
        raise _refusal(path, 1, [], 0, found, f"a head and two points or more, such as {head}")
    return rows


def _units(
    path: str, line: int, cells: list[str], wanted: Sequence[tuple[str, Dimension]], head: str
) -> tuple[str, str]:
    """Return the units of the two columns that the head of a table names."""
    if len(cells) != 2:
        raise _refusal(path, line, [], 0, f"{len(cells)} columns", f"two columns with their units: {head}")
    units = []
    for column, (cell, (name, dimension)) in enumerate(zip(cells, wanted, strict=True)):
        match = _HEAD.fullmatch(cell.lower() if column == 0 else cell)
        if match is None or match[1] != name or not _is_unit(match[2].strip(), dimension):
            example = head.split(",")[column]
            raise _refusal(path, line, cells, column, shown(cell.strip()), f"the name and the unit, such as {example}")
        units.append(match[2].strip())
    return units[0], units[1]


def _is_unit(unit: str, dimension: Dimension) -> bool:
    """Return whether a unit measures what a column has; a strain may have the unit 1."""
    try:
        _value(1.0, unit, dimension)
    except UnitError:
        return False
    return True


def _value(number: float, unit: str, dimension: Dimension) -> float:
    """Return a number of some unit in SI."""
    return parse(number if dimension == "strain" and unit == "1" else f"{number!r} {unit}", dimension)


def _point(path: str, line: int, cells: list[str], units: tuple[str, str], kind: Control) -> tuple[float, float]:
    """Return time [s] and level of a line."""
    time, value = _numbers(path, line, cells, units, ("time", MEASURES[kind]), "a time and a level")
    try:
        require_level(kind, value, kind)
        if time != 0.0:
            require_time("time", time)
    except SpecificationError as error:
        column = 0 if error.field == "time" else 1
        raise _refusal(path, line, cells, column, str(error.found), str(error.expected)) from error
    return time, value


def _numbers(
    path: str, line: int, cells: list[str], units: tuple[str, str], kinds: tuple[Dimension, Dimension], names: str
) -> tuple[float, float]:
    """Return the two numbers of a line in SI."""
    if len(cells) != 2:
        raise _refusal(path, line, [], 0, f"{len(cells)} columns", f"two: {names}")
    found = []
    for column, (cell, unit, kind) in enumerate(zip(cells, units, kinds, strict=True)):
        try:
            number = float(cell)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise _refusal(path, line, cells, column, shown(cell.strip()), f"a number, in {unit}")
        found.append(_value(number, unit, kind))
    first, second = found
    return first, second


def _require_rising(path: str, lines: list[int], times: list[float]) -> None:
    """Raise unless times rise strictly from 0."""
    if times[0] != 0.0:
        raise _refusal(path, lines[0], [], 0, f"{times[0]:g} s", "0 s: the step begins there")
    for line, (before, time) in zip(lines[1:], pairwise(times), strict=True):
        if time <= before:
            raise _refusal(path, line, [], 0, f"{time:g} s", f"a time above {before:g} s, that before it")


def _refusal(path: str, line: int, cells: list[str], column: int, found: str, expected: str) -> ProtocolError:
    """Return an error at a cell of a table."""
    spot = Spot(line=max(line, 1), column=1 + sum(len(cell) + 1 for cell in cells[:column]))
    return ProtocolError(path, spot, "table", found, expected)


def _head_of(kind: Control) -> str:
    """Return a head that a table may have."""
    return f"time (s),{kind} ({_EXAMPLES[kind]})"


def _si(kind: Control) -> str:
    """Return the SI unit of a level."""
    return "m" if kind == "displacement" else "N"


def _count(data: Data) -> int:
    """Count the values of data as the reader of a protocol does [1]."""
    inner = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return 1 + sum(_count(one) for one in inner)

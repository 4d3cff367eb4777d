"""Measured files as measurements: one for each axis and repeat."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import FormatError
from rigs.analysis.branches import strokes_of
from rigs.logs.strokes import OUTWARD
from rigs.measurement import Measurement
from rigs.readers.headings import DIMENSIONS
from rigs.readers.mapping import FileMapping
from rigs.readers.table import read_table
from rigs.record import PHASES

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import FloatArray, IntArray
    from rigs.readers.headings import Quantity
    from rigs.readers.table import ReadColumn, ReadTable
    from rigs.record import Phase

PLAIN: Final = FileMapping()
MOST_REPEATS: Final = 1000
"""Repeats of one file; more are a column of another kind."""
_CYCLE: Final = re.compile(r"(\d+)-(\w+)")
_UNNEEDED: Final = {"time", "strain"}
"""Quantities whose unit need not be said: s and 1."""


def read_measured(path: Path, mapping: FileMapping = PLAIN) -> list[Measurement]:
    """Read a measured file.

    Parameters
    ----------
    path : Path
        The file: text or a workbook.
    mapping : FileMapping
        What the file does not say itself.

    Returns
    -------
    list of Measurement
        One for each axis and repeat of the file. Travel counts from the first row where the file gives distances;
        strain is that of the file, or travel over gauge length; stress that of the file, or force over the section.
        Cycles and phases are those of the file, or told from the turns of the travel.

    Raises
    ------
    FormatError
        With the line, and the column where there is one, if the file is no such table, has no force, no travel or
        strain, or a column without a unit.
    """
    table = read_table(path, delimiter=mapping.delimiter, decimal=mapping.decimal, headings=mapping.headings)
    _require_units(path, table)
    axes = _axes(table)
    if not axes:
        raise FormatError(path, table.lines[0], f"a column of force among {', '.join(_shown(table))}")
    name = table.label or path.stem
    repeat = _of(table, "repeat", "")
    numbers = np.ones(len(table.lines)) if repeat is None else repeat.values
    found = []
    repeats = np.unique(numbers)
    if len(repeats) > MOST_REPEATS:
        raise FormatError(
            path, table.lines[0], f"at most {MOST_REPEATS} repeats in a column of them, not {len(repeats)}"
        )
    for axis in axes:
        for number in repeats:
            rows = np.flatnonzero(numbers == number)
            label = name if repeat is None else f"{name}, repeat {number:g}"
            found.append(_measurement(path, table, rows, axis, label, mapping))
    return found


def _shown(table: ReadTable) -> list[str]:
    return [column.heading.text for column in table.columns]


def _require_units(path: Path, table: ReadTable) -> None:
    # An indenter's files say no unit: they are in SI, with prefixes.
    if any(column.heading.text.startswith("Corrected ") for column in table.columns):
        return
    for k, column in enumerate(table.columns):
        heading = column.heading
        if heading.quantity in DIMENSIONS and not heading.unit and heading.quantity not in _UNNEEDED:
            where = f"column {k + 1} ({heading.text})"
            wanted = f"the unit of {where}, in its heading, the line below or a mapping (--mapping)"
            raise FormatError(path, max(table.lines[0] - 1, 1), wanted)


def _axes(table: ReadTable) -> list[str]:
    """Return the axes along which a file has forces, in their order."""
    return list(dict.fromkeys(one.heading.axis for one in table.columns if one.heading.quantity == "force"))


def _of(table: ReadTable, quantity: Quantity, axis: str) -> ReadColumn | None:
    """Return the first column of a quantity along an axis; one that names no axis belongs to all."""
    fitting = [one for one in table.columns if one.heading.quantity == quantity]
    own = [one for one in fitting if one.heading.axis == axis]
    return next(iter(own or [one for one in fitting if not one.heading.axis]), None)


def _measurement(
    path: Path, table: ReadTable, rows: IntArray, axis: str, name: str, mapping: FileMapping
) -> Measurement:
    def values(quantity: Quantity) -> FloatArray | None:
        column = _of(table, quantity, axis)
        return None if column is None else column.values[rows]

    force, distance, travel = _force(table, axis)[rows], values("distance"), values("travel")
    strain, stress, width = values("strain"), values("stress"), values("width")
    gauge = mapping.gauge_length
    if np.isnan(gauge):
        gauge = table.gauge_length if distance is None else float(distance[0])
    if travel is None and distance is not None:
        travel = distance - gauge
    if travel is None and strain is not None:
        travel = strain * gauge
    if travel is None:
        beside = f" along {axis}" if axis else ""
        raise FormatError(path, table.lines[0], f"a column of displacement beside that of force{beside}")
    nothing = np.full(len(rows), np.nan)
    section = _section(table, axis, mapping)
    time = values("time")
    # Of a strain without travel the turns are those of the strain.
    cycle, phase = _strokes(table, rows, travel if np.isfinite(travel).all() or strain is None else strain)
    return Measurement(
        name=name,
        axis=axis or mapping.axis,
        time=nothing if time is None else time,
        travel=travel,
        force=force,
        strain=travel / gauge if strain is None or mapping.gauge_length > 0.0 else strain,
        stress=force / section if stress is None or mapping.width > 0.0 else stress,
        transverse=nothing if width is None else width / width[0] - 1.0,
        cycle=cycle,
        phase=phase,
    )


def _force(table: ReadTable, axis: str) -> FloatArray:
    """Return the force along an axis [N] at the times of the displacement: an indenter reads one after the other."""
    force, travel = _of(table, "force", axis), _of(table, "travel", axis)
    if force is None or travel is None:
        return np.full(len(table.lines), np.nan) if force is None else force.values
    late, early = (_time_before(table, column) for column in (force, travel))
    if late is None or early is None or late is early or not np.all(np.diff(late.values) > 0.0):
        return force.values
    return np.interp(early.values, late.values, force.values)


def _time_before(table: ReadTable, column: ReadColumn) -> ReadColumn | None:
    """Return the last column of time that stands before a column."""
    before = table.columns[: table.columns.index(column)]
    return next((one for one in reversed(before) if one.heading.quantity == "time"), None)


def _section(table: ReadTable, axis: str, mapping: FileMapping) -> float:
    """Return the section that carries a force [m²]: by the width or area that is given, or the distance across."""
    width = mapping.width
    if np.isnan(width) and table.area > 0.0:
        return table.area
    across = _of(table, "distance", {"C": "W", "W": "C"}.get(axis, "none"))
    if np.isnan(width) and across is not None and across.heading.axis:
        width = float(across.values[0])
    return width * mapping.thickness


def _strokes(table: ReadTable, rows: IntArray, travel: FloatArray) -> tuple[IntArray, tuple[Phase, ...]]:
    """Return cycle and phase of rows: as the BioTester or Bluehill 3 says them, or by the turns of the travel."""
    told_cycle, told_phase = strokes_of(travel)
    column, segment = _of(table, "cycle", ""), _of(table, "segment", "")
    if column is None:
        return told_cycle, told_phase
    texts = [_CYCLE.fullmatch(column.texts[row]) for row in rows]
    if all(text is not None and text[2] in PHASES for text in texts):
        pairs = [(int(text[1]), text[2]) for text in texts if text is not None]
        return np.array([cycle for cycle, _ in pairs]), tuple(phase for _, phase in pairs)  # type: ignore[misc]
    if segment is not None:
        # The count of Bluehill 3 rises a little after the turn, so that it is told from where strokes begin.
        outward = segment.values[rows] == OUTWARD
        starts = np.concatenate([[False], outward[1:] & ~outward[:-1]])
        phase = tuple(_phase(bool(goes), told) for goes, told in zip(outward, told_phase, strict=True))
        return 1 + np.cumsum(starts).astype(np.int64), phase
    number = column.values[rows]
    if np.isnan(number).any():
        return told_cycle, told_phase
    return (number - number.min()).astype(np.int64) + 1, told_phase


def _phase(outward: bool, told: Phase) -> Phase:  # noqa: FBT001 (of one row)
    return "Hold" if told == "Hold" else "Stretch" if outward else "Recover"

"""Equilibria of a job as lines of JSON, so that readers see complete rows and need no HDF5."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from app.records.folder import write_whole

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from app.records.reader import RunReader
    from rigs.axes import Axis
    from rigs.record import Equilibrium


class RowFile:
    """File of rows, cut to those before number `first`, to which rows are appended.

    Parameters
    ----------
    path : Path
        The file.
    first : int
        Number of the row that comes first.
    """

    def __init__(self, path: Path, first: int) -> None:
        with path.open("a+b") as file:
            file.seek(0)
            kept = sum(len(line) for _, line in zip(range(first), file, strict=False) if line.endswith(b"\n"))
            file.truncate(kept)
        self._path = path

    def append(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> None:
        """Write an equilibrium, with the strains of the driven axes [1], as one line."""
        columns = (strain, row.displacement, row.force)
        with self._path.open("ab", buffering=0) as file:
            file.write(_line(number, row.time, row.phase, row.cycle, row.tag, *map(dict, columns)))


def restore(path: Path, record: RunReader) -> None:
    """Rewrite the rows from a record if the file has fewer: a power cut may take them, and not the record."""
    try:
        with path.open("rb") as file:
            found = sum(line.endswith(b"\n") for line in file)
    except FileNotFoundError:
        found = 0
    if found < len(record.trace):
        write_whole(path, _lines(record))


def _lines(record: RunReader) -> Iterator[bytes]:
    trace, size = record.trace, record.size
    columns, axes = trace.columns, trace.axes
    for number, (phase, tag) in enumerate(zip(trace.phase, trace.tag, strict=True)):
        displacement = {axis: float(columns[f"displacement_{axis}"][number]) for axis in axes}
        force = {axis: float(columns[f"force_{axis}"][number]) for axis in axes}
        strain = {axis: travel / size.gauge(axis) for axis, travel in displacement.items()}
        time, cycle = float(columns["time"][number]), int(columns["cycle"][number])
        yield _line(number, time, phase, cycle, tag, strain, displacement, force)


def _line(number: int, time: float, phase: str, cycle: int, tag: str | None, *columns: Mapping[Any, float]) -> bytes:
    """Return a row as a line; `columns` are strain [1], displacement [m] and force [N] by axis."""
    strain, displacement, force = columns
    row = {"row": number, "time": time, "phase": phase, "cycle": cycle, "tag": tag}
    return json.dumps({**row, "strain": strain, "displacement": displacement, "force": force}).encode() + b"\n"

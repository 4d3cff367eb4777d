"""Reader of ``run.h5``, also of a run that is going on or was killed."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from app.records.h5_read import reading
from app.records.layout import KINDS, LAYOUT, NOT_PASSED, PLATES, RUNNING, UNFINISHED
from app.records.row_checksum import CHECKSUM, good_rows
from app.records.stored_log import read_logs
from app.records.vtkhdf import read_frames
from app.schemas import loads
from knitlab_core.equilibrium.stopwatch import Cost
from knitlab_core.errors import FormatError
from rigs.analysis.clasps import COLUMN, ClaspLoss, count_clasps
from rigs.analysis.material_limits import LimitCrossing, MaterialLimit
from rigs.analysis.stress_strain import effective_strain
from rigs.axes import DIRECTIONS
from rigs.instruments.samples import thinned
from rigs.instruments.zeros import Zeroing
from rigs.jumps import jump_times
from rigs.record import ENDS, PHASES, Outcome, SpecimenSize
from rigs.step_record import StepRecord
from rigs.trace import Trace

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import h5py

    from rigs.axes import Axis, FloatArray, IntArray
    from rigs.instruments.samples import Samples, Table
    from rigs.protocol.protocol import Protocol
    from rigs.record import Frame

MOST_SHOWN: Final = 100_000
"""Samples of a log that a plot shows."""

WHAT: Final = "the record of a run"


class RunReader:
    """Contents of ``run.h5``, also of a run that was killed.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``.
    trace : Trace, optional
        Its equilibria, where they have just been computed; by default they are read.
    test : Protocol, optional
        Its protocol, where it has been parsed already.

    Attributes
    ----------
    path : Path
        The file.
    protocol : str
        The protocol's YAML, verbatim.
    materials : str
        The YAML of the materials that the protocol brought in a file of its own, verbatim.
    strands : tuple of int
        Nodes of every strand.
    plates : tuple of IntArray or None
        Nodes in the lower and in the upper load plate; None where hooks held the specimen.
    test : Protocol
        The protocol, parsed.
    provenance : dict of str to object
        Attributes of the file: versions, seed, rig, material values.
    size : SpecimenSize
        Extents and fibre radius.
    tags : list of str
        The labels that steps, samples and images bear.
    trace : Trace
        The equilibria.
    logs : mapping of str to Table
        What the instruments logged, by their names, to be read part by part; empty if the run was cut off before.
    samples : dict of str to Samples
        The same for show: of a log of more than `MOST_SHOWN` samples those that its curve needs.
    zeroings : tuple of Zeroing or None
        The zeros of the test, in the order of time; None in records that have no table of them.
    steps : tuple of StepRecord
        The steps that were begun, and how each ended; ``abort``, at the last row, for one that did not.
    going_on : bool
        Whether the run is going on, or was killed: no end is recorded.
    crossings : tuple of LimitCrossing
        Where limits of the material were passed, the lowest first; empty in records that do not watch for them.
    losses : tuple of ClaspLoss
        Where clasps of the knit let go, first those before the test; empty in records that do not count them.
    outcome : Outcome
        How the run ended; ``abort`` if no end is recorded.

    Raises
    ------
    FormatError
        If the file is not a run, is damaged, or of another layout.
    """

    def __init__(self, path: Path, *, trace: Trace | None = None, test: Protocol | None = None) -> None:
        self.path = path
        self._test = test
        with reading(path, WHAT) as file:
            if "protocol" in file and file.attrs.get("layout") != LAYOUT:
                raise FormatError(path, 1, f"{WHAT} in layout {LAYOUT}")
            self.tags = [text.decode() for text in file["tags"][()]]
            self.protocol = cast("str", file["protocol"].asstr()[()])
            self.materials = cast("str", file["materials"].asstr()[()])
            self.strands = tuple(int(size) for size in file["strands"][()])
            self.plates = _read_plates(file)
            self.provenance = dict(file.attrs)
            self.size = SpecimenSize(
                extents={axis: float(file.attrs[f"extent_{axis}"]) for axis in DIRECTIONS},
                fibre_radius=float(file.attrs["fibre_radius"]),
                convention=file.attrs["thickness_convention"],
            )
            self.going_on = file["outcome"].attrs["end"].decode() == RUNNING
            self.trace = self._read_trace(file["equilibria"]) if trace is None else trace
            self.steps = _as_far(self._read_steps(file["steps"]), self.trace)
            self.zeroings = _read_zeros(file, self.trace.axes)
            self.logs: Mapping[str, Table] = read_logs(path, file["channels"], self.tags, jump_times(self.trace))
            self.crossings = _read_crossings(file, self.trace)
            self.losses = (*_read_let_go(file["equilibria"]), *count_clasps(self.trace, self.size).losses)
            self.outcome = _read_outcome(file["outcome"], len(self.trace))

    @property
    def test(self) -> Protocol:
        """Return the protocol, parsed when it is first asked for."""
        if self._test is None:
            name = str(self.provenance.get("name", "test"))
            self._test = loads(self.protocol, str(self.path), name=name, materials=self.materials).protocol
        return self._test

    @cached_property
    def samples(self) -> dict[str, Samples]:
        """Return what the instruments logged, thinned for plots."""
        return {name: thinned(log, MOST_SHOWN) for name, log in self.logs.items()}

    def force(self, axis: Axis) -> FloatArray:
        """Return the force of an axis at every equilibrium [N], (n,), from the specimen as mounted."""
        return self.trace.columns[f"force_{axis}"]

    def strain(self, axis: Axis) -> FloatArray:
        """Return the effective strain of an axis at every equilibrium [1], (n,), from the specimen as mounted."""
        return effective_strain(self.trace.columns[f"displacement_{axis}"], self.size.gauge(axis))

    def frames(self) -> tuple[Frame, ...]:
        """Return the stored shapes of the knit, in the order of time."""
        with reading(self.path, WHAT) as file:
            return read_frames(file, self.tags)

    def _read_trace(self, table: h5py.Group) -> Trace:
        raw = {name: column[()] for name, column in table.items()}
        good = good_rows(raw, self._tag_texts(raw["tag"][: _rows(raw)]))
        count = int(np.flatnonzero(good)[-1]) + 1 if good.any() else 0
        # A run that was cut off may have lost its last rows; any other row that does not match was damaged.
        if not good[:count].all() or (count < len(good) and not self.going_on):
            raise FormatError(
                self.path, 1, f"{WHAT}, undamaged: row {int(np.argmin(good))} does not match its checksum"
            )
        numbers = set(raw) - {"phase", "tag", CHECKSUM}
        return Trace(
            columns={name: raw[name][:count].astype(np.float64) for name in numbers},
            phase=tuple(PHASES[index] for index in raw["phase"][:count]),
            tag=self._tag_texts(raw["tag"][:count]),
        )

    def _read_steps(self, table: h5py.Group) -> tuple[StepRecord, ...]:
        raw = {name: column[()] for name, column in table.items()}
        tags = self._tag_texts(raw["tag"])
        return tuple(
            StepRecord(
                number=number,
                place=raw["place"][number].decode(),
                tag=tags[number],
                start=float(raw["start"][number]),
                time=float(raw["time"][number]),
                end=ENDS[raw["end"][number]],
                message=raw["message"][number].decode(),
            )
            for number in range(_rows(raw))
        )

    def _tag_texts(self, indices: FloatArray) -> tuple[str | None, ...]:
        return tuple(self.tags[int(index)] if 0 <= index < len(self.tags) else None for index in indices)


def read_run(path: Path | str) -> RunReader:
    """Open a run by its folder or by its file.

    Raises
    ------
    FileNotFoundError
        If there is no record.
    FormatError
        If it is not one of a run, or of another layout.
    """
    path = Path(path)
    record = path / "run.h5" if path.is_dir() else path
    if not record.exists():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(record))
    return RunReader(record)


def _rows(columns: dict[str, FloatArray]) -> int:
    """Return the number of rows that every column has; after a kill the last row may be incomplete."""
    return min(len(column) for column in columns.values())


def _as_far(steps: tuple[StepRecord, ...], trace: Trace) -> tuple[StepRecord, ...]:
    """Return the steps; one that was interrupted ends at the last row, with a message."""
    if not steps or steps[-1].end != "abort" or not len(trace):
        return steps
    last = steps[-1]
    reached = max(last.start, float(trace.columns["time"][-1]))
    return (*steps[:-1], replace(last, time=reached, message=last.message or "cut short"))


def _read_plates(file: h5py.File) -> tuple[IntArray, IntArray] | None:
    """Return the nodes in the two load plates, or None."""
    if "plates" not in file:
        return None
    lower, upper = (file[f"plates/{name}"][()] for name in PLATES)
    return lower, upper


def _read_zeros(file: h5py.File, axes: Sequence[Axis]) -> tuple[Zeroing, ...] | None:
    """Return the zeros of a test without that of the specimen as printed; None where there is no table of them."""
    if "zeros" not in file:
        return None
    raw = {name: column[()] for name, column in file["zeros"].items()}
    return tuple(
        Zeroing(
            time=float(raw["time"][row]),
            kinds=frozenset(kind for kind in KINDS if raw[f"zeroed_{kind}"][row]),
            place=raw["place"][row].decode(),
            travel={axis: float(raw[f"travel_{axis}"][row]) for axis in axes},
            force={axis: float(raw[f"force_{axis}"][row]) for axis in axes},
            gauges={axis: float(raw[f"gauge_length_{axis}"][row]) for axis in axes},
        )
        for row in range(1, _rows(raw))
    )


def _read_crossings(file: h5py.File, trace: Trace) -> tuple[LimitCrossing, ...]:
    """Return the material limits that were passed, and where."""
    if "limits" not in file:
        return ()
    raw = {name: column[()] for name, column in file["limits"].items()}
    return tuple(
        LimitCrossing(
            limit=MaterialLimit(
                name=raw["name"][k].decode(), strain=float(raw["limit"][k]), text=raw["text"][k].decode()
            ),
            row=int(row),
            time=float(raw["time"][k]),
            strain={axis: float(raw[f"strain_{axis}"][k]) for axis in trace.axes},
            fibre_strain=float(raw["fibre_strain"][k]),
        )
        for k, row in enumerate(raw["row"])
        if NOT_PASSED < row < len(trace)
    )


def _read_let_go(rows: h5py.Group) -> list[ClaspLoss]:
    """Return the clasps that the knit lost before its test."""
    found = []
    for name, column in rows.items():
        if name.startswith(COLUMN) and "let_go" in column.attrs:
            laid, lost = int(column.attrs["laid"]), int(column.attrs["let_go_count"])
            found.append(
                ClaspLoss(
                    joined=name.removeprefix(COLUMN),
                    row=0,
                    time=0.0,
                    strain={},
                    lost=lost,
                    held=laid - lost,
                    mounted=laid,
                    places=str(column.attrs["let_go"]),
                )
            )
    return found


def _read_outcome(group: h5py.Group, rows: int) -> Outcome:
    end = group.attrs["end"].decode()
    if end in ENDS:
        # Records from before 2026-12 lack the cost of searches without a row.
        iterations, factorisations, seconds = (float(group.attrs.get(name, 0.0)) for name in UNFINISHED)
        unfinished = Cost(round(iterations), round(factorisations), seconds)
        return Outcome(end=end, message=group.attrs["message"].decode(), unfinished=unfinished)
    message = "the run is going on, or was killed" if end == RUNNING else f"unknown end {end!r}"
    return Outcome(end="abort", message=f"{message}; {rows} rows")

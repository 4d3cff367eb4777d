"""Writer of ``run.h5``, the record of a test.

Every dataset is made when the file is, rows are only appended, and each is brought to the file before the next. So a
run that is killed, or finds its disk full, leaves a file that any HDF5 program opens (docs/decisions/0011, 0025). One
that ends is sealed.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Self

import h5py
import numpy as np

from app.records.layout import END, KINDS, MESSAGE, NOT_PASSED, RUNNING, TAG_BYTES, UNFINISHED, cut, lengths
from app.records.row_checksum import CHECKSUM, checked, row_checksum
from app.records.seal import seal, sealed_size
from app.records.staged_file import StagedFile
from app.records.vtkhdf import NO_IMAGE, FrameWriter
from rigs.record import ENDS, PHASES

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path
    from types import TracebackType

    from rigs.instruments.samples import Samples
    from rigs.instruments.zeros import Zeroing
    from rigs.record import Equilibrium, Frame, Outcome
    from rigs.step_record import StepRecord

#: The same in the frames.
NO_TAG = NO_IMAGE
_ONE = h5py.h5s.create_simple((1,))


def _append(dataset: h5py.Dataset, values: object, count: int = 1) -> None:
    length = dataset.shape[0]
    dataset.resize(length + count, axis=0)
    dataset[length:] = values


class RunWriter:
    """Writer of a run's record, row by row.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``, as `make_record` makes it.
    wanted : mapping of str to int, optional
        What was there of it, as `lengths` said, when its run stood where it goes on: what came after is dropped.
    """

    def __init__(self, path: Path, wanted: Mapping[str, int] | None = None) -> None:
        self._path = path
        self._staged = StagedFile(path)
        size = sealed_size(path)
        if size is not None:
            self._staged.truncate(size)
        self._file = h5py.File(self._staged, "r+", libver="earliest")
        if wanted is not None:
            cut(self._file, wanted)
            self._say(RUNNING, "")
        self._tags = [text.decode() for text in self._file["tags"][()]]
        self._columns = {name: column.id for name, column in self._file["equilibria"].items()}
        self._checked = checked(self._columns)
        self._rows = len(self._file["equilibria/time"])
        self._frames = FrameWriter(self._file)
        self._unpassed = self._limits_ahead()

    @property
    def rows(self) -> int:
        """Number of equilibria written."""
        return self._rows

    def lengths(self) -> dict[str, int]:
        """Return the lengths of all growing datasets by name."""
        return lengths(self._file)

    def sync(self) -> None:
        """Write to the disk; after it returns a power cut loses nothing."""
        self._commit()
        os.fsync(self._staged.fileno())

    def _commit(self) -> None:
        """Write to the file; without room on the disk it stays as after the last commit."""
        self._file.flush()
        self._staged.commit()

    def _tag(self, tag: str | None) -> int:
        if tag is None:
            return NO_TAG
        if tag not in self._tags:
            self._tags.append(tag)
            _append(self._file["tags"], _clipped(tag, TAG_BYTES))
        return self._tags.index(tag)

    def set_protocol(self, text: str) -> None:
        """Replace the protocol by one with other steps, as a live rig does."""
        self._file["protocol"][()] = text
        self._commit()

    def append(self, row: Equilibrium) -> None:
        """Append an accepted equilibrium; after it returns a kill does not lose the row."""
        values = row.numbers() | {"phase": PHASES.index(row.phase), "tag": self._tag(row.tag)}
        numbers = np.array([values[name] for name in self._checked], dtype=np.float64)
        values[CHECKSUM] = row_checksum(numbers, None if row.tag is None else _clipped(row.tag, 64).decode())
        # Through h5py's high-level interface it takes 12 ms a row; this way 1 ms.
        count = self._rows + 1
        place = h5py.h5s.create_simple((count,))
        place.select_hyperslab((self._rows,), (1,))
        for name, column in self._columns.items():
            column.set_extent((count,))
            column.write(_ONE, place, np.array([values[name]], dtype=column.dtype))
        self._rows = count
        self._note_limits(row)
        self._commit()

    def _limits_ahead(self) -> dict[int, float]:
        """Return the fibre strains [1] of the material limits not passed yet, by their place in the record."""
        if "limits" not in self._file:
            return {}
        group = self._file["limits"]
        # A crossing in rows that were cut off is found again.
        ahead = [k for k, row in enumerate(group["row"][()]) if not NOT_PASSED < row < self._rows]
        for name in set(group) - {"name", "text", "limit"}:
            for k in ahead:
                group[name][k] = NOT_PASSED if name == "row" else np.nan
        return {k: float(group["limit"][k]) for k in ahead}

    def _note_limits(self, row: Equilibrium) -> None:
        """Record the material limits that the last row is the first to pass."""
        for k in [k for k, limit in self._unpassed.items() if row.fibre_strain > limit]:
            del self._unpassed[k]
            group = self._file["limits"]
            group["row"][k], group["time"][k] = self._rows - 1, row.time
            group["fibre_strain"][k] = row.fibre_strain
            for axis, displacement in row.displacement.items():
                group[f"strain_{axis}"][k] = displacement / self._file.attrs[f"extent_{axis}"]

    def add_frame(self, frame: Frame) -> None:
        """Append the shape of the knit at an equilibrium."""
        self._frames.append(frame, self._tag(frame.image))
        self._commit()

    def add_step(self, step: StepRecord) -> None:
        """Record a step that begins, or how it ended."""
        values = {
            "place": _clipped(step.place, 256),
            "tag": self._tag(step.tag),
            "start": step.start,
            "time": step.time,
            "end": ENDS.index(step.end),
            "message": _clipped(step.message, 1024),
        }
        for name, value in values.items():
            column = self._file["steps"][name]
            column.resize(max(len(column), step.number + 1), axis=0)
            column[step.number] = value
        self._commit()

    def add_zero(self, zeroing: Zeroing) -> None:
        """Record a zero: when and where in the test, and the gauge lengths from then on."""
        values = {
            "place": _clipped(zeroing.place, 256),
            "time": zeroing.time,
            **{f"zeroed_{kind}": kind in zeroing.kinds for kind in KINDS},
            **{f"travel_{axis}": value for axis, value in zeroing.travel.items()},
            **{f"force_{axis}": value for axis, value in zeroing.force.items()},
            **{f"gauge_length_{axis}": value for axis, value in zeroing.gauges.items()},
        }
        for name, value in values.items():
            _append(self._file["zeros"][name], value)
        self._commit()

    def write_samples(self, samples: Samples) -> None:
        """Append a part of an instrument's log, in the order of time."""
        table, count = self._file["channels"][samples.instrument], len(samples.time)
        _append(table["Time"], samples.time, count)
        _append(table["cycle"], samples.cycle, count)
        _append(table["phase"], [PHASES.index(phase) for phase in samples.phase], count)
        _append(table["tag"], [self._tag(tag) for tag in samples.tag], count)
        for place, values in (
            (table, samples.measured),
            (table["clean"], samples.clean),
            (table["offset"], samples.offset),
        ):
            for name, column in values.items():
                _append(place[name], column, count)
        told = {text.decode() for text in table["overloads"][()]}
        fresh = [name for name in samples.overloads if name not in told]
        if fresh:
            _append(table["overloads"], fresh, len(fresh))
        self._commit()

    def finish(self, outcome: Outcome) -> None:
        """Record how the run ended."""
        attributes = self._file["outcome"].attrs
        for name in UNFINISHED:
            attributes.modify(name, float(getattr(outcome.unfinished, name)))
        self._say(outcome.end, outcome.message)

    def _say(self, end: str, message: str) -> None:
        attributes = self._file["outcome"].attrs
        attributes.modify("end", np.array(end.encode(), dtype=END))
        attributes.modify("message", np.array(_clipped(message, 1024), dtype=MESSAGE))
        self._commit()

    def close(self) -> None:
        """Write what is left, close the file and seal it."""
        self._file.close()
        with self._staged:
            self._staged.commit()
        seal(self._path)

    def _let_go(self) -> None:
        """Close the file in the state of the last commit."""
        self._file.close()
        self._staged.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
        else:
            self._let_go()


def _clipped(text: str, size: int) -> bytes:
    """Return a text cut to a number of bytes of UTF-8, at a character."""
    return text.encode()[:size].decode(errors="ignore").encode()

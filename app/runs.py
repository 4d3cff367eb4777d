"""Write ``run.h5``, the truth of a test.

Every dataset is made when the file is, rows are only appended, and each is flushed: raw data first,
then the lengths. So a run killed at any moment leaves a file that any HDF5 program opens.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import h5py
import numpy as np

from rigs.record import PHASES, units

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

    from rigs.instruments import Instrument, Samples
    from rigs.record import Equilibrium, Frame, Outcome, SpecimenSize
    from rigs.steps import Axis

#: Rows that one stretch of the file holds; a new one is needed only so often.
CHUNK = 4096
#: Rises whenever a reader of the last layout would not find what it looks for.
LAYOUT = 4
RUNNING = "running"
NO_TAG = -1
_TEXT = h5py.string_dtype("utf-8", length=64)
_END = h5py.string_dtype("utf-8", length=16)
_MESSAGE = h5py.string_dtype("utf-8", length=1024)
_ONE = h5py.h5s.create_simple((1,))
_WHOLE = frozenset({"contacts", "iterations", "factorisations", "cycle", "bonds_whole", "bonds_broken"})


def _append(dataset: h5py.Dataset, values: object, count: int = 1) -> None:
    length = dataset.shape[0]
    dataset.resize(length + count, axis=0)
    dataset[length:] = values


def _column(group: h5py.Group, name: str, dtype: object, unit: str | None = None) -> None:
    dataset = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(CHUNK,), dtype=dtype)
    if unit is not None:
        dataset.attrs["units"] = unit


def _phase_and_tag(table: h5py.Group) -> None:
    _column(table, "phase", "i1")
    table["phase"].attrs["meaning"] = ", ".join(PHASES)
    _column(table, "tag", "i4")


class RunWriter:
    """Write a run row by row.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``; an older one is replaced.
    protocol : str
        The protocol's YAML, verbatim.
    size : SpecimenSize
        Extents and fibre radius.
    axes : sequence of Axis
        The axes that are driven.
    strands : sequence of int
        Nodes of every strand, N in all.
    instruments : sequence of Instrument
        Their channels.
    provenance : mapping of str to (str, int or float)
        Versions, seed, rig, material values with their sources.
    materials : str
        The YAML of the materials that the protocol brings in a file of its own, verbatim.
    """

    def __init__(
        self,
        path: Path,
        *,
        protocol: str,
        size: SpecimenSize,
        axes: Sequence[Axis],
        strands: Sequence[int],
        instruments: Sequence[Instrument],
        provenance: Mapping[str, str | int | float],
        materials: str = "",
    ) -> None:
        # No lock: the file may be looked into while the run goes on.
        self._file = h5py.File(path, "w", libver="earliest", locking=False)
        self._tags: list[str] = []
        self._file.create_dataset("protocol", data=protocol, dtype=h5py.string_dtype("utf-8"))
        self._file.create_dataset("materials", data=materials, dtype=h5py.string_dtype("utf-8"))
        self._file.create_dataset("strands", data=np.array(strands, dtype=np.int64))
        self._file.create_dataset("tags", shape=(0,), maxshape=(None,), chunks=(64,), dtype=_TEXT)
        facts = {
            "layout": LAYOUT,
            "fibre_radius": size.fibre_radius,
            **{f"extent_{axis}": extent for axis, extent in size.extents.items()},
            "thickness_convention": size.convention,
        }
        self._file.attrs.update({**provenance, **facts})
        self._make_equilibria(axes)
        self._make_frames(axes, sum(strands), sum(strands) - len(strands))
        self._file.create_group("channels")
        for instrument in instruments:
            self._make_channels(instrument)
        self._columns = {name: column.id for name, column in self._file["equilibria"].items()}
        self._rows = 0
        outcome = self._file.create_group("outcome")
        outcome.attrs.create("end", RUNNING, dtype=_END)
        outcome.attrs.create("message", "", dtype=_MESSAGE)
        self._file.flush()

    def _make_equilibria(self, axes: Sequence[Axis]) -> None:
        table = self._file.create_group("equilibria")
        for name, unit in units(axes).items():
            _column(table, name, "i8" if name in _WHOLE else "f8", unit)
        _phase_and_tag(table)

    def _make_frames(self, axes: Sequence[Axis], node_count: int, edge_count: int) -> None:
        table = self._file.create_group("frames")
        _column(table, "time", "f8", "s")
        for axis in axes:
            _column(table, f"strain_{axis}", "f8", "1")
        _column(table, "cycle", "i8")
        _column(table, "phase", "i1")
        for name, tail, unit in (
            ("nodes", (node_count, 3), "m"),
            ("axial_strain", (edge_count,), "1"),
        ):
            made = table.create_dataset(name, shape=(0, *tail), maxshape=(None, *tail), chunks=(1, *tail), dtype="f8")
            made.attrs["units"] = unit
        # How many wires there are, the first frame says.
        ends = table.create_dataset(
            "wires", shape=(0, 0, 2, 3), maxshape=(None, None, 2, 3), chunks=(1, 16, 2, 3), dtype="f8"
        )
        ends.attrs["units"] = "m"

    def _make_channels(self, instrument: Instrument) -> None:
        table = self._file["channels"].create_group(instrument.name)
        _column(table, "Time", "f8", "s")
        _column(table, "cycle", "i8")
        for kind in ("clean", "offset"):
            table.create_group(kind)
        for channel in instrument.channels:
            for place in (table, table["clean"], table["offset"]):
                _column(place, channel.name, "f8", channel.unit)
            table[channel.name].attrs["reads"] = channel.reads
        table.create_dataset("overloads", shape=(0,), maxshape=(None,), chunks=(64,), dtype=_TEXT)
        _phase_and_tag(table)

    def _tag(self, tag: str | None) -> int:
        if tag is None:
            return NO_TAG
        if tag not in self._tags:
            self._tags.append(tag)
            _append(self._file["tags"], _cut(tag, 64))
        return self._tags.index(tag)

    def append(self, row: Equilibrium) -> None:
        """Add an accepted equilibrium; when this returns, a killed run still has it."""
        values = row.numbers() | {"phase": PHASES.index(row.phase), "tag": self._tag(row.tag)}
        # The plain way costs 12 ms a row, a good part of a time step; this one 1 ms.
        count = self._rows + 1
        place = h5py.h5s.create_simple((count,))
        place.select_hyperslab((self._rows,), (1,))
        for name, column in self._columns.items():
            column.set_extent((count,))
            column.write(_ONE, place, np.array([values[name]], dtype=column.dtype))
        self._rows = count
        self._file.flush()

    def add_frame(self, frame: Frame) -> None:
        """Add the shape of the knit at an equilibrium."""
        table = self._file["frames"]
        for name in ("time", "cycle", "nodes", "axial_strain"):
            _append(table[name], getattr(frame, name))
        table["wires"].resize(len(frame.wires), axis=1)
        _append(table["wires"], frame.wires)
        for axis, strain in frame.strain.items():
            _append(table[f"strain_{axis}"], strain)
        _append(table["phase"], PHASES.index(frame.phase))
        self._file.flush()

    def write_samples(self, samples: Samples) -> None:
        """Write what an instrument logged; once, at the end."""
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
        if samples.overloads:
            _append(table["overloads"], list(samples.overloads), len(samples.overloads))
        self._file.flush()

    def finish(self, outcome: Outcome) -> None:
        """Say how the run ended."""
        attributes = self._file["outcome"].attrs
        attributes.modify("end", np.array(outcome.end.encode(), dtype=_END))
        attributes.modify("message", np.array(_cut(outcome.message, 1024), dtype=_MESSAGE))
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _cut(text: str, size: int) -> bytes:
    """Return at most so many bytes of UTF-8, and whole characters."""
    return text.encode()[:size].decode(errors="ignore").encode()

"""Read ``run.h5`` back, whole or cut off."""

from __future__ import annotations

import errno
import os
from typing import TYPE_CHECKING, cast

import h5py
import numpy as np

from app.run_layout import LAYOUT, PLATES, RUNNING
from app.vtkhdf import read_frames
from knitlab_core.errors import FormatError
from rigs.instruments import Samples
from rigs.record import ENDS, PHASES, Outcome, SpecimenSize, Trace
from rigs.step_record import StepRecord
from rigs.steps import AXES

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.record import FloatArray, Frame, IntArray


class RunReader:
    """Hold what a run left behind, even one that was killed.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``.

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
    provenance : dict of str to object
        Attributes of the file: versions, seed, rig, material values.
    size : SpecimenSize
        Extents and fibre radius.
    trace : Trace
        The equilibria.
    samples : dict of str to Samples
        What the instruments logged, by their names; empty if the run was cut off before.
    steps : tuple of StepRecord
        The steps that were begun, and how each ended; ``abort`` for one that did not.
    outcome : Outcome
        How the run ended; ``abort`` if nothing says so.

    Raises
    ------
    FormatError
        If the file is not a run, or of another layout.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with h5py.File(path, "r", locking=False) as file:
                if "protocol" in file and file.attrs.get("layout") != LAYOUT:
                    raise FormatError(path, 1, f"the record of a run in layout {LAYOUT}")
                self._tags = [text.decode() for text in file["tags"][()]]
                self.protocol = cast("str", file["protocol"].asstr()[()])
                self.materials = cast("str", file["materials"].asstr()[()])
                self.strands = tuple(int(size) for size in file["strands"][()])
                self.plates = _read_plates(file)
                self.provenance = dict(file.attrs)
                self.size = SpecimenSize(
                    extents={axis: float(file.attrs[f"extent_{axis}"]) for axis in AXES},
                    fibre_radius=float(file.attrs["fibre_radius"]),
                    convention=file.attrs["thickness_convention"],
                )
                self.trace = self._read_trace(file["equilibria"])
                self.steps = self._read_steps(file["steps"])
                self.samples = self._read_all_samples(file["channels"])
                self.outcome = _read_outcome(file["outcome"], len(self.trace))
        except FileNotFoundError:
            raise
        except (OSError, KeyError) as error:
            raise FormatError(path, 1, f"the record of a run ({error})") from error

    def frames(self) -> tuple[Frame, ...]:
        """Return the shapes that were kept, in the order of time."""
        with h5py.File(self.path, "r", locking=False) as file:
            return read_frames(file, self._tags)

    def _read_trace(self, table: h5py.Group) -> Trace:
        raw = {name: column[()] for name, column in table.items()}
        count = _rows(raw)
        numbers = set(raw) - {"phase", "tag"}
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

    def _read_all_samples(self, channels: h5py.Group) -> dict[str, Samples]:
        found = {name: self._read_samples(name, table) for name, table in channels.items()}
        return {name: samples for name, samples in found.items() if samples is not None}

    def _read_samples(self, instrument: str, table: h5py.Group) -> Samples | None:
        names = tuple(table["clean"])
        raw = {name: table[name][()] for name in ("Time", "cycle", "phase", "tag", *names)}
        if not _rows(raw):
            return None
        return Samples(
            instrument=instrument,
            time=raw["Time"],
            measured={name: raw[name] for name in names},
            clean={name: cast("FloatArray", table["clean"][name][()]) for name in names},
            offset={name: cast("FloatArray", table["offset"][name][()]) for name in names},
            units={name: str(table[name].attrs["units"]) for name in names},
            reads={name: str(table[name].attrs["reads"]) for name in names},
            cycle=raw["cycle"],
            phase=tuple(PHASES[index] for index in raw["phase"]),
            tag=self._tag_texts(raw["tag"]),
            overloads=tuple(text.decode() for text in table["overloads"][()]),
            clock_offset=float(table.attrs.get("clock_offset", 0.0)),
            clock_skew=float(table.attrs.get("clock_skew", 0.0)),
            delay={name: late for name in names if (late := float(table[name].attrs.get("delay", 0.0))) > 0.0},
        )

    def _tag_texts(self, indices: FloatArray) -> tuple[str | None, ...]:
        return tuple(self._tags[int(index)] if 0 <= index < len(self._tags) else None for index in indices)


def read_run(path: Path) -> RunReader:
    """Open a run by its folder or by its file.

    Raises
    ------
    FileNotFoundError
        If there is no record.
    FormatError
        If it is not one of a run, or of another layout.
    """
    record = path / "run.h5" if path.is_dir() else path
    if not record.exists():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(record))
    return RunReader(record)


def _rows(columns: dict[str, FloatArray]) -> int:
    """Return the rows that every column has: a killed run may lack some of the last one."""
    return min(len(column) for column in columns.values())


def _read_plates(file: h5py.File) -> tuple[IntArray, IntArray] | None:
    """Return the nodes in the two load plates, or None."""
    if "plates" not in file:
        return None
    lower, upper = (file[f"plates/{name}"][()] for name in PLATES)
    return lower, upper


def _read_outcome(group: h5py.Group, rows: int) -> Outcome:
    end = group.attrs["end"].decode()
    if end in ENDS:
        return Outcome(end=end, message=group.attrs["message"].decode())
    message = "the run is going on, or was killed" if end == RUNNING else f"unknown end {end!r}"
    return Outcome(end="abort", message=f"{message}; {rows} rows")

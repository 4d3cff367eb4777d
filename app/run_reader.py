"""Read ``run.h5`` back, whole or cut off."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import h5py
import numpy as np

from app.runs import RUNNING
from knitlab_core.errors import FormatError
from rigs.instruments import Samples
from rigs.record import ENDS, PHASES, UNITS, Frame, Outcome, SpecimenSize, Trace

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.record import FloatArray


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
    provenance : dict of str to object
        Attributes of the file: versions, seed, rig, material values.
    size : SpecimenSize
        Gauge lengths, fibre radius and thickness.
    trace : Trace
        The equilibria.
    samples : Samples or None
        What the instrument logged; None if the run was cut off before.
    outcome : Outcome
        How the run ended; ``abort`` if nothing says so.

    Raises
    ------
    FormatError
        If the file is not a run.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with h5py.File(path, "r", locking=False) as file:
                self._tags = [text.decode() for text in file["tags"][()]]
                self.protocol = cast("str", file["protocol"].asstr()[()])
                self.provenance = dict(file.attrs)
                names = ("gauge_C", "gauge_W", "fibre_radius", "thickness")
                self.size = SpecimenSize(**{name: float(file.attrs[name]) for name in names})
                self.trace = self._read_trace(file["equilibria"])
                self.samples = self._read_samples(file["channels"])
                self.outcome = _read_outcome(file["outcome"], len(self.trace))
        except FileNotFoundError:
            raise
        except (OSError, KeyError) as error:
            raise FormatError(path, 1, f"the record of a run ({error})") from error

    def frames(self) -> tuple[Frame, ...]:
        """Return the shapes that were kept, in the order of time."""
        with h5py.File(self.path, "r", locking=False) as file:
            table = file["frames"]
            columns = {name: table[name][()] for name in table}
        return tuple(
            Frame(
                time=float(columns["time"][k]),
                nodes=columns["nodes"][k],
                axial_strain=columns["axial_strain"][k],
                strain_C=float(columns["strain_C"][k]),
                strain_W=float(columns["strain_W"][k]),
                cycle=int(columns["cycle"][k]),
                phase=PHASES[columns["phase"][k]],
            )
            for k in range(_rows(columns))
        )

    def _read_trace(self, table: h5py.Group) -> Trace:
        raw = {name: table[name][()] for name in (*UNITS, "phase", "tag")}
        count = _rows(raw)
        return Trace(
            columns={name: raw[name][:count].astype(np.float64) for name in UNITS},
            phase=tuple(PHASES[index] for index in raw["phase"][:count]),
            tag=self._tag_texts(raw["tag"][:count]),
        )

    def _read_samples(self, table: h5py.Group) -> Samples | None:
        names = tuple(table["clean"])
        raw = {name: table[name][()] for name in ("Time", "cycle", "phase", "tag", *names)}
        if not _rows(raw):
            return None
        return Samples(
            time=raw["Time"],
            measured={name: raw[name] for name in names},
            clean={name: cast("FloatArray", table["clean"][name][()]) for name in names},
            offset={name: cast("FloatArray", table["offset"][name][()]) for name in names},
            units={name: str(table[name].attrs["units"]) for name in names},
            cycle=raw["cycle"],
            phase=tuple(PHASES[index] for index in raw["phase"]),
            tag=self._tag_texts(raw["tag"]),
            overloads=tuple(text.decode() for text in table["overloads"][()]),
        )

    def _tag_texts(self, indices: FloatArray) -> tuple[str | None, ...]:
        return tuple(self._tags[int(index)] if 0 <= index < len(self._tags) else None for index in indices)


def _rows(columns: dict[str, FloatArray]) -> int:
    """Return the rows that every column has: a killed run may lack some of the last one."""
    return min(len(column) for column in columns.values())


def _read_outcome(group: h5py.Group, rows: int) -> Outcome:
    end = group.attrs["end"].decode()
    if end in ENDS:
        return Outcome(end=end, message=group.attrs["message"].decode())
    message = "the run is going on, or was killed" if end == RUNNING else f"unknown end {end!r}"
    return Outcome(end="abort", message=f"{message}; {rows} rows")

"""Read ``run.h5`` back, whole or cut off."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import h5py
import numpy as np

from app.runs import LAYOUT, RUNNING
from knitlab_core.errors import FormatError
from rigs.instruments import Samples
from rigs.record import ENDS, PHASES, Frame, Outcome, SpecimenSize, Trace
from rigs.steps import AXES

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
    materials : str
        The YAML of the materials that the protocol brought in a file of its own, verbatim.
    strands : tuple of int
        Nodes of every strand.
    provenance : dict of str to object
        Attributes of the file: versions, seed, rig, material values.
    size : SpecimenSize
        Extents and fibre radius.
    trace : Trace
        The equilibria.
    samples : dict of str to Samples
        What the instruments logged, by their names; empty if the run was cut off before.
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
                self.provenance = dict(file.attrs)
                self.size = SpecimenSize(
                    extents={axis: float(file.attrs[f"extent_{axis}"]) for axis in AXES},
                    fibre_radius=float(file.attrs["fibre_radius"]),
                    convention=file.attrs["thickness_convention"],
                )
                self.trace = self._read_trace(file["equilibria"])
                self.samples = self._read_all_samples(file["channels"])
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
                wires=columns["wires"][k],
                strain={axis: float(columns[f"strain_{axis}"][k]) for axis in AXES if f"strain_{axis}" in columns},
                cycle=int(columns["cycle"][k]),
                phase=PHASES[columns["phase"][k]],
            )
            for k in range(_rows(columns))
        )

    def _read_trace(self, table: h5py.Group) -> Trace:
        raw = {name: column[()] for name, column in table.items()}
        count = _rows(raw)
        numbers = set(raw) - {"phase", "tag"}
        return Trace(
            columns={name: raw[name][:count].astype(np.float64) for name in numbers},
            phase=tuple(PHASES[index] for index in raw["phase"][:count]),
            tag=self._tag_texts(raw["tag"][:count]),
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

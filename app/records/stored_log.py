"""Logs of instruments in ``run.h5``, read part by part."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from app.records.h5_read import reading
from rigs.instruments.samples import Samples
from rigs.record import PHASES

if TYPE_CHECKING:
    from pathlib import Path

    import h5py

    from rigs.axes import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StoredLog:
    """Log of an instrument whose samples stay in the file until they are read.

    Attributes
    ----------
    path : Path
        The file, ``run.h5``.
    about : Samples
        The log without a sample.
    tags : list of str
        The labels that the samples may bear.
    count : int
        Number of samples.
    """

    path: Path
    about: Samples
    tags: list[str]
    count: int

    def __len__(self) -> int:
        """Return the number of samples."""
        return self.count

    def part(self, first: int, last: int) -> Samples:
        """Return the samples from the first on and before the last."""
        rows = slice(first, last)
        with reading(self.path, "the record of a run", sealed=False) as file:
            table = file["channels"][self.about.instrument]
            phases, tags = table["phase"][rows].tolist(), table["tag"][rows].tolist()
            return replace(
                self.about,
                time=table["Time"][rows],
                measured={name: table[name][rows] for name in self.about.measured},
                clean={name: table["clean"][name][rows] for name in self.about.measured},
                offset={name: table["offset"][name][rows] for name in self.about.measured},
                cycle=table["cycle"][rows],
                phase=tuple(PHASES[index] for index in phases),
                tag=tuple(self.tags[index] if 0 <= index < len(self.tags) else None for index in tags),
            )

    def find(self, stamp: float) -> int:
        """Return the number of the first sample whose stamp is not before a given stamp [s]."""
        with reading(self.path, "the record of a run", sealed=False) as file:
            times = file["channels"][self.about.instrument]["Time"]
            return bisect_left(range(self.count), stamp, key=lambda number: float(times[number]))


def read_logs(path: Path, channels: h5py.Group, tags: list[str], jumps: FloatArray) -> dict[str, StoredLog]:
    """Return the logs of a record by instrument; instruments without a sample are left out.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``.
    channels : Group
        Its group of that name.
    tags : list of str
        The labels of the record.
    jumps : FloatArray, shape (k,)
        When the specimen jumped, on the rig's clock [s].
    """
    found = {}
    for instrument, table in channels.items():
        names = tuple(table["clean"])
        columns = [table[name] for name in ("Time", "cycle", "phase", "tag", *names)]
        count = min(len(column) for column in columns)
        if count:
            about = _about(instrument, table, names, jumps)
            found[instrument] = StoredLog(path=path, about=about, tags=tags, count=count)
    return found


def _about(instrument: str, table: h5py.Group, names: tuple[str, ...], jumps: FloatArray) -> Samples:
    """Return a log without samples."""
    none = {name: np.zeros(0) for name in names}
    return Samples(
        instrument=instrument,
        time=np.zeros(0),
        measured=none,
        clean=none,
        offset=none,
        units={name: str(table[name].attrs["units"]) for name in names},
        reads={name: str(table[name].attrs["reads"]) for name in names},
        cycle=np.zeros(0, dtype=np.int64),
        phase=(),
        tag=(),
        overloads=tuple(text.decode() for text in table["overloads"][()]),
        clock_offset=float(table.attrs.get("clock_offset", 0.0)),
        clock_skew=float(table.attrs.get("clock_skew", 0.0)),
        delay={name: late for name in names if (late := float(table[name].attrs.get("delay", 0.0))) > 0.0},
        jumps=jumps,
    )

"""Checkpoints of a run, written beside its record, from which a killed run resumes with the same rows.

A checkpoint is whole or not there: it is written under another name, brought to the disk, then renamed. The rows that
it counts are on the disk before it is.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from app.records.folder import whole_file
from app.records.h5_read import reading
from app.records.h5_tree import fetch, store
from app.records.seal import seal
from app.records.staged_file import new_hdf5
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.solver_state import SolverState
from knitlab_core.errors import FormatError
from rigs.control.checkpoint import Checkpoint
from rigs.control.controller import Memory
from rigs.control.resume_point import PathPosition, ResumePoint
from rigs.instruments.zeros import Zeroing
from rigs.protocol.strokes import History, Readings
from rigs.record import Equilibrium

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from app.records.writer import RunWriter

CHECKPOINT: Final = "checkpoint.h5"

#: Rises whenever a checkpoint of before could not be gone on from.
LAYOUT: Final = 5

EVERY: Final = 2.0
"""Time between two checkpoints, at least [s]."""

SHARE: Final = 0.01
"""Share of a run's time that checkpoints may take, at most [1]."""

Facts: TypeAlias = "Mapping[str, str | int | float]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Identity of a run: its protocol and the versions and numbers that it was started with.

    Attributes
    ----------
    name : str
        Name of the protocol.
    protocol, materials : str
        The protocol, and the materials it brings in a file of its own, verbatim.
    facts : Mapping
        What it was made with; see `provenance`.
    """

    name: str
    protocol: str
    materials: str
    facts: Facts


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Saved:
    """A checkpoint as read from disk, with the lengths of its record at that time.

    Attributes
    ----------
    origin : Origin
        What the run is of.
    checkpoint : Checkpoint
        What the test needs to go on.
    lengths : Mapping
        Length of everything in the record that grows; see `RunWriter.lengths`.
    zeroings : tuple of Zeroing
        The zeroings so far.
    seconds : float
        Wall time that the run had taken [s].
    """

    origin: Origin
    checkpoint: Checkpoint
    lengths: Mapping[str, int]
    zeroings: tuple[Zeroing, ...]
    seconds: float


@dataclass(slots=True, kw_only=True)
class Keeper:
    """Writer of checkpoints during a run; the first one is written at once.

    Attributes
    ----------
    path : Path
        The file.
    origin : Origin
        What the run is of.
    began : float
        When the run began, on the clock of `perf_counter`, earlier sessions counted in [s].
    text : callable or None
        Returns the protocol so far where its steps come one by one; None for a protocol that is known from the start.
    """

    path: Path
    origin: Origin
    began: float
    text: Callable[[], str] | None = None
    _due: float = field(default=0.0, init=False)

    def keep(self, checkpoint: Checkpoint, writer: RunWriter, zeroings: list[Zeroing]) -> None:
        """Write a checkpoint if one is due."""
        begin = perf_counter()
        if begin < self._due:
            return
        if self.text is not None:
            self.set_protocol(self.text(), writer)
        writer.sync()
        saved = Saved(
            origin=self.origin,
            checkpoint=checkpoint,
            lengths=writer.lengths(),
            zeroings=tuple(zeroings),
            seconds=begin - self.began,
        )
        save(self.path, saved)
        end = perf_counter()
        self._due = end + max(EVERY, (end - begin) / SHARE)

    def set_protocol(self, text: str, writer: RunWriter) -> None:
        """Replace the protocol in the record; a checkpoint of the one before is removed, for it fits no longer."""
        if text != self.origin.protocol:
            self.forget()
            self.origin = replace(self.origin, protocol=text)
            writer.set_protocol(text)

    def forget(self) -> None:
        """Remove the checkpoint, if there is one; the next is written at once."""
        self.path.unlink(missing_ok=True)
        self._due = 0.0


def save(path: Path, saved: Saved) -> None:
    """Write a checkpoint atomically."""
    cursor = asdict(saved.checkpoint.cursor)
    zeroings = [asdict(one) | {"kinds": sorted(one.kinds)} for one in saved.zeroings]
    plain = {
        "origin": asdict(saved.origin),
        "cursor": cursor,
        "lengths": dict(saved.lengths),
        "zeroings": zeroings,
        "seconds": saved.seconds,
    }
    with whole_file(path) as temporary:
        with new_hdf5(temporary) as file:
            file.attrs["layout"] = LAYOUT
            file["plain"] = json.dumps(plain)
            store(file.create_group("state"), saved.checkpoint.state)
            store(file.create_group("solver_state"), saved.checkpoint.solver_state)
            file["mounted"] = saved.checkpoint.mounted
            file["severed"] = np.array(saved.checkpoint.severed, dtype=np.int64)
        seal(temporary)


def read_checkpoint(path: Path) -> Saved:
    """Read a checkpoint.

    Raises
    ------
    FormatError
        If the file is no checkpoint, or one of another layout.
    """
    with reading(path, "the checkpoint of a run") as file:
        if file.attrs["layout"] != LAYOUT:
            raise FormatError(path, 1, f"a checkpoint in layout {LAYOUT}, as of this version")
        plain = json.loads(file["plain"].asstr()[()])
        return Saved(
            origin=Origin(**plain["origin"]),
            checkpoint=Checkpoint(
                cursor=_cursor(plain["cursor"]),
                state=fetch(file["state"], State),
                solver_state=fetch(file["solver_state"], SolverState),
                mounted=file["mounted"][()],
                severed=tuple(int(edge) for edge in file["severed"][()]),
            ),
            lengths=plain["lengths"],
            zeroings=tuple(Zeroing(**one | {"kinds": frozenset(one["kinds"])}) for one in plain["zeroings"]),
            seconds=plain["seconds"],
        )


def _cursor(plain: dict[str, Any]) -> ResumePoint:
    """Rebuild the resume point from plain data."""
    place, last, memory, readings = (plain[name] for name in ("place", "last", "memory", "readings"))
    history = History(**memory["history"] | {"free": tuple(memory["history"]["free"])})
    return ResumePoint(
        **plain
        | {
            "memory": Memory(**memory | {"history": history}),
            "readings": None if readings is None else Readings(**readings),
            "place": None if place is None else PathPosition(**place),
            "last": None if last is None else Equilibrium(**last),
        }
    )


def require_same(path: Path, then: Facts, now: Facts) -> None:
    """Raise unless versions and numbers are those that the run was started with.

    Raises
    ------
    FormatError
        Naming the first fact that has changed.
    """
    for name in sorted({*then, *now}):
        if then.get(name) != now.get(name):
            raise FormatError(path, 1, f"{name} = {now.get(name)} as there is now, found {then.get(name)} as it began")

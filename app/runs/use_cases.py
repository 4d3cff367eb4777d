"""Entry points of command line, service and Python: run a protocol into a run folder, resume a run."""

from __future__ import annotations

import sys
from contextlib import contextmanager, suppress
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Final

from app.file_names import file_stem
from app.records.checkpoint import CHECKPOINT, read_checkpoint, require_same
from app.records.folder import RECORD, make_run_folder, remove_unfinished
from app.records.layout import reaches
from app.records.lock import locked
from app.records.reader import RunReader
from app.runs.compile_ahead import compiling_beside
from app.runs.publishing import RunResult
from app.runs.runner import make_task, mount_specimen, quiet, reopen, resume, run_from_start
from app.runs.stopped import kept_in
from app.schemas import load, loads
from app.views.drawing import draw_here
from knitlab_core.errors import FormatError, SpecificationError
from knitlab_core.jit import CACHE_FOLDER, cache_is_cold

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from app.records.checkpoint import Saved
    from app.runs.publishing import Progress
    from app.runs.runner import Watch
    from app.schemas import Loaded, Source
    from app.schemas.document import Data
    from app.views.drawing import Draw
    from rigs.record import Outcome

__all__ = ["RunResult", "has_ended", "resume_run", "run_protocol"]

RUNS: Final = Path("runs")

FIRST_RUN: Final = (
    "compiling the solver for this machine: takes about a minute, once; the result is kept for later runs\n"
)

EVERY_RUN: Final = "compiling the solver for this machine: takes about a minute\n"
"""Message where no cache can be kept."""


def run_protocol(
    source: Source,
    out: Path | str | None = None,
    progress: Progress = quiet,
    watch: Watch | None = None,
    *,
    exact: bool = False,
    chosen: Mapping[str, Data] | None = None,
    draw: Draw | None = draw_here,
    began: float | None = None,
) -> RunResult:
    """Run a protocol: record, log, plot and pictures in a run folder.

    Parameters
    ----------
    source : Path, str, Protocol or Loaded
        Path of the protocol file, or the protocol.
    out : Path, str or None
        Run folder to make, under the next free name; None for one under ``runs/``.
    progress : callable, optional
        Told the share done [1] and what is being done.
    watch : callable or None
        Told number, row and strains [1] of every equilibrium.
    exact : bool
        Run in `out` itself, whatever else is in it but a run that can be gone on with.
    chosen : Mapping, optional
        Values for some parameters of the file, in the place of its own.
    draw : callable or None
        Begins to draw the plot and the knit; None for no pictures.
    began : float, optional
        When the run began, on the clock of `perf_counter` [s]; by itself now.

    Returns
    -------
    RunResult
        How it ended; a limit, an interrupt and a solver that gave up are outcomes, with their rows kept.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the protocol, in one line.
    SpecificationError
        If there is a run in the exact folder.
    """
    began = perf_counter() if began is None else began
    loaded = load(source, chosen).one_test()
    wanted = RUNS / file_stem(loaded.protocol.name) if out is None else Path(out)
    with compiling():
        rig, state = mount_specimen(loaded)
        with kept_in(wanted):
            folder = _exactly(wanted) if exact else make_run_folder(wanted)
        with kept_in(folder), locked(folder):
            return run_from_start(make_task(loaded, folder, began, progress, watch, draw=draw), rig, state)


def resume_run(
    run: Path | str,
    progress: Progress = quiet,
    watch: Watch | None = None,
    *,
    draw: Draw | None = draw_here,
    began: float | None = None,
    found: Callable[[RunReader], None] = lambda _: None,
) -> RunResult:
    """Resume a run that was killed or interrupted from its last checkpoint, with the same rows as an unbroken run.

    Without a checkpoint, or if the record was being written when the run was killed and cannot be read, it starts
    from the beginning in the same folder. A run that has ended is left as it is.

    Parameters
    ----------
    run : Path or str
        The run folder, or its ``run.h5``.
    progress : callable, optional
        Told the share done [1] and what is being done.
    watch : callable or None
        Told number, row and strains [1] of every equilibrium from there.
    draw : callable or None
        Begins to draw the plot and the knit; None for no pictures.
    began : float, optional
        When it began, on the clock of `perf_counter` [s]; by itself now.
    found : callable, optional
        Told the record of the sessions before, if it can be read, before anything is changed.

    Returns
    -------
    RunResult
        How it ended; without figures if it had ended before.

    Raises
    ------
    FormatError
        If the record is none, or the run was begun with other versions or numbers than there are now.
    SpecificationError
        If another process is at it.
    """
    began = perf_counter() if began is None else began
    folder = _folder(run)
    with kept_in(folder), locked(folder):
        remove_unfinished(folder)
        saved = read_checkpoint(folder / CHECKPOINT) if (folder / CHECKPOINT).exists() else None
        record = _readable(folder / RECORD, saved)
        if record is not None:
            found(record)
        if record is not None and record.outcome.end != "abort":
            return reopen(record, saved, progress, draw=draw)
        loaded = _as_begun(folder / RECORD, record, saved)
        task = make_task(loaded, folder, began, progress, watch, draw=draw)
        with compiling():
            if record is None:
                _set_aside(folder / RECORD)
            if record is None or saved is None or not reaches(folder / RECORD, saved.lengths):
                sys.stderr.write(f"{folder}: no checkpoint to go on from: starts from the beginning\n")
                return run_from_start(task, *mount_specimen(loaded))
            require_same(task.checkpoint, saved.origin.facts, task.origin.facts)
            return resume(task, saved, record.trace)


def has_ended(run: Path | str | RunReader) -> Outcome | None:
    """Return how a run ended, by its folder, its record's path or its record; None if it can be resumed."""
    path = run.path if isinstance(run, RunReader) else _folder(run) / RECORD
    if path.with_name(CHECKPOINT).exists():
        return None
    outcome = run.outcome if isinstance(run, RunReader) else RunReader(path).outcome
    return None if outcome.end == "abort" else outcome


def _folder(run: Path | str) -> Path:
    """Return the folder of a run, which may be named by its record too."""
    path = Path(run)
    return path.parent if path.name == RECORD else path


@contextmanager
def compiling() -> Iterator[None]:
    """Announce that the first run compiles, and compile in two processes where that can help."""
    if cache_is_cold():
        sys.stderr.write(EVERY_RUN if CACHE_FOLDER is None else FIRST_RUN)
    with compiling_beside():
        yield


def _exactly(folder: Path) -> Path:
    """Create a folder, or reuse one that holds no run with rows."""
    folder.mkdir(parents=True, exist_ok=True)
    found = (folder / CHECKPOINT).exists()
    with suppress(FileNotFoundError, FormatError):
        RunReader(folder / RECORD)
        found = True
    if found:
        raise SpecificationError("out", str(folder), "a folder without a run; `knitlab resume` goes on with one")
    return folder


def _readable(path: Path, saved: Saved | None) -> RunReader | None:
    """Open a record; None if it cannot be read but a checkpoint identifies its run."""
    try:
        return RunReader(path)
    except (FormatError, FileNotFoundError):
        if saved is None:
            raise
        return None


def _set_aside(path: Path) -> None:
    """Rename a record that cannot be read, so that a new run does not overwrite it."""
    with suppress(FileNotFoundError):
        path.replace(path.with_name(f"damaged-{path.name}"))


def _as_begun(path: Path, record: RunReader | None, saved: Saved | None) -> Loaded:
    """Read the protocol that a run was started with."""
    if saved is not None:
        origin = saved.origin
        if record is not None and (record.protocol, record.materials) != (origin.protocol, origin.materials):
            raise FormatError(path, 1, f"the record that {path.with_name(CHECKPOINT)} belongs to: another protocol")
        return loads(origin.protocol, str(path), name=origin.name, materials=origin.materials)
    if record is None:
        raise FormatError(path, 1, "the record of a run")
    return loads(record.protocol, str(path), name=str(record.provenance["name"]), materials=record.materials)

"""Process of one job: lock its folder, run or resume its test, write the result.

Kept light: the process imports this first, and the solver only once it holds the folder.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
import traceback
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from app.file_lock import LockedError
from app.records.folder import RECORD
from app.records.storage import fault_of
from app.service.folder import JobFolder, Result
from app.service.jobs import Progress
from app.service.processes import end_with_parent, leave_terminal, when_asked
from app.service.row_file import RowFile, restore
from knitlab_core.errors import FormatError, KnitlabError
from knitlab_core.threads import use_threads

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from multiprocessing.synchronize import Event

    from app.records.reader import RunReader
    from app.runs.use_cases import RunResult
    from rigs.analysis.material_limits import MaterialLimit
    from rigs.axes import Axis
    from rigs.record import Equilibrium

TROUBLE, STOPPED, LOCKED = 74, 75, 76
"""Exit codes: this host cannot keep files; asked to stop, work kept; another process holds the folder."""

_SECONDS_BETWEEN_REPORTS: Final = 0.2
_MOST_LOSSES: Final = 100


class StopAskedError(Exception):
    """Stop the solver because the supervisor asked for it."""


def work(folder: str, threads: int = 1, stop: Event | None = None) -> None:
    """Work on a job until it ends or is stopped; the result says how, not the exit code.

    Parameters
    ----------
    folder : str
        The job's folder.
    threads : int
        Threads of its solver.
    stop : Event, optional
        Set when the job shall stop, where SIGTERM cannot say it.
    """
    use_threads(threads)
    files = JobFolder(Path(folder))
    leave_terminal()
    end_with_parent(LOCKED)
    _work_in(files, stop)


def _work_in(files: JobFolder, stop: Event | None = None) -> None:
    """Work in a job's folder; exit with one of the exit codes if the job has not ended."""
    try:
        _redirect_output(files.log)
        with files.lock():
            if files.result() is None:
                _attempt(files, stop)
    except LockedError:
        sys.exit(LOCKED)
    except StopAskedError:
        _log("stopped; what is done is kept")
        sys.exit(STOPPED)
    except (OSError, RuntimeError) as error:
        if fault_of(error) is None:
            raise
        _log(f"cannot go on here: {error}")
        sys.exit(TROUBLE)


def _attempt(files: JobFolder, stop: Event | None) -> None:
    """Run the job's test, from its checkpoint if it has one, and write the result."""
    watch = _Watch(files)
    when_asked(watch.ask_to_stop, stop)
    _log(f"process {os.getpid()} begins")
    try:
        ended = _test(files, watch)
    except StopAskedError:
        raise
    except KnitlabError as error:
        _end(files, Result(end="error", message=str(error), failed=True))
    except MemoryError:
        _end(files, Result(end="memory", message="the system has no memory left", failed=True))
    except BaseException as error:
        if fault_of(error) is not None:
            raise
        # The trace is for the operator of the service: clients are not shown hidden files.
        (files.path / ".crash").write_text(traceback.format_exc(), encoding="utf-8")
        sys.stderr.write(f"{type(error).__name__}: {error}\n")
        raise SystemExit(1) from error
    else:
        failed = ended.outcome == "diverged"
        files.write_figures(ended.figures)
        _end(files, Result(end=ended.outcome, message=ended.message, failed=failed))


def _test(files: JobFolder, watch: _Watch) -> RunResult:
    """Run or resume the test; start again if earlier attempts left nothing to resume."""
    from app.records.checkpoint import CHECKPOINT  # noqa: PLC0415
    from app.runs.use_cases import resume_run, run_protocol  # noqa: PLC0415
    from app.schemas import loads  # noqa: PLC0415
    from app.views.drawing import draw_here  # noqa: PLC0415
    from rigs.analysis.material_limits import limits_of  # noqa: PLC0415

    spec = files.read_spec()
    loaded = loads(spec.protocol, "protocol.yaml", name=spec.name, materials=spec.materials)
    watch.limits = limits_of(loaded.protocol.specimen)
    draw = draw_here if spec.pictures else None
    if any((files.run / name).exists() for name in (RECORD, CHECKPOINT)):
        earlier = partial(_report_earlier, files, watch, going_on=(files.run / CHECKPOINT).exists())
        try:
            ended = resume_run(files.run, watch.progress, watch.row, draw=draw, found=earlier)
        except (FormatError, FileNotFoundError) as error:
            # Versions differ after an upgrade: the test is run again from its start.
            _log(f"begins again: {error}")
        else:
            if not watch.over:
                _log(f"the test ended: {ended.outcome}")
            return ended
    with suppress(FileNotFoundError):
        shutil.rmtree(files.run)  # where it cannot be removed now, the job is given back
    watch.begin_again()
    ended = run_protocol(loaded, files.run, watch.progress, watch.row, exact=True, draw=draw)
    _log(f"the test ended: {ended.outcome}")
    return ended


def _report_earlier(files: JobFolder, watch: _Watch, record: RunReader, *, going_on: bool) -> None:
    """Report how far earlier attempts came, from their record."""
    from rigs.analysis.clasps import count_clasps  # noqa: PLC0415

    restore(files.rows_file, record)
    watch.crossings = {one.limit.name: one.data() for one in record.crossings}
    watch.clasps = count_clasps(record.trace, record.size)
    watch.over = record.outcome.end != "abort"
    if watch.over:
        _log("its test has ended; the files are left to make")
    elif going_on:
        _log("goes on from its checkpoint")


def _end(files: JobFolder, result: Result) -> None:
    """Write how the job ended, the result first, so that a kill in between does not end it twice."""
    files.write_result(result)
    _log(f"{'failed' if result.failed else 'done'}: {result.end}{': ' if result.message else ''}{result.message}")


class _Watch:
    """Observer of a run that writes rows and progress, and raises once a stop was asked for."""

    def __init__(self, files: JobFolder) -> None:
        self._files = files
        self._stop = False
        self.limits: Sequence[MaterialLimit] = ()
        self.begin_again()
        self._began = time.monotonic()
        self._ran_before = files.ran()
        self._reported = 0.0
        self._first_share: float | None = None
        self._last = Progress()
        self._rows: RowFile | None = None
        self._phase = ""

    def begin_again(self) -> None:
        """Forget what happened in the test so far."""
        from rigs.analysis.clasps import ClaspCount  # noqa: PLC0415 (NumPy, only once the folder is held)

        self.crossings: dict[str, dict[str, Any]] = {}
        self.clasps = ClaspCount()
        self.over = False

    def ask_to_stop(self) -> None:
        """Note that the job shall stop; the solver is left at the next report."""
        self._stop = True

    def row(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> None:
        """Write an equilibrium."""
        if self._rows is None:
            self._rows = RowFile(self._files.rows_file, number)
        self._rows.append(number, row, strain)
        self._note_limits(number, row, strain)
        for loss in self.clasps.note_row(number, row, strain):
            _log(f"row {number}: let go: {loss}")
        self._last = Progress(strain=_plain(strain), force=_plain(row.force), rows=number + 1)
        if self._phase != (phase := f"{row.phase} {row.cycle}"):
            self._phase = phase
            _log(f"row {number}: {phase}")

    def _note_limits(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> None:
        """Record the material limits that a row is the first to pass."""
        for limit in self.limits:
            if row.fibre_strain > limit.strain and limit.name not in self.crossings:
                crossing = limit.crossed(number, row, strain)
                self.crossings[limit.name] = crossing.data()
                _log(f"row {number}: beyond strength: {crossing}")

    def progress(self, share: float, text: str) -> None:
        """Write the progress at intervals, and at the end."""
        if self._stop:
            raise StopAskedError
        now = time.monotonic()
        if now - self._reported < _SECONDS_BETWEEN_REPORTS and share < 1.0:
            return
        self._reported, spent = now, now - self._began
        if self._first_share is None:
            self._first_share = share
        gone = share - self._first_share
        progress = Progress(
            share=share,
            text=text,
            strain=self._last.strain,
            force=self._last.force,
            seconds_left=spent * (1.0 - share) / gone if gone > 0.0 else None,
            rows=self._last.rows,
            crossings=tuple(self.crossings.values()),
            losses=tuple(loss.data() for loss in self.clasps.losses[:_MOST_LOSSES]),
        )
        self._files.write_progress(progress, self._ran_before + spent)


def _redirect_output(log: Path) -> None:
    """Redirect this process's output to the job's log."""
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    for stream in (1, 2):
        os.dup2(descriptor, stream)
    os.close(descriptor)
    sys.stdout = sys.stderr = os.fdopen(2, "w", buffering=1, closefd=False)


def _log(text: str) -> None:
    with suppress(OSError):  # a full disk must not fail the job for a line of its log
        sys.stderr.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")


def _plain(values: Mapping[Axis, float]) -> dict[str, float]:
    return {str(axis): value for axis, value in values.items()}

"""Error of a run that a disk fault stopped: what was kept, and how to resume."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

from app.records.folder import RECORD
from app.records.storage import fault_of
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class RunStoppedError(OSError):
    """A run could not write its files: the fault, what its folder keeps, and how to resume."""


@contextmanager
def kept_in(folder: Path) -> Iterator[None]:
    """Turn disk faults in this block into an error that says what the run's folder keeps.

    Raises
    ------
    RunStoppedError
        For a fault of the host.
    """
    try:
        yield
    except (OSError, RuntimeError) as error:
        number = fault_of(error)
        if isinstance(error, RunStoppedError) or number is None:
            raise
        raise RunStoppedError(number, f"{_reason(number, error, folder)}; {_kept(folder)}", str(folder)) from error


def _reason(number: int, error: BaseException, folder: Path) -> str:
    """Return the fault, and the file it concerns if that is known and in the folder."""
    named = error.filename if isinstance(error, OSError) else None
    file = ".." if named is None else os.path.relpath(os.fsdecode(named), folder)
    return f"{'' if file.startswith('.') else f'{file}: '}{os.strerror(number).lower()}"


def _kept(folder: Path) -> str:
    """Return what was recorded of a run, and how to get the rest."""
    from app.records.reader import RunReader  # noqa: PLC0415 (the command line imports this module at its start)

    go_on = f"when that is mended go on with: knitlab resume {folder}"
    try:
        run = RunReader(folder / RECORD)
    except OSError as error:
        lost = isinstance(error, FileNotFoundError)
        return "nothing was recorded" if lost else f"what was recorded cannot be read now; {go_on}"
    except KnitlabError:
        return "nothing was recorded"
    if run.going_on:
        return f"{len(run.trace)} rows kept; {go_on}"
    return f"the test is over and its {len(run.trace)} rows are kept, log or pictures are missing; {go_on}"

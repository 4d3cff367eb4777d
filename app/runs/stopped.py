"""Report a run that a fault of the host's disk stopped: what it kept, and how it goes on."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

from app.records.folder import RECORD
from app.records.reader import RunReader
from app.records.storage import fault_of
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class RunStoppedError(OSError):
    """Report that a run could not keep its files: which fault, what it kept in which folder, and how it goes on."""


@contextmanager
def kept_in(folder: Path) -> Iterator[None]:
    """Say of a fault of the host what the run in a folder has kept.

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
    """Return what happened, and to which file if it is known and one in the folder."""
    named = error.filename if isinstance(error, OSError) else None
    file = ".." if named is None else os.path.relpath(os.fsdecode(named), folder)
    return f"{'' if file.startswith('.') else f'{file}: '}{os.strerror(number).lower()}"


def _kept(folder: Path) -> str:
    """Return what there is of a run, and what to do about the rest."""
    go_on = f"when that is mended go on with: knitlab resume {folder}"
    try:
        run = RunReader(folder / RECORD)
    except (KnitlabError, OSError):
        return "nothing was recorded"
    if run.going_on:
        return f"{len(run.trace)} rows kept; {go_on}"
    return f"the test is over and its {len(run.trace)} rows are kept, log or pictures are missing; {go_on}"

"""Tell faults of the host's disks from faults of a test, and say what a run that met one has kept."""

from __future__ import annotations

import errno
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""No room: of the disk, of the user's share, of what one file may have."""

_FORBIDDEN: Final = (errno.EACCES, errno.EPERM)
_FAULTS: Final = (*FULL, errno.EROFS, errno.EIO, errno.ESTALE)


class RunStoppedError(OSError):
    """Report that a run could not keep its files: which fault, what it kept in which folder, and how it goes on."""


def fault_of(error: BaseException) -> int | None:
    """Return the number of a fault of the host while files are read or written; None for any other error.

    h5py says some numbers in words alone, and raises some of these errors as RuntimeError.
    """
    if not isinstance(error, OSError | RuntimeError):
        return None
    known = (*_FAULTS, *_FORBIDDEN)
    if isinstance(error, OSError) and error.errno is not None:
        return error.errno if error.errno in known else None
    return next((number for number in known if os.strerror(number) in str(error)), None)


def is_unwritable(error: OSError) -> bool:
    """Tell whether a file could not be written whoever asks; a user who may not is another matter."""
    return error.errno in _FAULTS


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
    from app.carry_out import RECORD  # noqa: PLC0415 (which imports what imports this)
    from app.run_reader import RunReader  # noqa: PLC0415
    from knitlab_core.errors import KnitlabError  # noqa: PLC0415

    go_on = f"when that is mended go on with: knitlab resume {folder}"
    try:
        run = RunReader(folder / RECORD)
    except (KnitlabError, OSError):
        return "nothing was recorded"
    if run.going_on:
        return f"{len(run.trace)} rows kept; {go_on}"
    return f"the test is over and its {len(run.trace)} rows are kept, log or pictures are missing; {go_on}"

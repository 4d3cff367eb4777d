"""Opening of HDF5 files for reading; a damaged or foreign file is reported in one line."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import h5py

from app.records.seal import require_intact
from app.records.staged_file import StagedFile, is_between
from app.records.storage import fault_of
from knitlab_core.errors import FormatError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

DAMAGED: Final = (
    OSError,
    LookupError,
    TypeError,
    ValueError,
    RuntimeError,
    AttributeError,
    ArithmeticError,
    MemoryError,
)
"""What h5py, and code that uses what it read, raise of a file that is not what was written."""


@contextmanager
def reading(path: Path, what: str, *, sealed: bool = True) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading, as a context manager.

    Parameters
    ----------
    path : Path
        The file; another process may be writing it.
    what : str
        What is expected, such as ``the record of a run``.
    sealed : bool
        Whether to check the seal, if it has one; needless if it has just been checked.

    Raises
    ------
    OSError
        If it cannot be read at all: it is not there, or this user may not.
    FormatError
        If it is damaged, or another file.
    """
    if sealed:
        require_intact(path, what)
    try:
        if is_between(path):
            with StagedFile(path, writing=False) as whole, h5py.File(whole, "r") as file:
                yield file
        else:
            with h5py.File(path, "r", locking=False) as file:
                yield file
    except DAMAGED as error:
        if (number := fault_of(error)) is not None:
            raise OSError(number, os.strerror(number), str(path)) from error
        raise FormatError(path, 1, f"{what} ({_first_line(error)})") from error


def _first_line(error: BaseException) -> str:
    """Return the first line of an error's message, or the name of its type."""
    return next(iter(str(error).splitlines()), "") or type(error).__name__

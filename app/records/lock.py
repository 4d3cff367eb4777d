"""Exclusive lock of a run folder. The system releases it when the process ends, also when it is killed."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

LOCK: Final = "run.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a run folder for this process, as a context manager.

    Raises
    ------
    SpecificationError
        If another process holds it.
    """
    path = folder / LOCK
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        # The holder before may have removed the file: then the lock of this one protects nothing.
        if not _take(handle) or not path.exists() or not os.path.samestat(os.fstat(handle), path.stat()):
            raise SpecificationError("run", f"{folder}, which another process is writing", "a run that no one writes")
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()
    finally:
        os.close(handle)


def _take(handle: int) -> bool:
    """Lock an open file without waiting; tell whether that succeeded."""
    try:
        if sys.platform == "win32":
            import msvcrt  # noqa: PLC0415 (of one system only)

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl  # noqa: PLC0415 (of the other systems only)

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True

"""Exclusive lock of a run folder. The system releases it when the process ends, also when it is killed."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from app.file_lock import lock
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
        if not lock(handle) or not path.exists() or not os.path.samestat(os.fstat(handle), path.stat()):
            raise SpecificationError("run", f"{folder}, which another process is writing", "a run that no one writes")
        try:
            yield
        finally:
            with suppress(OSError):
                path.unlink()
    finally:
        os.close(handle)

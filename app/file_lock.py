"""Exclusive locks of files. The system releases a lock when its process ends, also when it is killed."""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Any

import portalocker
from portalocker import LockFlags

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class LockedError(Exception):
    """Another process holds the lock.

    Attributes
    ----------
    host, pid : str
        Host and number of that process; ``?`` where the file does not say them.
    """

    def __init__(self, host: str, pid: str) -> None:
        super().__init__(f"process {pid} on {host} holds the lock")
        self.host = host
        self.pid = pid


def lock(handle: int, *, shared: bool = False) -> bool:
    """Lock an open file without waiting; return whether that succeeded. On Windows all locks are exclusive."""
    kind = LockFlags.SHARED if shared and sys.platform != "win32" else LockFlags.EXCLUSIVE
    try:
        portalocker.lock(handle, kind | LockFlags.NON_BLOCKING)
    except portalocker.LockException:
        return False
    return True


def _said(file: IO[bytes]) -> dict[str, Any]:
    """Return what a lock's file says of its holder; nothing where Windows does not let it be read."""
    try:
        file.seek(0)
        return dict(json.loads(file.read() or b"{}"))
    except OSError:
        return {}


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold the lock of a file that says which process has it; the file is made if it is not there.

    Raises
    ------
    LockedError
        If another process holds it.
    """
    with path.open("a+b", buffering=0) as file:
        if not lock(file.fileno()):
            said = _said(file)
            raise LockedError(str(said.get("host", "?")), str(said.get("pid", "?")))
        file.truncate(0)
        file.write(json.dumps({"host": socket.gethostname(), "pid": os.getpid()}).encode())
        yield


def holder(path: Path) -> int | None:
    """Return the process on this host that holds the lock of a file; None if there is none, or it is elsewhere."""
    try:
        with path.open("rb") as file:
            if not lock(file.fileno(), shared=True):
                said = _said(file)
                return int(said["pid"]) if said.get("host") == socket.gethostname() else None
    except FileNotFoundError:
        pass
    return None

"""Exclusive locks of files. The system releases a lock when its process ends, also when it is killed."""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

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
    """Lock an open file without waiting; return whether that succeeded. Windows has no shared locks."""
    try:
        if sys.platform == "win32":
            import msvcrt  # noqa: PLC0415 (of one system only)

            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl  # noqa: PLC0415 (of the other systems only)

            fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


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
            file.seek(0)
            said = json.loads(file.read() or b"{}")
            raise LockedError(str(said.get("host", "?")), str(said.get("pid", "?")))
        file.truncate(0)
        file.write(json.dumps({"host": socket.gethostname(), "pid": os.getpid()}).encode())
        yield


def holder(path: Path) -> int | None:
    """Return the process on this host that holds the lock of a file; None if there is none, or it is elsewhere."""
    try:
        with path.open("rb") as file:
            if not lock(file.fileno(), shared=True):
                said = json.loads(file.read() or b"{}")
                return int(said["pid"]) if said.get("host") == socket.gethostname() else None
    except FileNotFoundError:
        pass
    return None

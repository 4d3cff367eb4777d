"""A helper process of our own beside this one; it ends when this process ends, also when that is killed."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from queue import Queue
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


def import_path(environment: Mapping[str, str]) -> str:
    """Return the ``PYTHONPATH`` with which a process of our own imports the same packages as this one."""
    home = str(Path(__file__).parents[1])
    return os.pathsep.join(filter(None, (home, environment.get("PYTHONPATH"))))


def start(module: str) -> subprocess.Popen[bytes] | None:
    """Start a module that calls `listen`, with pipes to and from it; None where the system refuses.

    Ctrl-C in a terminal does not reach it, since its result is needed after an interrupt too.
    """
    try:
        return subprocess.Popen(  # noqa: S603 (our own interpreter and module)
            [sys.executable, "-P", "-m", module],
            env={**os.environ, "PYTHONPATH": import_path(os.environ)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
    except OSError:
        return None


def end(process: subprocess.Popen[bytes]) -> None:
    """End a process and wait until it is gone."""
    process.kill()
    with suppress(OSError):
        process.communicate()


class Copy:
    """A copy of this process that does one thing and ends; it ends too when this one does.

    On Linux alone: elsewhere libraries may not be used in a copy. The copy has no other threads than the caller's.
    """

    def __init__(self, work: Callable[[], None]) -> None:
        alive, self._held = os.pipe()
        self._pid = os.fork()
        if self._pid:
            os.close(alive)
            return
        os.close(self._held)
        threading.Thread(target=_end_with, args=(alive,), daemon=True).start()
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)

    def ended_well(self) -> bool:
        """Wait for the end of the copy; tell whether its work was done."""
        _, status = os.waitpid(self._pid, 0)
        os.close(self._held)
        return os.waitstatus_to_exitcode(status) == 0


def _end_with(alive: int) -> None:
    """End this process when nobody holds the other end of a pipe."""
    os.read(alive, 1)
    os._exit(1)


def listen() -> Queue[bytes]:
    """Return the stream of lines sent to this process; the process ends when that stream closes."""
    lines: Queue[bytes] = Queue()

    def pass_on() -> None:
        for line in sys.stdin.buffer:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=pass_on, daemon=True).start()
    return lines

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
    from collections.abc import Mapping


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


def listen() -> Queue[bytes]:
    """Return the stream of lines sent to this process; the process ends when that stream closes."""
    lines: Queue[bytes] = Queue()

    def pass_on() -> None:
        for line in sys.stdin.buffer:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=pass_on, daemon=True).start()
    return lines

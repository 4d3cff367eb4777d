"""Processes of jobs: how they are started, asked to stop and ended, on systems with and without fork and signals."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing import connection
from typing import TYPE_CHECKING, Final

import psutil

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.context import ForkServerContext, SpawnContext
    from multiprocessing.process import BaseProcess
    from multiprocessing.synchronize import Event

HAS_SESSIONS: Final = hasattr(os, "setsid") and hasattr(os, "killpg")
"""Whether a process can lead a session of its own, and a signal reach all of it; not so on Windows."""


def start_method() -> SpawnContext | ForkServerContext:
    """Return the start method: forked from a server with compiled kernels on Linux, spawned elsewhere."""
    if sys.platform != "linux" or not hasattr(os, "fork"):
        return multiprocessing.get_context("spawn")
    # Otherwise Python looks for our modules in the working folder first.
    os.environ["PYTHONSAFEPATH"] = "1"
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["app.cli.main", "app.service.warm"])
    return context


def stop_event(context: SpawnContext | ForkServerContext) -> Event | None:
    """Return what tells a process to stop where SIGTERM would end it at once; None where it would not."""
    return None if HAS_SESSIONS else context.Event()


def ask_to_stop(process: BaseProcess, stop: Event | None) -> None:
    """Ask a job's process to stop at its next checkpoint."""
    if stop is not None:
        stop.set()
    else:
        _signal(process, signal.SIGTERM)


def end_tree(process: BaseProcess) -> None:
    """End a job's process at once, with all that it started."""
    if HAS_SESSIONS:
        _signal(process, signal.SIGKILL)
        return
    with suppress(psutil.NoSuchProcess):
        first = psutil.Process(process.pid)
        for one in (*first.children(recursive=True), first):
            with suppress(psutil.NoSuchProcess):
                one.kill()


def end_process(number: int) -> None:
    """End the process of a number at once, if there is one."""
    with suppress(psutil.NoSuchProcess):
        psutil.Process(number).kill()


def resident_memory(process: BaseProcess) -> int:
    """Return the memory a process holds [bytes]; 0 if it is gone."""
    with suppress(psutil.Error):
        return int(psutil.Process(process.pid).memory_info().rss)
    return 0


def how_it_ended(code: int) -> str:
    """Return in words how a process ended abnormally."""
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"


def leave_terminal() -> None:
    """Leave the terminal's group, so that Ctrl-C in the server's terminal does not reach this process."""
    if HAS_SESSIONS:
        os.setsid()


def when_asked(note: Callable[[], None], stop: Event | None) -> None:
    """Call a function when this process is asked to stop.

    SIGINT too: it reaches a whole process group, and must not end a test.
    """
    signal.signal(signal.SIGINT, lambda *_: note())
    if stop is None:
        signal.signal(signal.SIGTERM, lambda *_: note())
    else:

        def wait() -> None:
            stop.wait()
            note()

        threading.Thread(target=wait, name="knitlab-stop", daemon=True).start()


def end_with_parent(code: int) -> None:
    """End this process, with an exit code, when the supervisor ends, without which nothing watches it.

    The parent by kinship is the fork server, so the supervisor's end shows on a pipe only. On Linux its hang-up
    sends SIGIO, whose default is to die: that works while a kernel keeps the interpreter from running.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    pipe = parent.sentinel
    try:
        import fcntl  # noqa: PLC0415 (not on Windows)

        die = fcntl.F_SETOWN, os.O_ASYNC, signal.SIGIO
    except (ImportError, AttributeError):
        threading.Thread(target=lambda: (connection.wait([pipe]), os._exit(code)), daemon=True).start()
        return
    own, asynchronous, hung_up = die
    signal.signal(hung_up, signal.SIG_DFL)
    fcntl.fcntl(pipe, own, os.getpid())
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | asynchronous)
    if connection.wait([pipe], timeout=0.0):
        os._exit(code)


def _signal(process: BaseProcess, number: signal.Signals) -> None:
    """Send a signal to a job's process and all that it started."""
    if process.pid is None:
        return
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, number)
        return
    with suppress(ProcessLookupError):  # it has not made its session yet
        os.kill(process.pid, number)

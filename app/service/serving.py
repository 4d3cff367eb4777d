"""Server process: the API, and a worker with a number of slots, until it is stopped."""

from __future__ import annotations

import logging
import signal
import socket
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import uvicorn

from app.service.api.build import create_app
from app.service.api.connections import BATCH, ConnectionLimiter, Limits, connections_within, watched_by
from app.service.api.context import Context
from app.service.api.guard import require_token_for
from app.service.housekeeping import Housekeeping
from app.service.log import set_up_log
from app.service.settings import settings
from app.service.store import Store
from app.service.worker import Worker, own
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path
    from types import FrameType

    from fastapi import FastAPI

_LAST_ANSWERS: Final = 5
"""Time that open connections get when the service stops [s]."""

_LOOK: Final = 0.2
"""Time between two looks whether to go on [s]."""

_SOON: Final = 0.01

_QUEUE: Final = 1024
"""Connections that the system keeps until they are accepted."""

_OWN_FILES: Final = 128
"""Files that the service has open beside connections: libraries, the database, files that are being sent."""

_FILES_OF_A_SLOT: Final = 8


def serve(
    *,
    host: str,
    port: int,
    slots: int,
    data: Path | None,
    token: str | None,
    limits: Limits,
    keep: float | None = None,
) -> None:
    """Serve until SIGINT or SIGTERM; then running jobs return to the queue, with their checkpoints.

    Parameters
    ----------
    host, port : str, int
        Where to listen; any host but this machine's own needs a token. Port 0 is a free one.
    slots : int
        How many jobs run at once here; 0 leaves them to workers elsewhere.
    data : Path or None
        Data folder; None as `settings` has it.
    token : str or None
        What a client must show.
    limits : Limits
        What it bears of connections.
    keep : float or None
        Time after which ended jobs are deleted [s]; None keeps them.

    Raises
    ------
    SpecificationError
        If other machines could come in without a token, or connections need more files than may be open,
        or nothing would be kept.
    StoreInUseError
        If another process serves the same embedded store.
    OSError
        If the port is taken.
    """
    require_token_for(host, token)
    if keep is not None and keep <= 0.0:
        raise SpecificationError("--keep", f"{keep:g} s", "a time above zero, such as 30d")
    _open_enough(limits, slots)
    set_up_log(logging.WARNING)
    given = settings(data)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with own(given), Store(given) as store, socket.create_server((host, port), family=family) as listener:
        context = Context(store=store, token=token)
        with _answering(create_app(context), listener, limits) as answers:
            house = Housekeeping(store, keep)
            worker = Worker(store, slots) if slots else None
            if worker is not None:
                worker.start()
            try:
                _announce(listener, slots, given.data)
                while answers():
                    time.sleep(_LOOK)
            finally:
                # Streams end while the jobs go back to the queue: one after the other they may pass Docker's 10 s.
                context.closing.set()
                house.stop()
                if worker is not None:
                    worker.drain()


@contextmanager
def _answering(app: FastAPI, listener: socket.socket, limits: Limits) -> Iterator[Callable[[], bool]]:
    """Run the server; yield a function that tells whether it runs; finish open requests at the end.

    The server runs beside the main thread: there it would hand a SIGTERM on, and the process end before its worker
    has put its jobs back.
    """
    config = uvicorn.Config(
        app,
        http=watched_by(ConnectionLimiter(limits)),
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        timeout_graceful_shutdown=_LAST_ANSWERS,
        timeout_keep_alive=limits.idle_timeout,
        backlog=BATCH,
    )
    server = uvicorn.Server(config)

    def ask_to_stop(_signal: int, _frame: FrameType | None) -> None:
        # A second signal stops at once. (No lock is taken here: the interrupted thread may hold it.)
        server.force_exit = server.should_exit
        server.should_exit = True

    before = {one: signal.signal(one, ask_to_stop) for one in (signal.SIGINT, signal.SIGTERM)}
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, name="knitlab-http")
    try:
        thread.start()
        while thread.is_alive() and not server.started:
            time.sleep(_SOON)
        # The server takes few at a time off a queue that it makes as short as that; the system's may be longer.
        listener.listen(_QUEUE)
        yield lambda: thread.is_alive() and not server.should_exit
    finally:
        server.should_exit = True
        thread.join()
        for one, handler in before.items():
            signal.signal(one, handler)


def _open_enough(limits: Limits, slots: int) -> None:
    """Raise the limit on open files to what connections and slots may need.

    Raises
    ------
    SpecificationError
        If the system does not let it.
    """
    try:
        import resource  # noqa: PLC0415 (not on Windows, where connections do not count as files)
    except ImportError:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    own = _OWN_FILES + slots * _FILES_OF_A_SLOT
    needed = limits.files + own
    if soft == resource.RLIM_INFINITY or soft >= needed:
        return
    if hard != resource.RLIM_INFINITY and hard < needed:
        most = connections_within(hard - own)
        allowed = f"{most} or fewer: this process may open {hard} files (ulimit -n)"
        raise SpecificationError("--max-connections", limits.connections, allowed)
    resource.setrlimit(resource.RLIMIT_NOFILE, (needed, hard))


def _announce(listener: socket.socket, slots: int, data: Path) -> None:
    """Print the address of the service."""
    host, port = listener.getsockname()[:2]
    address = f"http://{f'[{host}]' if ':' in host else host}:{port}"
    sys.stderr.write(f"knitlab serves on {address}, {slots} slots, data in {data}; documentation at {address}/docs\n")
    sys.stderr.flush()

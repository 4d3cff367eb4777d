"""Serve: the API, and with it a worker of so many slots, until told to stop."""

from __future__ import annotations

import signal
import socket
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import uvicorn

from app.service.api.build import create_app
from app.service.api.context import Context
from app.service.api.guard import require_token_for
from app.service.settings import settings
from app.service.store import Store
from app.service.worker import Worker, own

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path
    from types import FrameType

    from fastapi import FastAPI

_LAST_ANSWERS: Final = 5
"""Time that open connections get when the service stops [s]."""

_LOOK: Final = 0.2
"""Time between two looks whether to go on [s]."""

_MOST_CONNECTIONS: Final = 1000


def serve(*, host: str, port: int, slots: int, data: Path | None, token: str | None) -> None:
    """Serve until SIGINT or SIGTERM; then jobs that run go back to the queue, with their checkpoints.

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

    Raises
    ------
    SpecificationError
        If other machines could come in without a token.
    StoreInUseError
        If another process serves the same embedded store.
    OSError
        If the port is taken.
    """
    require_token_for(host, token)
    given = settings(data)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with own(given), Store(given) as store, socket.create_server((host, port), family=family) as listener:
        context = Context(store=store, token=token)
        with _answering(create_app(context), listener) as answers:
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
                if worker is not None:
                    worker.drain()


@contextmanager
def _answering(app: FastAPI, listener: socket.socket) -> Iterator[Callable[[], bool]]:
    """Answer requests, lend whether they are still answered, and in the end give open ones their last answers.

    The server runs beside the main thread: there it would hand a SIGTERM on, and the process end before its worker
    has put its jobs back.
    """
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        lifespan="off",
        timeout_graceful_shutdown=_LAST_ANSWERS,
        limit_concurrency=_MOST_CONNECTIONS,
    )
    server = uvicorn.Server(config)

    def ask_to_stop(_signal: int, _frame: FrameType | None) -> None:
        # The second time it is meant. (No lock is taken here: whom the signal interrupts may hold it.)
        server.force_exit = server.should_exit
        server.should_exit = True

    before = {one: signal.signal(one, ask_to_stop) for one in (signal.SIGINT, signal.SIGTERM)}
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, name="knitlab-http")
    try:
        thread.start()
        yield lambda: thread.is_alive() and not server.should_exit
    finally:
        server.should_exit = True
        thread.join()
        for one, handler in before.items():
            signal.signal(one, handler)


def _announce(listener: socket.socket, slots: int, data: Path) -> None:
    """Say where the service is."""
    host, port = listener.getsockname()[:2]
    address = f"http://{f'[{host}]' if ':' in host else host}:{port}"
    sys.stderr.write(f"knitlab serves on {address}, {slots} slots, data in {data}; documentation at {address}/docs\n")
    sys.stderr.flush()

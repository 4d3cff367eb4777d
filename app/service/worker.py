"""Take jobs from the queue, a number at a time, until told to leave."""

from __future__ import annotations

import json
import logging
import os
import socket
import threading
import uuid
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from app.service.deliveries import listen, stop_listening
from app.service.pulse import LEASE, Pulse
from app.service.supervisor import GRACE, Supervisor
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.service.settings import Settings
    from app.service.store import Store

_EMBEDDED: Final = "embedded"
_log: Final = logging.getLogger(__name__)


class StoreInUseError(KnitlabError):
    """Report that another process serves an embedded store."""


class Worker:
    """Run the jobs of a store in this process's children.

    Parameters
    ----------
    store : Store
        Where the jobs are; if embedded, `own` must hold it.
    slots : int
        How many jobs run at once.
    lease : float
        Silence after which other workers take this one for dead [s].
    """

    def __init__(self, store: Store, slots: int, lease: float = LEASE) -> None:
        self._store = store
        self._slots = slots
        self._lease = lease
        self._supervisor = Supervisor(store)
        self._pulse: Pulse | None = None
        self._changing = threading.Lock()
        self._left = False

    def start(self) -> None:
        """Get the kernels ready, then take jobs; returns at once, the rest happens in threads."""
        threading.Thread(target=self._start, name="knitlab-start", daemon=True).start()

    def drain(self) -> None:
        """Take no more jobs, let those that run stop at a checkpoint, queue them again; takes seconds."""
        self._supervisor.draining.set()
        with self._changing:
            self._left = True
            self._leave()
        self._supervisor.close()

    def _start(self) -> None:
        self._supervisor.get_ready()
        with self._changing:
            if not self._left:
                self._join()

    def _join(self) -> None:
        """Become a worker of the store, under an id that no worker had before."""
        store, embedded = self._store, self._store.settings.embedded
        worker = _EMBEDDED if embedded else f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:8]}"
        if not embedded:
            self._pulse = Pulse(store, worker, self._slots, self._lease, self._reborn)
        listen(self._supervisor.deliver, store.engine, store.settings.database, worker, self._slots)
        _log.info("worker %s takes jobs, %d at a time", worker, self._slots)

    def _leave(self) -> None:
        stop_listening(round(GRACE) + 4)
        if self._pulse is not None:
            self._pulse.stop()

    def _reborn(self) -> None:
        """Drop everything and begin anew: others took this worker for dead, and its jobs with it."""
        _log.warning("taken for dead; beginning anew")
        self._supervisor.draining.set()
        with self._changing:
            if not self._left:
                self._leave()
                self._supervisor.draining.clear()
                self._join()


@contextmanager
def own(settings: Settings) -> Iterator[None]:
    """Hold an embedded store for this process alone; a store in a server's database is open to all.

    Raises
    ------
    StoreInUseError
        If another process holds it.
    """
    if not settings.embedded:
        yield
        return
    import fcntl  # noqa: PLC0415 (not on Windows)

    settings.data.mkdir(parents=True, exist_ok=True)
    with (settings.data / "lock").open("a+b", buffering=0) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            file.seek(0)
            who = json.loads(file.read() or b"{}")
            raise StoreInUseError(
                f"{settings.data}: process {who.get('pid', '?')} on {who.get('host', '?')} serves this store; "
                "one server per store, or KNITLAB_DB for many"
            ) from error
        file.truncate(0)
        file.write(json.dumps({"host": socket.gethostname(), "pid": os.getpid()}).encode())
        yield

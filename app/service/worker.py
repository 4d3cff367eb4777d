"""Worker: takes jobs from the queue, a number at a time, until it is stopped."""

from __future__ import annotations

import logging
import os
import socket
import threading
import uuid
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Final

from app.file_lock import LockedError, held
from app.service.deliveries import listen, stop_listening
from app.service.heartbeat import LEASE, Heartbeat, requeue_lost
from app.service.supervisor import GRACE, Supervisor
from app.service.tables import AWAY, first_line
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from app.service.settings import Settings
    from app.service.store import Store

_EMBEDDED: Final = "embedded"
_SECONDS_BETWEEN_TRIES: Final = 5.0
_SECONDS_BETWEEN_LOOKS: Final = 60.0
_log: Final = logging.getLogger(__name__)


class StoreInUseError(KnitlabError):
    """Another process serves an embedded store."""


class Worker:
    """Worker that runs the jobs of a store in child processes.

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
        # A second thread pays only where a processor would be idle.
        self._supervisor = Supervisor(store, threads=2 if 2 * slots <= (os.cpu_count() or 1) else 1)
        self._heartbeat: Heartbeat | None = None
        self._changing = threading.Lock()
        self._left = threading.Event()

    def start(self) -> None:
        """Compile the kernels, then take jobs; returns at once, the rest happens in threads."""
        threading.Thread(target=self._start, name="knitlab-start", daemon=True).start()
        threading.Thread(target=self._recover, name="knitlab-recovery", daemon=True).start()

    def drain(self) -> None:
        """Take no more jobs, stop running ones at a checkpoint and requeue them; takes seconds."""
        self._left.set()
        self._supervisor.draining.set()
        with self._changing:
            self._leave()
        self._supervisor.close()

    def _start(self) -> None:
        self._retry(self._supervisor.get_ready)
        self._retry(self._join)

    def _retry(self, do: Callable[[], None]) -> None:
        """Retry an action that the worker depends on until it succeeds or the worker has left."""
        while not self._left.is_set():
            try:
                do()
            except Exception as error:  # noqa: BLE001 (else the process would live on and never take a job)
                _log.exception("cannot take jobs yet: %s; trying again", first_line(error))
                self._left.wait(_SECONDS_BETWEEN_TRIES)
            else:
                return

    def _join(self) -> None:
        """Register as a worker of the store, under a new id."""
        store, embedded = self._store, self._store.settings.embedded
        worker = _EMBEDDED if embedded else f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:8]}"
        with self._changing:
            if self._left.is_set():
                return
            if not embedded:
                self._heartbeat = Heartbeat(store, worker, self._slots, self._lease, self._rejoin)
            try:
                listen(self._supervisor.deliver, store.engine, store.settings.database, worker, self._slots)
            except Exception:
                self._leave()
                raise
        _log.info("worker %s takes jobs, %d at a time", worker, self._slots)

    def _leave(self) -> None:
        stop_listening(round(GRACE) + 4)
        if self._heartbeat is not None:
            self._heartbeat.stop()
            self._heartbeat = None

    def _rejoin(self) -> None:
        """Register again after other workers took this one for dead and its jobs with it."""
        _log.warning("other workers took this one for dead; registering again")
        self._supervisor.draining.set()
        with self._changing:
            if self._left.is_set():
                return
            self._leave()
            self._supervisor.draining.clear()
        self._retry(self._join)

    def _recover(self) -> None:
        """Requeue lost jobs at intervals."""
        while not self._left.is_set():
            try:
                requeue_lost(self._store)
            except AWAY as error:
                _log.warning("cannot look after the queue: %s", first_line(error))
            except Exception:  # noqa: BLE001 (the next look may go well)
                _log.exception("cannot look after the queue")
            self._left.wait(_SECONDS_BETWEEN_LOOKS)


@contextmanager
def own(settings: Settings) -> Iterator[None]:
    """Lock an embedded store for this process; a store in a database server is shared.

    Raises
    ------
    StoreInUseError
        If another process holds it.
    """
    if not settings.embedded:
        yield
        return
    settings.data.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        try:
            stack.enter_context(held(settings.data / "lock"))
        except LockedError as error:
            raise StoreInUseError(
                f"{settings.data}: process {error.pid} on {error.host} serves this store; "
                "one server per store, or KNITLAB_DB for many"
            ) from error
        yield

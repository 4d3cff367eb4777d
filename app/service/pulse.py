"""Beat, notice workers whose heart has stopped, and queue what they had taken again."""

from __future__ import annotations

import logging
import socket
import threading
from typing import TYPE_CHECKING, Final

import sqlalchemy as sa

from app.service.deliveries import take_back, takers
from app.service.tables import database_now, workers

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.service.store import Store

LEASE: Final = 15.0
"""Silence after which a worker counts as dead [s]."""

_log: Final = logging.getLogger(__name__)


class Pulse:
    """Keep a worker alive in the store.

    Parameters
    ----------
    store : Store
        The store it works for.
    worker : str
        Its id, fresh at every start.
    slots : int
        How many jobs it runs at once.
    lease : float
        Silence after which a worker counts as dead [s].
    on_lost : callable
        Called once if others took this worker for dead: it was frozen, or cut off.
    """

    def __init__(self, store: Store, worker: str, slots: int, lease: float, on_lost: Callable[[], None]) -> None:
        self._store = store
        self._worker = worker
        self._lease = lease
        self._on_lost = on_lost
        self._stopped = threading.Event()
        self._now = database_now(store.engine)
        with store.engine.begin() as connection:
            connection.execute(
                sa.insert(workers).values(id=worker, host=socket.gethostname(), slots=slots, beat=self._now)
            )
        self._thread = threading.Thread(target=self._beat, name="knitlab-pulse", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Leave the store; what is still taken counts as a dead worker's."""
        self._stopped.set()
        if self._thread is not threading.current_thread():
            self._thread.join()
        with self._store.engine.begin() as connection:
            connection.execute(sa.delete(workers).where(workers.c.id == self._worker))

    def _beat(self) -> None:
        while not self._stopped.wait(self._lease / 6.0):
            try:
                alive = sa.update(workers).where(workers.c.id == self._worker).values(beat=self._now)
                with self._store.engine.begin() as connection:
                    known = connection.execute(alive).rowcount
                if not known:
                    self._on_lost()
                    return
                bury(self._store, self._lease)
            except sa.exc.OperationalError as error:
                _log.warning("no heartbeat: %s", str(error.orig).splitlines()[0])


def bury(store: Store, lease: float) -> int:
    """Queue again what workers took that are silent for longer than the lease [s] or unknown; return how much."""
    with store.engine.begin() as connection:
        silent = workers.c.beat < database_now(store.engine) - lease
        connection.execute(sa.delete(workers).where(silent))
        living = set(connection.scalars(sa.select(workers.c.id)))
    count = 0
    for dead in takers(store.client) - living:
        count += take_back(store.client, dead)
    return count

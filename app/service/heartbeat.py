"""Heartbeats of workers, and recovery of jobs whose worker is dead."""

from __future__ import annotations

import logging
import socket
import threading
from typing import TYPE_CHECKING, Final

import sqlalchemy as sa

from app.service.deliveries import AGAIN, delivery_id, enqueue, forgotten, take_back, takers
from app.service.tables import AWAY, database_now, first_line, hold, jobs, workers

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.service.store import Store

LEASE: Final = 15.0
"""Silence after which a worker counts as dead [s]."""

_OPEN: Final = ("queued", "running", "cancelling")
"""States of jobs that a delivery is to end."""

_log: Final = logging.getLogger(__name__)


class Heartbeat:
    """Heartbeat of a worker in the store.

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
        self._until = database_now(store.engine) + lease
        with store.engine.begin() as connection:
            connection.execute(
                sa.insert(workers).values(id=worker, host=socket.gethostname(), slots=slots, until=self._until)
            )
        self._thread = threading.Thread(target=self._beat, name="knitlab-heartbeat", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Leave the store; deliveries still taken count as a dead worker's."""
        self._stopped.set()
        if self._thread is not threading.current_thread():
            self._thread.join()
        try:
            with self._store.engine.begin() as connection:
                connection.execute(sa.delete(workers).where(workers.c.id == self._worker))
        except AWAY as error:
            _log.warning("cannot sign off: %s; the lease ends by itself", first_line(error))

    def _beat(self) -> None:
        while not self._stopped.wait(self._lease / 6.0):
            try:
                alive = sa.update(workers).where(workers.c.id == self._worker).values(until=self._until)
                with self._store.engine.begin() as connection:
                    known = connection.execute(alive).rowcount
                if not known:
                    self._on_lost()
                    return
                requeue_dead(self._store)
            except AWAY as error:
                _log.warning("no heartbeat: %s", first_line(error))
            except Exception:  # noqa: BLE001 (without a heartbeat others would take its jobs while it runs them)
                _log.exception("no heartbeat")


def requeue_dead(store: Store) -> int:
    """Requeue the deliveries of workers that are unknown or silent for longer than their lease; return how many."""
    with store.engine.begin() as connection:
        connection.execute(sa.delete(workers).where(workers.c.until < database_now(store.engine)))
        living = set(connection.scalars(sa.select(workers.c.id)))
    count = 0
    for dead in takers(store.client) - living:
        count += take_back(store.client, dead)
    return count


def requeue_lost(store: Store) -> int:
    """Requeue jobs that the queue has lost, as after a fault of the service; return how many."""
    rows = sa.select(jobs.c.id, jobs.c.delivery).where(jobs.c.state.in_(_OPEN))
    orphans: list[sa.Row[tuple[str, int]]] = forgotten(
        store.client, rows, jobs.c.id + "." + sa.cast(jobs.c.delivery, sa.Text)
    )
    return sum(_requeue(store, orphan.id, orphan.delivery) for orphan in orphans)


def _requeue(store: Store, job: str, delivery: int) -> bool:
    """Requeue one job unless it was changed in the meantime."""
    with store.engine.begin() as connection:
        row = hold(connection, job)
        if row is None or row.delivery != delivery or row.state not in _OPEN:
            return False
        # A job that is being cancelled stays so: its next delivery ends it.
        state = "cancelling" if row.state == "cancelling" else "queued"
        values = {"state": state, "owner": None, "delivery": delivery + 1}
        connection.execute(sa.update(jobs).where(jobs.c.id == job).values(values))
        enqueue(store.client, connection, delivery_id(job, delivery + 1), AGAIN)
    _log.warning("job %s: the queue no longer knew it; queued again", job)
    return True

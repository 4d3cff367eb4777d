"""Leases of jobs: only the latest holder of a job may end it."""

from __future__ import annotations

import logging
import time
import uuid
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeVar

import sqlalchemy as sa

from app.service.deliveries import AGAIN, delivery_id, enqueue, read_delivery_id
from app.service.tables import AWAY, CANCELLED, first_line, hold, jobs

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable, Iterable

    from app.service.folder import Result
    from app.service.store import Store

Asked = Literal["cancel", "pause", "lost"]

_log: Final = logging.getLogger(__name__)
_ResultT = TypeVar("_ResultT")
_SECONDS_BETWEEN_TRIES: Final = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """Order of the store to a running job: its owner, its state and whether it is to pause."""

    owner: str | None
    state: str
    wanted: str | None

    def to(self, owner: str) -> Asked | None:
        """Return what a run has to do by the order."""
        if self.owner != owner:
            return "lost"
        if self.state == "cancelling":
            return "cancel"
        return "pause" if self.wanted == "pause" else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Lease:
    """The right to run a job.

    While the database is away its calls wait; once the service leaves they raise what the database raised.

    Attributes
    ----------
    store : Store
        Where the job is kept.
    job : str
        Its id.
    delivery : int
        Number of the delivery that is being run.
    owner : str
        Token of this run; a later run of the job puts its own in place.
    leaving : threading.Event
        Set once the service leaves.
    """

    store: Store
    job: str
    delivery: int
    owner: str
    leaving: threading.Event

    def asked(self) -> Asked | None:
        """Return the store's order to this run now."""
        return self.retrying(lambda: orders(self.store, [self.job])[self.job]).to(self.owner)

    def begin(self) -> None:
        """Count an attempt."""
        self._update({"attempts": jobs.c.attempts + 1})

    def crashed(self) -> int | None:
        """Count a crash and return how many there were; None if the lease is lost."""
        ours = self._update({"crashes": jobs.c.crashes + 1})
        query = sa.select(jobs.c.crashes).where(jobs.c.id == self.job)
        return self.retrying(lambda: self._scalar(query)) if ours else None

    def settle(self, result: Result) -> None:
        """Record the end of the job."""
        state = "failed" if result.failed else "cancelled" if result.end == "cancelled" else "succeeded"
        settled = {"state": state, "end": result.end, "message": result.message, "finished": time.time()}
        self._update({**settled, "wanted": None, "owner": None})

    def release(self) -> None:
        """Give up a job that has not ended.

        It is cancelled or paused if that is asked; else queued again, before those that have not begun.
        """

        def let_go() -> None:
            with self.store.engine.begin() as connection:
                row = hold(connection, self.job)
                if row is None or row.owner != self.owner:
                    return
                values: dict[str, object] = {"owner": None, "wanted": None}
                if row.state == "cancelling":
                    values |= CANCELLED | {"finished": time.time()}
                elif row.wanted == "pause":
                    values |= {"state": "paused"}
                else:
                    values |= {"state": "queued", "delivery": self.delivery + 1}
                    enqueue(self.store.client, connection, delivery_id(self.job, self.delivery + 1), AGAIN)
                connection.execute(sa.update(jobs).where(jobs.c.id == self.job).values(values))

        self.retrying(let_go)

    def retrying(self, do: Callable[[], _ResultT]) -> _ResultT:
        """Retry a database action until the database answers, so that results are not lost."""
        return _retrying(do, self.leaving)

    def _update(self, values: dict[str, object]) -> bool:
        """Update the job if the lease is still held."""
        mine = sa.update(jobs).where(jobs.c.id == self.job, jobs.c.owner == self.owner)
        running = mine.where(jobs.c.state.in_(("running", "cancelling")))

        def change() -> bool:
            with self.store.engine.begin() as connection:
                return bool(connection.execute(running.values(values)).rowcount)

        return self.retrying(change)

    def _scalar(self, query: sa.Select[int]) -> int | None:
        with self.store.engine.begin() as connection:
            return connection.execute(query).scalar()


def take_lease(store: Store, delivery: str, leaving: threading.Event) -> Lease | None:
    """Take the lease of a delivered job; None if nothing is left to do for this delivery."""
    job, number = read_delivery_id(delivery)
    owner = uuid.uuid4().hex
    this = sa.update(jobs).where(jobs.c.id == job, jobs.c.delivery == number)
    now = time.time()
    begun = {"state": "running", "owner": owner, "started": sa.func.coalesce(jobs.c.started, now)}

    def take() -> bool:
        with store.engine.begin() as connection:
            if connection.execute(this.where(jobs.c.state.in_(("queued", "running"))).values(begun)).rowcount:
                return True
            # The worker that was to cancel it died before.
            connection.execute(this.where(jobs.c.state == "cancelling").values(CANCELLED | {"finished": now}))
            return False

    if not _retrying(take, leaving):
        return None
    return Lease(store=store, job=job, delivery=number, owner=owner, leaving=leaving)


def orders(store: Store, running: Iterable[str]) -> dict[str, Order]:
    """Return the store's orders to running jobs; a deleted job has no owner."""
    asked = list(running)
    query = sa.select(jobs.c.id, jobs.c.owner, jobs.c.state, jobs.c.wanted).where(jobs.c.id.in_(asked))
    with store.engine.begin() as connection:
        found = {row.id: row for row in connection.execute(query)}
    gone = {job: Order(owner=None, state="deleted", wanted=None) for job in asked}
    return gone | {job: Order(owner=row.owner, state=row.state, wanted=row.wanted) for job, row in found.items()}


def _retrying(do: Callable[[], _ResultT], leaving: threading.Event) -> _ResultT:
    while True:
        try:
            return do()
        except AWAY as error:
            _log.warning("database: %s; trying again", first_line(error))
            if leaving.is_set():
                raise
            leaving.wait(_SECONDS_BETWEEN_TRIES)

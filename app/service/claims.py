"""Hold a job while one delivery of it runs: only the latest holder may settle it."""

from __future__ import annotations

import logging
import time
import uuid
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import sqlalchemy as sa

from app.service.deliveries import AGAIN, delivery_id, enqueue, read_delivery_id
from app.service.tables import jobs

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from app.service.folder import Result
    from app.service.store import Store

_log: Final = logging.getLogger(__name__)
ResultT = TypeVar("ResultT")
_SECONDS_BETWEEN_TRIES: Final = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """Say what the store wants of a running job: its owner, its state and whether it shall pause."""

    owner: str | None
    state: str
    wanted: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """Stand for the right to run a job.

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
    """

    store: Store
    job: str
    delivery: int
    owner: str

    def begin(self) -> None:
        """Count an attempt."""
        self._update({"attempts": jobs.c.attempts + 1})

    def crashed(self) -> int:
        """Count a crash and return how many there were."""
        self._update({"crashes": jobs.c.crashes + 1})
        query = sa.select(jobs.c.crashes).where(jobs.c.id == self.job)
        return int(patiently(lambda: self._scalar(query)) or 0)

    def settle(self, result: Result) -> None:
        """Finish the job for good."""
        state = "failed" if result.failed else "cancelled" if result.end == "cancelled" else "succeeded"
        settled = {"state": state, "end": result.end, "message": result.message, "finished": time.time()}
        self._update({**settled, "wanted": None, "owner": None})

    def rest(self) -> None:
        """Leave the job paused; if it was cancelled meanwhile, cancelled."""
        if not self._update({"state": "paused", "wanted": None, "owner": None}, states=("running",)):
            self._update({"state": "cancelled", "end": "cancelled", "finished": time.time(), "owner": None})

    def give_back(self) -> None:
        """Queue the job again, before those that have not begun."""

        def again() -> None:
            with self.store.engine.begin() as connection:
                values = {"state": "queued", "owner": None, "delivery": self.delivery + 1}
                if connection.execute(self._mine(("running",)).values(values)).rowcount:
                    enqueue(self.store.client, connection, delivery_id(self.job, self.delivery + 1), AGAIN)

        patiently(again)

    def _mine(self, states: Iterable[str]) -> sa.Update:
        mine = jobs.c.owner == self.owner
        return sa.update(jobs).where(jobs.c.id == self.job, mine, jobs.c.state.in_(tuple(states)))

    def _update(self, values: dict[str, object], states: Iterable[str] = ("running", "cancelling")) -> bool:
        """Change the job if it is still ours."""

        def change() -> bool:
            with self.store.engine.begin() as connection:
                return bool(connection.execute(self._mine(states).values(values)).rowcount)

        return patiently(change)

    def _scalar(self, query: sa.Select[int]) -> int | None:
        with self.store.engine.begin() as connection:
            return connection.execute(query).scalar()


def claim(store: Store, delivery: str) -> Claim | None:
    """Take a delivered job; None if there is nothing left to do for this delivery."""
    job, number = read_delivery_id(delivery)
    owner = uuid.uuid4().hex
    this = sa.update(jobs).where(jobs.c.id == job, jobs.c.delivery == number)
    now = time.time()
    begun = {"state": "running", "owner": owner, "started": sa.func.coalesce(jobs.c.started, now)}
    ended = {"state": "cancelled", "end": "cancelled", "finished": now, "owner": None}

    def take() -> bool:
        with store.engine.begin() as connection:
            if connection.execute(this.where(jobs.c.state.in_(("queued", "running"))).values(begun)).rowcount:
                return True
            # Whoever was asked to cancel it died first.
            connection.execute(this.where(jobs.c.state == "cancelling").values(ended))
            return False

    return Claim(store=store, job=job, delivery=number, owner=owner) if patiently(take) else None


def orders(store: Store, running: Iterable[str]) -> dict[str, Order]:
    """Return what the store wants of jobs that run."""
    query = sa.select(jobs.c.id, jobs.c.owner, jobs.c.state, jobs.c.wanted).where(jobs.c.id.in_(list(running)))
    with store.engine.begin() as connection:
        return {row.id: Order(owner=row.owner, state=row.state, wanted=row.wanted) for row in connection.execute(query)}


def patiently(do: Callable[[], ResultT]) -> ResultT:
    """Do something in the database, again and again while it cannot be reached: results do not get lost."""
    while True:
        try:
            return do()
        except sa.exc.OperationalError as error:
            _log.warning("database: %s; trying again", str(error.orig).splitlines()[0])
            time.sleep(_SECONDS_BETWEEN_TRIES)

"""Whoever holds a job alone may change it, and no wish for it is lost, however they meet."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa

from app.service.deliveries import delivery_id
from app.service.folder import Result
from app.service.heartbeat import Heartbeat, requeue_dead, requeue_lost
from app.service.jobs import JobSpec
from app.service.leases import take_lease
from app.service.tables import hold, jobs, workers
from app.service.worker import Worker

if TYPE_CHECKING:
    from app.service.jobs import Job
    from app.service.leases import Lease
    from app.service.store import Store

SPEC = JobSpec(name="a", protocol="text: of a protocol\n")
DONE = Result(end="target", message="", failed=False)


def taken(store: Store, job: Job, number: int = 1) -> Lease:
    held = take_lease(store, delivery_id(job.id, number), threading.Event())
    assert held is not None
    return held


def deliveries(store: Store) -> set[str]:
    table = "workflow_status" if store.settings.embedded else "dbos.workflow_status"
    with store.engine.begin() as connection:
        return set(connection.scalars(sa.text(f"SELECT workflow_uuid FROM {table} WHERE status = 'ENQUEUED'")))  # noqa: S608


def test_a_job_that_is_let_go_of_is_queued_again(store: Store) -> None:
    job = store.submit(SPEC)
    taken(store, job).release()
    assert store.get(job.id).state == "queued"
    assert deliveries(store) == {f"{job.id}.1", f"{job.id}.2"}
    assert take_lease(store, f"{job.id}.1", threading.Event()) is None
    taken(store, job, 2)


def test_a_job_that_is_let_go_of_follows_what_was_asked(store: Store) -> None:
    cancelled, paused, resumed = (store.submit(SPEC) for _ in range(3))
    held = [taken(store, job) for job in (cancelled, paused, resumed)]
    assert store.cancel(cancelled.id).state == "cancelling"
    store.pause(paused.id)
    store.pause(resumed.id)
    store.resume(resumed.id)  # after its run has decided to pause
    for one in held:
        one.release()
    assert [store.get(job.id).state for job in (cancelled, paused, resumed)] == ["cancelled", "paused", "queued"]
    assert store.resume(paused.id).wanted is None
    assert taken(store, paused, 2).asked() is None


@pytest.mark.parametrize(
    ("wish", "state"), [("cancel", "cancelled"), ("pause", "paused"), ("resume", "queued")], ids=lambda one: one
)
def test_a_wish_waits_for_a_job_that_changes_just_then(store: Store, wish: str, state: str) -> None:
    """A run lets go of its job while somebody asks for something: neither may overlook the other."""
    job = store.submit(SPEC)
    held = taken(store, job)
    asking = threading.Thread(target=getattr(store, wish), args=(job.id,))
    with store.engine.begin() as connection:
        hold(connection, job.id)
        asking.start()
        asking.join(0.3)
        assert asking.is_alive()
        after = "paused" if wish == "resume" else "queued"
        this = sa.update(jobs).where(jobs.c.id == job.id)
        connection.execute(this.values(state=after, owner=None, delivery=held.delivery + 1))
    asking.join()
    assert store.get(job.id).state == state


def test_a_run_that_was_overtaken_changes_nothing(store: Store) -> None:
    job = store.submit(SPEC)
    old = taken(store, job)
    new = taken(store, job)
    assert (old.asked(), new.asked()) == ("lost", None)
    assert old.crashed() is None
    old.begin()
    old.settle(Result(end="crash", message="", failed=True))
    old.release()
    now = store.get(job.id)
    # The attempt that is shown is the one that begins; none has been counted.
    assert (now.state, now.attempts) == ("running", 1)
    with store.engine.begin() as connection:
        assert connection.scalar(sa.select(jobs.c.attempts)) == 0
    new.settle(DONE)
    assert store.get(job.id).state == "succeeded"


def test_what_the_queue_has_forgotten_is_queued_again(store: Store) -> None:
    queued, running, cancelling, waiting, done = (store.submit(SPEC) for _ in range(5))
    old = taken(store, running)
    taken(store, cancelling)
    store.cancel(cancelling.id)
    taken(store, done).settle(DONE)
    for job in (queued, running, cancelling, done):
        store.client.cancel_workflow(delivery_id(job.id, 1))
    assert requeue_lost(store) == 3
    assert requeue_lost(store) == 0
    assert deliveries(store) == {f"{waiting.id}.1", *(f"{job.id}.2" for job in (queued, running, cancelling))}
    assert old.asked() == "lost"
    assert take_lease(store, f"{cancelling.id}.2", threading.Event()) is None
    states = [store.get(job.id).state for job in (queued, running, cancelling, waiting, done)]
    assert states == ["queued", "queued", "cancelled", "queued", "succeeded"]


def test_each_worker_is_dead_by_its_own_lease(store: Store) -> None:
    job = store.submit(SPEC)
    slow = Heartbeat(store, "slow", 1, lease=60.0, on_lost=lambda: None)
    with store.engine.begin() as connection:
        connection.execute(sa.insert(workers).values(id="dead", host="h", slots=1, until=0.0))
        table = "workflow_status" if store.settings.embedded else "dbos.workflow_status"
        connection.execute(sa.text(f"UPDATE {table} SET status = 'PENDING', executor_id = 'slow'"))  # noqa: S608
    assert requeue_dead(store) == 0
    with store.engine.begin() as connection:
        assert set(connection.scalars(sa.select(workers.c.id))) == {"slow"}
    slow.stop()
    assert requeue_dead(store) == 1
    assert deliveries(store) == {f"{job.id}.1"}


def test_a_worker_insists_until_it_works(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.service.worker._SECONDS_BETWEEN_TRIES", 0.01)
    worker, tries = Worker(store, slots=1), []

    def work() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise sa.exc.OperationalError("", None, ConnectionError("away"))

    worker._retry(work)
    assert len(tries) == 3

"""Deliveries of jobs in DBOS's queue, and recovery of those of dead workers.

DBOS owns the queue: order, who takes what, and that what a dead process had is handed out again.
A *delivery* is one DBOS workflow, ``<job>.<number>``: its id says all, it carries no data. Everything
that leans on DBOS beyond its public interface is in this file, with a contract test.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, TypeVar

import sqlalchemy as sa
from dbos import DBOS, DBOSClient, DBOSConfig

if TYPE_CHECKING:
    from collections.abc import Callable

RowT = TypeVar("RowT", bound=tuple[Any, ...])

APPLICATION: Final = "knitlab"
QUEUE: Final = "knitlab_jobs"
WORKFLOW: Final = "knitlab_job"
VERSION: Final = "1"
"""Contract between queued deliveries and workers. It stays when knitlab changes: else what an older
build queued would wait for ever."""

POLL: Final = 0.25
"""Time between two looks into the queue [s]."""

AGAIN, SINGLE, SWEEP = 5, 10, 20
"""Priorities, small ones first (DBOS counts from 1): what had begun goes first,
and who waits for one job does not wait for a sweep."""


_ALIVE: Final = ("ENQUEUED", "DELAYED", "PENDING")
"""States of deliveries that wait or are being worked on."""

_AT_ONCE: Final = 1000
"""Deliveries that one transaction deletes."""


def delivery_id(job: str, number: int) -> str:
    """Return the id of a job's n-th delivery.

    Examples
    --------
    >>> delivery_id("a1", 3)
    'a1.3'
    """
    return f"{job}.{number}"


def read_delivery_id(delivery: str) -> tuple[str, int]:
    """Return job and number from the id of a delivery.

    Examples
    --------
    >>> read_delivery_id("a1.3")
    ('a1', 3)
    """
    job, number = delivery.rsplit(".", 1)
    return job, int(number)


def open_client(engine: sa.Engine, url: str) -> DBOSClient:
    """Migrate DBOS's tables and return a client on our connections."""
    DBOS.migrate(url)
    return DBOSClient(system_database_engine=engine, application_name=APPLICATION)


def enqueue(client: DBOSClient, connection: sa.Connection, delivery: str, priority: int) -> None:
    """Enqueue a delivery within the caller's transaction."""
    client.enqueue_in_transaction(
        connection,
        {
            "workflow_name": WORKFLOW,
            "queue_name": QUEUE,
            "workflow_id": delivery,
            "app_version": VERSION,
            "priority": priority,
        },
    )


def enqueue_alike(client: DBOSClient, connection: sa.Connection, first: str, others: sa.Select[str]) -> None:
    """Enqueue more deliveries like the first that DBOS enqueued: the same rows under other ids.

    One statement for all of them, where DBOS's own way takes a millisecond each.
    """
    ids = others.subquery()
    (other,) = ids.c
    for table in _tables(client):
        columns = [other if column.name == "workflow_uuid" else column for column in table.c]
        rows = sa.select(*columns).select_from(table).join(ids, table.c.workflow_uuid == first)
        connection.execute(sa.insert(table).from_select(list(table.c.keys()), rows))


def take_back(client: DBOSClient, worker: str) -> int:
    """Return to the queue what a dead worker had taken; harmless if another worker did so before."""
    database = client._sys_db  # noqa: SLF001 (no public call: their paid service does it)
    taken = database.get_pending_workflows(worker, VERSION)
    return sum(database.reenqueue_for_recovery(entry.workflow_id, [worker], QUEUE) for entry in taken)


def takers(client: DBOSClient) -> set[str]:
    """Return the ids of all workers with deliveries that have not ended."""
    status, _ = _tables(client)
    query = sa.select(status.c.executor_id).where(status.c.queue_name == QUEUE, status.c.status == "PENDING")
    with _database(client).begin() as connection:
        return {str(worker) for worker in connection.scalars(query.distinct())}


def forgotten(client: DBOSClient, rows: sa.Select[RowT], delivery: sa.ColumnElement[str]) -> list[sa.Row[RowT]]:
    """Return the rows whose delivery is neither queued nor being worked on."""
    status, _ = _tables(client)
    alive = status.c.status.in_(_ALIVE)
    query = rows.where(~sa.exists().where(status.c.workflow_uuid == delivery, alive))
    with _database(client).begin() as connection:
        return list(connection.execute(query).all())


def forget_ended(client: DBOSClient, before: float) -> int:
    """Delete some deliveries that ended before a moment [s since the epoch]; return how many, 0 when none are left."""
    status, _ = _tables(client)
    ended = status.c.status.not_in(_ALIVE)
    query = sa.select(status.c.workflow_uuid).where(status.c.queue_name == QUEUE, ended)
    with _database(client).begin() as connection:
        ids = list(connection.scalars(query.where(status.c.updated_at < round(1e3 * before)).limit(_AT_ONCE)))
    if ids:
        client.delete_workflows(ids)
    return len(ids)


def _database(client: DBOSClient) -> sa.Engine:
    """Return DBOS's database object on our engine, with its schema."""
    return client._sys_db.engine  # noqa: SLF001 (see the module)


def _tables(client: DBOSClient) -> tuple[sa.Table, sa.Table]:
    tables = client._sys_db.tables  # noqa: SLF001 (see the module)
    return tables.workflow_status, tables.workflow_input


def listen(work: Callable[[str], None], engine: sa.Engine, url: str, worker: str, slots: int) -> None:
    """Start to take deliveries, one a slot; each is worked on in a thread of its own.

    What a worker of the same id had taken when it died is handed out again.
    """
    config: DBOSConfig = {
        "name": APPLICATION,
        "system_database_url": url,
        "system_database_engine": engine,
        "application_version": VERSION,
        "executor_id": worker,
        "run_migrations": False,
        "use_listen_notify": False,
        # No notification is used, but shutdown waits for this thread.
        "notification_listener_polling_interval_sec": 0.5,
        "scheduler_polling_interval_sec": 3600.0,
        "log_level": "ERROR",
    }
    service = DBOS(config=config)

    @DBOS.workflow(name=WORKFLOW, max_recovery_attempts=None)
    def run() -> None:
        work(str(DBOS.workflow_id))

    # A queue in the database would give every worker the same number of slots.
    service._registry._register_internal_queue(QUEUE, worker_concurrency=slots, polling_interval_sec=POLL)  # noqa: SLF001
    DBOS.launch()


def stop_listening(seconds: int) -> None:
    """Take no more deliveries, and wait a given time for those running."""
    DBOS.destroy(destroy_registry=True, workflow_completion_timeout_sec=seconds)

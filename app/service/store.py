"""Store of jobs in SQL: jobs and queue change in one transaction."""

from __future__ import annotations

import hashlib
import logging
import time
import uuid
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final, Self

import sqlalchemy as sa

from app.service.deletion import delete
from app.service.deliveries import SINGLE, SWEEP, delivery_id, enqueue, enqueue_alike, open_client
from app.service.folder import JobFolder, read_as
from app.service.jobs import (
    STATES,
    Job,
    JobSpec,
    KeyReusedError,
    Page,
    PointPage,
    Progress,
    State,
    Sweep,
    SweepPage,
    UnknownJobError,
)
from app.service.sweeps import get_sweep, list_sweeps, rows_of_sweep
from app.service.tables import AWAY, CANCELLED, first_line, hold, jobs, keys, make_tables, open_engine
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from app.service.settings import Settings

    _Row = sa.Row[*tuple[Any, ...]]

_LARGEST_PAGE: Final = 1000


class StoreAwayError(KnitlabError):
    """A database cannot be opened: it does not answer, or its disk is full or read-only."""


class Store:
    """Store of jobs in a database and a data folder; implements `JobStore`.

    Parameters
    ----------
    settings : Settings
        Where both are.

    Raises
    ------
    StoreAwayError
        If the database cannot be used.
    """

    def __init__(self, settings: Settings) -> None:
        logging.getLogger("dbos").setLevel(logging.ERROR)
        self.settings = settings
        try:
            self.engine = open_engine(settings)
            self.client = open_client(self.engine, settings.database)
            make_tables(self.engine)
        except AWAY as error:
            where = settings.data if settings.embedded else "KNITLAB_DB"
            raise StoreAwayError(f"{where}: the database cannot be used: {first_line(error)}") from error

    def submit(self, spec: JobSpec, *, key: str | None = None) -> Job:
        """Accept a job durably; the same key and body return the job accepted before."""
        return self._accept([spec], key, sweep=None)[0]

    def submit_all(self, specs: Sequence[JobSpec], *, key: str | None = None) -> list[Job]:
        """Accept a sweep: all of it or nothing."""
        return self._accept(specs, key, sweep=uuid.uuid4().hex[:12]) if specs else []

    def _accept(self, specs: Sequence[JobSpec], key: str | None, sweep: str | None) -> list[Job]:
        texts = [spec.text() for spec in specs]
        digest = hashlib.sha256("\n".join([str(sweep is None), *texts]).encode()).hexdigest()
        now = time.time()
        rows = [
            {
                "id": uuid.uuid4().hex[:16],
                "name": spec.name,
                "spec": text,
                "sweep": sweep,
                "state": "queued",
                "delivery": 1,
                "created": now,
                "attempts": 0,
                "crashes": 0,
                "message": "",
            }
            for spec, text in zip(specs, texts, strict=True)
        ]
        first = {"job": rows[0]["id"] if sweep is None else None, "sweep": sweep}
        try:
            with self.engine.begin() as connection:
                if key is not None:
                    connection.execute(sa.insert(keys).values(key=key, digest=digest, **first))
                connection.execute(sa.insert(jobs), rows)
                head = str(rows[0]["id"])
                enqueue(self.client, connection, delivery_id(head, 1), SINGLE if sweep is None else SWEEP)
                if len(rows) > 1:
                    others = sa.select(jobs.c.id + delivery_id("", 1)).where(jobs.c.sweep == sweep, jobs.c.id != head)
                    enqueue_alike(self.client, connection, delivery_id(head, 1), others)
        except sa.exc.IntegrityError:
            if key is None:
                raise
            return self._accepted_before(key, digest)
        created = datetime.fromtimestamp(now, UTC)
        return [
            Job(id=str(row["id"]), name=spec.name, state="queued", created=created, sweep=sweep)
            for spec, row in zip(specs, rows, strict=True)
        ]

    def _accepted_before(self, key: str, digest: str) -> list[Job]:
        """Return what was accepted under a key before."""
        with self.engine.begin() as connection:
            before = connection.execute(sa.select(keys).where(keys.c.key == key)).one()
            if before.digest != digest:
                raise KeyReusedError(key)
            which = jobs.c.id == before.job if before.sweep is None else jobs.c.sweep == before.sweep
            rows = connection.execute(sa.select(jobs).where(which).order_by(jobs.c.seq)).all()
        return [self._job(row) for row in rows]

    def get(self, job: str) -> Job:
        """Return a job."""
        with self.engine.begin() as connection:
            return self._job(_row(connection, job))

    def list(
        self, limit: int = 50, cursor: str | None = None, state: State | None = None, sweep: str | None = None
    ) -> Page:
        """Return a page of jobs, newest first."""
        limit = max(1, min(limit, _LARGEST_PAGE))
        query = sa.select(jobs).order_by(jobs.c.seq.desc()).limit(limit + 1)
        if cursor is not None:
            query = query.where(jobs.c.seq < int(cursor))
        if state is not None:
            query = query.where(jobs.c.state == state)
        if sweep is not None:
            query = query.where(jobs.c.sweep == sweep)
        with self.engine.begin() as connection:
            rows = connection.execute(query).all()
        more = len(rows) > limit
        return Page(jobs=tuple(map(self._job, rows[:limit])), cursor=str(rows[limit - 1].seq) if more else None)

    def counts(self, sweep: str | None = None) -> dict[State, int]:
        """Return how many jobs are in each state."""
        query = sa.select(jobs.c.state, sa.func.count()).group_by(jobs.c.state)
        if sweep is not None:
            query = query.where(jobs.c.sweep == sweep)
        with self.engine.begin() as connection:
            found = {row[0]: int(row[1]) for row in connection.execute(query)}
        return {state: found.get(state, 0) for state in STATES}

    def sweeps(self, limit: int = 50, cursor: str | None = None) -> SweepPage:
        """Return a page of sweeps, newest first."""
        return list_sweeps(self.engine, max(1, min(limit, _LARGEST_PAGE)), cursor)

    def sweep(self, sweep: str) -> Sweep:
        """Return a sweep."""
        return get_sweep(self.engine, sweep)

    def points(self, sweep: str, limit: int = 200, cursor: str | None = None) -> PointPage:
        """Return a page of the jobs of a sweep, in the order in which they were accepted."""
        rows, after = rows_of_sweep(self.engine, sweep, max(1, min(limit, _LARGEST_PAGE)), cursor)
        return PointPage(points=tuple((self._job(row), read_as(JobSpec, row.spec)) for row in rows), cursor=after)

    def cancel(self, job: str) -> Job:
        """Ask a job to end."""

        def change(row: _Row, _: sa.Connection) -> dict[str, object]:
            if row.state in {"queued", "paused"}:
                return CANCELLED | {"finished": time.time()}
            return {"state": "cancelling", "wanted": None} if row.state == "running" else {}

        return self._change(job, change)

    def pause(self, job: str) -> Job:
        """Pause a queued or running job at its checkpoint."""
        answers = {"queued": {"state": "paused"}, "running": {"wanted": "pause"}}
        return self._change(job, lambda row, _: answers.get(row.state, {}))

    def resume(self, job: str) -> Job:
        """Queue a paused job again."""

        def change(row: _Row, connection: sa.Connection) -> dict[str, object]:
            if row.state != "paused":
                return {"wanted": None}
            enqueue(self.client, connection, delivery_id(job, row.delivery + 1), SINGLE)
            return {"state": "queued", "wanted": None, "delivery": row.delivery + 1}

        return self._change(job, change)

    def delete(self, job: str) -> None:
        """Delete a job that has ended, and its files."""
        delete(self, job)

    def _change(self, job: str, change: Callable[[_Row, sa.Connection], Mapping[str, object]]) -> Job:
        """Change a job according to its state, in a transaction that has locked its row."""
        with self.engine.begin() as connection:
            row = hold(connection, job)
            if row is None:
                raise UnknownJobError(job)
            values = change(row, connection)
            if values:
                connection.execute(sa.update(jobs).where(jobs.c.id == job).values(**values))
                row = _row(connection, job)
        return self._job(row)

    def spec(self, job: str) -> JobSpec:
        """Return the specification of a job."""
        with self.engine.begin() as connection:
            return read_as(JobSpec, _row(connection, job).spec)

    def folder(self, job: str) -> Path:
        """Return the folder of the job's files."""
        with self.engine.begin() as connection:
            return self.files(_row(connection, job).id).path

    def files(self, job: str) -> JobFolder:
        """Return the files of a job that is known to exist."""
        return JobFolder(self.settings.jobs / job[:2] / job)

    def close(self) -> None:
        """Close the connections to the database."""
        self.client.destroy()
        self.engine.dispose()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _job(self, row: _Row) -> Job:
        fresh = row.state == "queued" and not row.attempts
        return Job(
            id=row.id,
            name=row.name,
            state=row.state,
            created=datetime.fromtimestamp(row.created, UTC),
            started=None if row.started is None else datetime.fromtimestamp(row.started, UTC),
            finished=None if row.finished is None else datetime.fromtimestamp(row.finished, UTC),
            # The first attempt is counted a moment after its job is taken.
            attempts=max(row.attempts, int(row.state in {"running", "cancelling"})),
            end=row.end,
            message=row.message,
            progress=Progress() if fresh else self.files(row.id).progress(),
            sweep=row.sweep,
            wanted=row.wanted,
        )


def _row(connection: sa.Connection, job: str) -> _Row:
    row = connection.execute(sa.select(jobs).where(jobs.c.id == job)).one_or_none()
    if row is None:
        raise UnknownJobError(job)
    return row

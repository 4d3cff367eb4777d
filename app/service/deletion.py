"""Deletion of jobs, their files, and ended deliveries.

A job is deleted in two steps. In one transaction its row goes and a row of `knitlab_deleted` comes: from then on there
is no such job. Then its folder goes, and is looked for once more later. Whoever dies in between leaves the second row,
and the next look goes on from it. No folder is taken for left over because no row knows it: it may be another store's.
"""

from __future__ import annotations

import logging
import shutil
import time
from typing import TYPE_CHECKING, Final, Protocol

import sqlalchemy as sa

from app.service.jobs import FINAL, NotEndedError, UnknownJobError
from app.service.tables import deleted, hold, jobs, keys

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.service.folder import JobFolder

AGAIN: Final = 3600.0
"""Time after which the folder of a deleted job is looked for once more [s]: a host that was frozen may write late."""

_SECONDS_BETWEEN_TRIES: Final = 60.0
_AT_ONCE: Final = 200
"""Jobs that one transaction deletes: others wait for it."""

_log: Final = logging.getLogger(__name__)


class Jobs(Protocol):
    """Database and folders of jobs."""

    engine: sa.Engine

    def files(self, job: str) -> JobFolder:
        """Return the files of a job."""
        ...


def delete(store: Jobs, job: str) -> None:
    """Delete a job that has ended, and its files.

    Raises
    ------
    UnknownJobError
        If there is none of this id.
    NotEndedError
        If it has not ended.
    """
    with store.engine.begin() as connection:
        row = hold(connection, job)
        if row is None:
            raise UnknownJobError(job)
        if row.state not in FINAL:
            raise NotEndedError(job, row.state)
        _delete_rows(connection, [job])
    clear(store, [job])


def purge(store: Jobs, before: float) -> int:
    """Delete some jobs that ended before a moment [s since the epoch]; return how many, 0 when none are left."""
    old = sa.select(jobs.c.id).where(jobs.c.state.in_(FINAL), jobs.c.finished < before)
    with store.engine.begin() as connection:
        # Another server on the same database may be at the others.
        found = list(connection.scalars(old.limit(_AT_ONCE).with_for_update(skip_locked=True)))
        if found:
            _delete_rows(connection, found)
    clear(store, found)
    return len(found)


def _delete_rows(connection: sa.Connection, ids: Sequence[str]) -> None:
    """Delete the rows of jobs that this transaction has locked, and their idempotency keys."""
    now = time.time()
    these = jobs.c.id.in_(ids)
    sweeps = list(connection.scalars(sa.select(jobs.c.sweep).where(these, jobs.c.sweep.is_not(None)).distinct()))
    connection.execute(sa.insert(deleted), [{"id": job, "since": now, "look": now} for job in ids])
    connection.execute(sa.delete(jobs).where(these))
    left = sa.exists().where(jobs.c.sweep == keys.c.sweep)
    connection.execute(sa.delete(keys).where(keys.c.job.in_(ids) | (keys.c.sweep.in_(sweeps) & ~left)))


def clear(store: Jobs, ids: Sequence[str] | None = None) -> int:
    """Remove the folders of deleted jobs: of given ones, or of some that are due; return how many were looked for.

    A folder that cannot be removed is tried again in a minute.
    """
    now = time.time()
    which = deleted.c.look <= now if ids is None else deleted.c.id.in_(ids)
    query = sa.select(deleted.c.id, deleted.c.since).where(which).limit(_AT_ONCE)
    with store.engine.begin() as connection:
        found = connection.execute(query).all()
    looks: dict[float | None, list[str]] = {}
    for job, since in found:
        # Looked for once more, `AGAIN` seconds after the deletion.
        look = since + AGAIN if now < since + AGAIN else None
        try:
            shutil.rmtree(store.files(job).path)
        except FileNotFoundError:
            pass
        except OSError as error:
            _log.warning("job %s: its files are still there: %s; trying again", job, error)
            look = now + _SECONDS_BETWEEN_TRIES
        looks.setdefault(look, []).append(job)
    with store.engine.begin() as connection:
        for look, these in looks.items():
            done = deleted.c.id.in_(these)
            connection.execute(
                sa.delete(deleted).where(done) if look is None else sa.update(deleted).where(done).values(look=look)
            )
    return len(found)

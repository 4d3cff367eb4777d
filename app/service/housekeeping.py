"""Delete jobs and their files, and forget what the queue is done with.

A job is deleted in two steps. In one transaction its row goes and a row of `knitlab_deleted` comes: from then on there
is no such job. Then its folder goes, and is looked for once more later. Whoever dies in between leaves the second row,
and the next look goes on from it. No folder is taken for left over because no row knows it: it may be another store's.
"""

from __future__ import annotations

import logging
import shutil
import threading
import time
from typing import TYPE_CHECKING, Final

import sqlalchemy as sa

from app.service.claims import AWAY, first_line
from app.service.deliveries import forget_ended
from app.service.jobs import FINAL, NotEndedError, UnknownJobError
from app.service.tables import deleted, hold, jobs, keys

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.service.store import Store

AGAIN: Final = 3600.0
"""Time after which the folder of a deleted job is looked for once more [s]: a host that was frozen may write late."""

ENDED: Final = 3600.0
"""Time for which the queue remembers deliveries that have ended [s]."""

_SECONDS_BETWEEN_LOOKS: Final = 60.0
_AT_ONCE: Final = 200
"""Jobs that one transaction deletes: others wait for it."""

_log: Final = logging.getLogger(__name__)


def delete(store: Store, job: str) -> None:
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


def purge(store: Store, before: float) -> int:
    """Delete all jobs that ended before a moment [s since the epoch], and their files; return how many."""
    count = 0
    old = sa.select(jobs.c.id).where(jobs.c.state.in_(FINAL), jobs.c.finished < before)
    while True:
        with store.engine.begin() as connection:
            # Another server on the same database may be at the others.
            found = list(connection.scalars(old.limit(_AT_ONCE).with_for_update(skip_locked=True)))
            if found:
                _delete_rows(connection, found)
        if not found:
            return count
        clear(store, found)
        count += len(found)


def _delete_rows(connection: sa.Connection, ids: Sequence[str]) -> None:
    """Delete the rows of jobs that this transaction holds, and the keys that stand for nothing without them."""
    now = time.time()
    these = jobs.c.id.in_(ids)
    sweeps = list(connection.scalars(sa.select(jobs.c.sweep).where(these, jobs.c.sweep.is_not(None)).distinct()))
    connection.execute(sa.insert(deleted), [{"id": job, "since": now, "look": now} for job in ids])
    connection.execute(sa.delete(jobs).where(these))
    left = sa.exists().where(jobs.c.sweep == keys.c.sweep)
    connection.execute(sa.delete(keys).where(keys.c.job.in_(ids) | (keys.c.sweep.in_(sweeps) & ~left)))


def clear(store: Store, ids: Sequence[str] | None = None) -> None:
    """Remove the folders of jobs that have been deleted: of some, or of all whose time to be looked for has come."""
    now = time.time()
    which = deleted.c.look <= now if ids is None else deleted.c.id.in_(ids)
    with store.engine.begin() as connection:
        found = connection.execute(sa.select(deleted.c.id, deleted.c.since).where(which)).all()
    over: list[str] = []
    later: list[str] = []
    for job, since in found:
        try:
            shutil.rmtree(store.files(job).path)
        except FileNotFoundError:
            pass
        except OSError as error:
            _log.warning("job %s: its files are still there: %s; trying again", job, error)
            continue
        (over if now - since >= AGAIN else later).append(job)
    with store.engine.begin() as connection:
        for part in _parts(over):
            connection.execute(sa.delete(deleted).where(deleted.c.id.in_(part)))
        for part in _parts(later):
            connection.execute(sa.update(deleted).where(deleted.c.id.in_(part)).values(look=deleted.c.since + AGAIN))


def _parts(ids: Sequence[str]) -> list[Sequence[str]]:
    """Return ids in parts that one statement takes."""
    return [ids[k : k + _AT_ONCE] for k in range(0, len(ids), _AT_ONCE)]


class Housekeeping:
    """Look after a store in a thread: finish deletions, delete old jobs, forget ended deliveries.

    Parameters
    ----------
    store : Store
        The store.
    keep : float or None
        Time after which ended jobs are deleted [s]; None keeps them.
    """

    def __init__(self, store: Store, keep: float | None) -> None:
        self._store, self._keep = store, keep
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._look_after, name="knitlab-housekeeping", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Look no more."""
        self._stopped.set()

    def _look_after(self) -> None:
        while not self._stopped.is_set():
            try:
                self._look()
            except AWAY as error:
                _log.warning("cannot keep house: %s", first_line(error))
            except Exception:  # noqa: BLE001 (the next look may go well)
                _log.exception("cannot keep house")
            self._stopped.wait(_SECONDS_BETWEEN_LOOKS)

    def _look(self) -> None:
        now = time.time()
        clear(self._store)
        if self._keep is not None and (count := purge(self._store, now - self._keep)):
            _log.info("%d jobs deleted that ended more than %g days ago", count, self._keep / 86400.0)
        while forget_ended(self._store.client, now - ENDED) and not self._stopped.is_set():
            pass

"""Sweeps as the database has them: the jobs that were accepted together, counted by state."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import sqlalchemy as sa

from app.service.jobs import STATES, Sweep, SweepPage, UnknownSweepError
from app.service.tables import jobs

if TYPE_CHECKING:
    from collections.abc import Sequence

_NUMBER: Final = re.compile(r"-\d+$")
_COUNTS: Final = tuple(sa.func.sum(sa.case((jobs.c.state == state, 1), else_=0)).label(state) for state in STATES)


def list_sweeps(engine: sa.Engine, limit: int, cursor: str | None) -> SweepPage:
    """Return a page of sweeps, newest first; a sweep's place is that of its first job that is left."""
    first = sa.func.min(jobs.c.seq)
    query = _summary().order_by(first.desc()).limit(limit + 1)
    if cursor is not None:
        query = query.having(first < int(cursor))
    with engine.begin() as connection:
        rows = connection.execute(query).all()
        found = _named(connection, rows[:limit])
    return SweepPage(sweeps=tuple(found), cursor=str(rows[limit - 1].first) if len(rows) > limit else None)


def get_sweep(engine: sa.Engine, sweep: str) -> Sweep:
    """Return a sweep.

    Raises
    ------
    UnknownSweepError
        If no job is of it.
    """
    with engine.begin() as connection:
        found = _named(connection, connection.execute(_summary().where(jobs.c.sweep == sweep)).all())
    if not found:
        raise UnknownSweepError(sweep)
    return found[0]


def rows_of_sweep(
    engine: sa.Engine, sweep: str, limit: int, cursor: str | None
) -> tuple[Sequence[sa.Row[*tuple[Any, ...]]], str | None]:
    """Return rows of a sweep's jobs in the order in which they were accepted, and the cursor of those after them."""
    query = sa.select(jobs).where(jobs.c.sweep == sweep).order_by(jobs.c.seq).limit(limit + 1)
    if cursor is not None:
        query = query.where(jobs.c.seq > int(cursor))
    with engine.begin() as connection:
        rows = connection.execute(query).all()
    return rows[:limit], str(rows[limit - 1].seq) if len(rows) > limit else None


def _summary() -> sa.Select[*tuple[Any, ...]]:
    """Return the query of all sweeps with their first jobs and counts."""
    return (
        sa.select(jobs.c.sweep, sa.func.min(jobs.c.seq).label("first"), *_COUNTS)
        .where(jobs.c.sweep.is_not(None))
        .group_by(jobs.c.sweep)
    )


def _named(connection: sa.Connection, rows: Sequence[sa.Row[*tuple[Any, ...]]]) -> list[Sweep]:
    """Return the sweeps of rows of the summary, with names and times of their first jobs."""
    firsts = sa.select(jobs.c.seq, jobs.c.name, jobs.c.created).where(jobs.c.seq.in_([row.first for row in rows]))
    known = {row.seq: row for row in connection.execute(firsts)}
    return [
        Sweep(
            id=row.sweep,
            name=_NUMBER.sub("", known[row.first].name),
            created=datetime.fromtimestamp(known[row.first].created, UTC),
            counts={state: int(getattr(row, state)) for state in STATES},
        )
        for row in rows
    ]

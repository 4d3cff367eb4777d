"""Tables of the store, and connection to its database."""

from __future__ import annotations

import sqlite3
from typing import TYPE_CHECKING, Any, Final

import sqlalchemy as sa

if TYPE_CHECKING:
    from app.service.settings import Settings

AWAY: Final = (sa.exc.OperationalError, sa.exc.InterfaceError, sa.exc.InternalError, sa.exc.TimeoutError)
"""What the database raises while it cannot be reached, or takes no writes for the moment."""

_metadata = sa.MetaData()

#: One row a job. `delivery` numbers its entries in the queue, `owner` is the run that may settle it.
jobs = sa.Table(
    "knitlab_jobs",
    _metadata,
    sa.Column("seq", sa.Integer, primary_key=True, autoincrement=True),
    sa.Column("id", sa.Text, nullable=False, unique=True),
    sa.Column("name", sa.Text, nullable=False),
    sa.Column("spec", sa.Text, nullable=False),
    sa.Column("sweep", sa.Text, index=True),
    sa.Column("state", sa.Text, nullable=False),
    sa.Column("wanted", sa.Text),
    sa.Column("delivery", sa.Integer, nullable=False),
    sa.Column("owner", sa.Text),
    sa.Column("created", sa.Float(53), nullable=False),
    sa.Column("started", sa.Float(53)),
    sa.Column("finished", sa.Float(53)),
    sa.Column("attempts", sa.Integer, nullable=False),
    sa.Column("crashes", sa.Integer, nullable=False),
    sa.Column("end", sa.Text),
    sa.Column("message", sa.Text, nullable=False),
    sa.Index("knitlab_jobs_by_state", "state", "seq"),
)

CANCELLED: Final = {"state": "cancelled", "end": "cancelled", "owner": None}
"""What becomes of a job that is cancelled while no process is at it; `finished` beside it."""

#: Idempotency keys: which body came with a key, and the job or sweep that it became.
keys = sa.Table(
    "knitlab_keys",
    _metadata,
    sa.Column("key", sa.Text, primary_key=True),
    sa.Column("digest", sa.Text, nullable=False),
    sa.Column("job", sa.Text),
    sa.Column("sweep", sa.Text),
)

#: Deleted jobs whose folders may still be there, since when, and when they are looked for next [s since the epoch].
deleted = sa.Table(
    "knitlab_deleted",
    _metadata,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("since", sa.Float(53), nullable=False),
    sa.Column("look", sa.Float(53), nullable=False, index=True),
)

#: Workers, each alive until a moment by the database's clock that its heartbeat puts off.
workers = sa.Table(
    "knitlab_leases",
    _metadata,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("host", sa.Text, nullable=False),
    sa.Column("slots", sa.Integer, nullable=False),
    sa.Column("until", sa.Float(53), nullable=False),
)


def open_engine(settings: Settings) -> sa.Engine:
    """Connect to the database of the settings; make its folder if the database is embedded."""
    if not settings.embedded:
        return sa.create_engine(settings.database, pool_size=8, max_overflow=8, pool_pre_ping=True)
    settings.data.mkdir(parents=True, exist_ok=True)
    engine = sa.create_engine(settings.database, pool_size=8, max_overflow=8)

    @sa.event.listens_for(engine, "connect")
    def _prepare(connection: Any, _record: object) -> None:  # noqa: ANN401 (whatever the driver gives)
        # Writers queue up before they read, so that none finds its view outdated half-way.
        connection.isolation_level = "IMMEDIATE"
        connection.execute("PRAGMA busy_timeout=30000")
        connection.execute("PRAGMA foreign_keys=ON")

    sa.event.listen(engine, "handle_error", _unreadable, retval=True)
    with engine.connect() as connection:
        # Kept in the file: readers and a writer no longer wait for each other.
        connection.execute(sa.text("PRAGMA journal_mode=WAL"))
    return engine


def _unreadable(context: sa.engine.ExceptionContext) -> BaseException | None:
    """Return an error of `AWAY` where SQLite takes its file for damaged: reads that fail look to it like that.

    Its connection is left, for it may hold what it read then; the file may be whole.
    """
    original = context.original_exception
    if type(original) is not sqlite3.DatabaseError:
        return None
    context.is_disconnect = True
    return sa.exc.OperationalError(context.statement, None, original, connection_invalidated=True)


def make_tables(engine: sa.Engine) -> None:
    """Create missing tables; two processes may do so at once."""
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(sa.text("SELECT pg_advisory_xact_lock(7218443)"))
        _metadata.create_all(connection)


def hold(connection: sa.Connection, job: str) -> sa.Row[*tuple[Any, ...]] | None:
    """Lock a job's row for this transaction and return it; None if there is none.

    The update changes nothing. Both databases lock a row so before it is read.
    """
    this = jobs.c.id == job
    connection.execute(sa.update(jobs).where(this).values(id=jobs.c.id))
    return connection.execute(sa.select(jobs).where(this)).one_or_none()


def database_now(engine: sa.Engine) -> sa.ColumnElement[float]:
    """Return the database's clock [s since the epoch], since the clocks of hosts differ."""
    if engine.dialect.name == "postgresql":
        return sa.cast(sa.extract("epoch", sa.func.clock_timestamp()), sa.Float(53))
    return sa.literal_column("(julianday('now') - 2440587.5) * 86400.0", sa.Float(53))


def first_line(error: BaseException) -> str:
    """Return the first line of an error's message, without the SQL statement."""
    said = str(getattr(error, "orig", None) or error) or type(error).__name__
    return said.splitlines()[0]

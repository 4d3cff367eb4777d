"""A deleted job is gone with all that it left, whoever dies or writes late meanwhile."""

from __future__ import annotations

import subprocess
import sys
import threading
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa

from app.service import deletion
from app.service.deletion import clear, purge
from app.service.deliveries import forget_ended
from app.service.folder import Result
from app.service.housekeeping import Housekeeping
from app.service.jobs import FINAL, NotEndedError, UnknownJobError
from app.service.leases import take_lease
from app.service.settings import settings
from app.service.store import Store
from app.service.tables import deleted, jobs, keys
from tests.service.lab import ROOT, TINY, Lab, until

if TYPE_CHECKING:
    from pathlib import Path

    from app.service.jobs import Job


def ended(store: Store, *, key: str | None = None) -> Job:
    """Return a job that has ended and has files."""
    job = store.submit(TINY, key=key)
    files = store.files(job.id)
    files.write_spec(TINY)
    (files.run / "frames").mkdir(parents=True)
    (files.run / "frames" / "1").write_bytes(b"1")
    return store.cancel(job.id)


def count(store: Store, table: sa.Table) -> int:
    with store.engine.begin() as connection:
        return int(connection.scalar(sa.select(sa.func.count()).select_from(table)) or 0)


def test_what_has_ended_is_deleted_with_its_files(store: Store) -> None:
    job, other = ended(store), ended(store)
    store.delete(job.id)
    assert not store.files(job.id).path.exists()
    assert [one.id for one in store.list().jobs] == [other.id]
    assert store.files(other.id).path.exists()
    for ask in (store.get, store.delete, store.folder):
        with pytest.raises(UnknownJobError):
            ask(job.id)


def test_what_has_not_ended_is_not_deleted(store: Store) -> None:
    job = store.submit(TINY)
    for state, wish in (("queued", store.pause), ("paused", store.resume), ("queued", store.resume)):
        with pytest.raises(NotEndedError, match=f"found {state}, allowed .* cancel it first"):
            store.delete(job.id)
        wish(job.id)
    held = take_lease(store, f"{job.id}.2", threading.Event())
    assert held is not None
    for state in ("running", "cancelling"):
        with pytest.raises(NotEndedError, match=state):
            store.delete(job.id)
        store.cancel(job.id)
    held.settle(Result(end="cancelled", message="", failed=False))
    store.delete(job.id)
    # A run of it that comes back finds that it is nobody's, and changes nothing.
    assert held.asked() == "lost"
    held.release()
    assert count(store, jobs) == 0
    assert take_lease(store, f"{job.id}.2", threading.Event()) is None


def test_a_key_of_what_is_deleted_stands_for_a_new_job(store: Store) -> None:
    first = ended(store, key="k")
    store.delete(first.id)
    assert store.submit(TINY, key="k").id != first.id
    sweep = store.submit_all([TINY, TINY], key="s")
    for job in sweep:
        store.cancel(job.id)
    store.delete(sweep[0].id)
    assert [job.id for job in store.submit_all([TINY, TINY], key="s")] == [sweep[1].id]
    store.delete(sweep[1].id)
    assert count(store, keys) == 1
    assert len(store.submit_all([TINY, TINY], key="s")) == 2


DELETE = """
import os, shutil, signal, sys
from pathlib import Path
import sqlalchemy as sa
from app.service import deletion
from app.service.settings import settings
from app.service.store import Store

rmtree = shutil.rmtree

def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)

def half(path):
    (path / "spec.json").unlink()
    die()

store = Store(settings(Path(sys.argv[1]), {"KNITLAB_DB": sys.argv[2]}))
match sys.argv[4]:
    case "before the commit":
        sa.event.listen(store.engine, "commit", die)
    case "before the files":
        shutil.rmtree = die
    case "among the files":
        shutil.rmtree = half
    case "after the files":
        shutil.rmtree = lambda path: (rmtree(path), die())
store.delete(sys.argv[3])
"""


@pytest.mark.parametrize("moment", ["before the commit", "before the files", "among the files", "after the files"])
def test_a_deletion_cut_short_is_whole_or_finished_later(database: str, tmp_path: Path, moment: str) -> None:
    environment = {"KNITLAB_DB": database}
    with Store(settings(tmp_path, environment)) as store:
        job = ended(store)
        command = [sys.executable, "-c", DELETE, str(tmp_path), database, job.id, moment]
        assert subprocess.run(command, cwd=ROOT, check=False).returncode == -9  # noqa: S603 (our own)
        files = store.files(job.id)
        if moment == "before the commit":
            assert store.get(job.id).state == "cancelled"
            assert (files.path / "spec.json").exists()
            assert count(store, deleted) == 0
            return
        with pytest.raises(UnknownJobError):
            store.get(job.id)
        assert files.path.exists() == (moment != "after the files")
        house = Housekeeping(store, None)
        until(lambda: not files.path.exists())
        house.stop()


def test_files_that_come_late_go_too(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    job, stranger = ended(store), store.files("00stranger").path
    stranger.mkdir(parents=True)
    store.delete(job.id)
    # A host that was frozen since before the job ended.
    store.files(job.id).write_spec(TINY)
    clear(store)
    assert store.files(job.id).path.exists()
    monkeypatch.setattr(deletion, "AGAIN", 0.0)
    with store.engine.begin() as connection:
        connection.execute(sa.update(deleted).values(look=0.0))
    clear(store)
    assert not store.files(job.id).path.exists()
    assert count(store, deleted) == 0
    # What no row ever knew may be another store's.
    assert stranger.exists()


def test_files_that_cannot_go_are_tried_again(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    job = ended(store)

    def fail(path: Path) -> None:
        raise OSError(5, "the file server is away", str(path))

    with monkeypatch.context() as away:
        away.setattr("app.service.deletion.shutil.rmtree", fail)
        store.delete(job.id)
    assert store.files(job.id).path.exists()
    clear(store)
    with store.engine.begin() as connection:
        connection.execute(sa.update(deleted).values(look=0.0))
    clear(store)
    assert not store.files(job.id).path.exists()


def test_old_jobs_are_purged_and_others_kept(store: Store) -> None:
    old, new, waiting = [ended(store) for _ in range(5)], ended(store), store.submit(TINY)
    with store.engine.begin() as connection:
        for state, job in zip(FINAL, old, strict=False):
            connection.execute(sa.update(jobs).where(jobs.c.id == job.id).values(state=state))
        connection.execute(sa.update(jobs).where(jobs.c.id.in_([job.id for job in old])).values(finished=1000.0))
        connection.execute(sa.update(jobs).where(jobs.c.id == waiting.id).values(created=1000.0))
    assert purge(store, 1000.0) == 0
    assert purge(store, 2000.0) == 5
    assert {job.id for job in store.list().jobs} == {new.id, waiting.id}
    assert not any(store.files(job.id).path.exists() for job in old)
    assert store.files(new.id).path.exists()


def test_purging_goes_on_beyond_one_transaction(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deletion, "_AT_ONCE", 2)
    for _ in range(5):
        ended(store)
    house = Housekeeping(store, -1.0)
    until(lambda: sum(store.counts().values()) == 0)
    house.stop()
    assert count(store, deleted) == 5


def test_deliveries_that_ended_are_forgotten(store: Store) -> None:
    """The contract with DBOS's tables."""
    many = store.submit_all([TINY] * 6)
    tables = store.client._sys_db.tables
    status = tables.workflow_status
    states = ("SUCCESS", "ERROR", "CANCELLED", "PENDING", "ENQUEUED", "SUCCESS")
    with store.client._sys_db.engine.begin() as connection:
        for job, state in zip(many, states, strict=True):
            new = job is many[-1]
            values = {"status": state, "updated_at": 10**13 if new else 1_000_000}
            connection.execute(sa.update(status).where(status.c.workflow_uuid == f"{job.id}.1").values(values))
    assert forget_ended(store.client, 2000.0) == 3
    assert forget_ended(store.client, 2000.0) == 0
    left = {f"{job.id}.1" for job in many[3:]}
    with store.client._sys_db.engine.begin() as connection:
        for table in (status, tables.workflow_input):
            assert set(connection.scalars(sa.select(table.c.workflow_uuid))) == left


@pytest.mark.slow
def test_jobs_deleted_as_soon_as_they_end_leave_nothing(lab: Lab) -> None:
    lab.start(slots=2)
    waiting = {job.id for job in lab.store.submit_all([TINY] * 6)}
    folders = [lab.store.files(job).path for job in waiting]
    seen: set[str] = set()

    def delete_what_ended() -> bool:
        for job in list(waiting):
            try:
                lab.store.delete(job)
            except NotEndedError:
                if lab.store.get(job).state == "running":
                    assert lab.store.get(job).attempts >= 1
                    seen.add(job)
                continue
            waiting.remove(job)
        return not waiting

    until(delete_what_ended, every=0.02)
    assert seen
    assert sum(lab.store.counts().values()) == 0
    # The worker is none the worse for it.
    after = lab.store.submit(TINY)
    until(lambda: lab.job(after).state == "succeeded")
    assert not any(folder.exists() for folder in folders)

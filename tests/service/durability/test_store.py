"""The store alone: what is accepted is there, all of it or nothing; the rows DBOS will find."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa
from dbos import DBOSClient

from app.service import deliveries
from app.service.jobs import JobSpec, KeyReusedError, UnknownJobError, UnknownSweepError
from app.service.settings import settings
from app.service.store import Store
from knitlab_core.errors import SpecificationError
from tests.service.lab import ROOT

if TYPE_CHECKING:
    from pathlib import Path

SPEC = JobSpec(name="a", protocol="text: of a protocol\n", materials="text of materials")


def rows_of(store: Store, table: str) -> list[dict[str, object]]:
    with store.engine.begin() as connection:
        return [dict(row) for row in connection.execute(sa.text(f"SELECT * FROM {dbos(store, table)}")).mappings()]  # noqa: S608


def dbos(store: Store, table: str) -> str:
    """Name a table of DBOS's."""
    return table if store.settings.embedded else f"dbos.{table}"


def test_a_job_is_there_once_accepted(store: Store) -> None:
    job = store.submit(SPEC)
    assert store.get(job.id) == job
    assert (job.state, job.name, job.attempts, job.sweep) == ("queued", "a", 0, None)
    assert store.spec(job.id) == SPEC
    assert store.list().jobs == (job,)


def test_sweeps_are_counted_and_their_points_kept(store: Store) -> None:
    sweeps = []
    for name in ("one", "two"):
        specs = [replace(SPEC, name=f"{name}-{k}", point={"mu": k / 10}) for k in (1, 2)]
        sweeps.append(store.submit_all(specs)[0].sweep or "")
    store.submit(SPEC)
    first = store.points(sweeps[0], limit=1)
    ((job, spec),) = first.points
    store.cancel(job.id)
    assert dict(spec.point) == {"mu": 0.1}
    ((_, second),) = store.points(sweeps[0], limit=1, cursor=first.cursor).points
    assert second.name == "one-2"
    page = store.sweeps(limit=1)
    assert [one.id for one in page.sweeps] == sweeps[1:]
    last = store.sweeps(limit=1, cursor=page.cursor)
    assert last.cursor is None
    assert last.sweeps == (store.sweep(sweeps[0]),)
    assert (last.sweeps[0].name, last.sweeps[0].created) == ("one", job.created)
    assert {state: count for state, count in last.sweeps[0].counts.items() if count} == {"queued": 1, "cancelled": 1}
    with pytest.raises(UnknownSweepError):
        store.sweep("none")


def test_an_unknown_job_is_named(store: Store) -> None:
    for ask in (store.get, store.cancel, store.pause, store.resume, store.spec, store.folder):
        with pytest.raises(UnknownJobError, match="'nope'"):
            ask("nope")


def test_the_same_key_and_body_is_the_same_job(store: Store) -> None:
    job = store.submit(SPEC, key="k")
    assert store.submit(SPEC, key="k").id == job.id
    sweep = store.submit_all([SPEC, SPEC], key="s")
    assert [again.id for again in store.submit_all([SPEC, SPEC], key="s")] == [one.id for one in sweep]
    assert sum(store.counts().values()) == 3


def test_the_same_key_with_another_body_is_refused(store: Store) -> None:
    store.submit(SPEC, key="k")
    other = JobSpec(name="b", protocol=SPEC.protocol)
    with pytest.raises(KeyReusedError, match="'k'"):
        store.submit(other, key="k")
    with pytest.raises(KeyReusedError):
        store.submit_all([SPEC], key="k")
    assert sum(store.counts().values()) == 1


def test_pages_show_every_job_once_newest_first(store: Store) -> None:
    made = [store.submit(SPEC).id for _ in range(7)]
    seen, cursor = [], None
    while True:
        page = store.list(3, cursor)
        seen += [job.id for job in page.jobs]
        cursor = page.cursor
        if cursor is None:
            break
    assert seen == made[::-1]


def test_jobs_are_found_by_state_and_sweep(store: Store) -> None:
    sweep = store.submit_all([SPEC] * 3)
    alone = store.submit(SPEC)
    store.pause(sweep[1].id)
    assert [job.id for job in store.list(state="paused").jobs] == [sweep[1].id]
    assert {job.id for job in store.list(sweep=sweep[0].sweep).jobs} == {job.id for job in sweep}
    assert alone.sweep is None
    assert store.counts()["queued"] == 3


def test_wishes_are_idempotent_and_a_final_state_stays(store: Store) -> None:
    job = store.submit(SPEC)
    assert [store.pause(job.id).state for _ in range(2)] == ["paused", "paused"]
    assert [store.resume(job.id).state for _ in range(2)] == ["queued", "queued"]
    assert [store.cancel(job.id).state for _ in range(2)] == ["cancelled", "cancelled"]
    assert store.pause(job.id).state == store.resume(job.id).state == "cancelled"


def test_a_resumed_job_is_one_new_delivery(store: Store) -> None:
    job = store.submit(SPEC)
    store.pause(job.id)
    store.resume(job.id)
    store.resume(job.id)
    assert {row["workflow_uuid"] for row in rows_of(store, "workflow_status")} == {f"{job.id}.1", f"{job.id}.2"}


def test_deliveries_of_a_sweep_are_what_dbos_would_write(store: Store) -> None:
    """The contract with DBOS's tables: it changes only if DBOS does."""
    alone = store.submit(SPEC)
    store.submit_all([SPEC] * 3)
    for table in ("workflow_status", "workflow_input"):
        by_id = {str(row.pop("workflow_uuid")): row for row in rows_of(store, table)}
        own = by_id.pop(f"{alone.id}.1")
        different = {"created_at", "updated_at", "creator_xid", "priority", "retention_timestamp"}
        for row in by_id.values():
            assert row.keys() == own.keys()
            assert {name for name in row if row[name] != own[name]} <= different
    assert {row["priority"] for row in rows_of(store, "workflow_status")} == {deliveries.SINGLE, deliveries.SWEEP}


def test_priorities_are_of_those_that_dbos_counts(store: Store) -> None:
    assert 1 <= deliveries.AGAIN < deliveries.SINGLE < deliveries.SWEEP
    with pytest.raises(Exception, match="priority"), store.engine.begin() as connection:
        deliveries.enqueue(store.client, connection, "x.1", priority=0)


def test_what_a_dead_worker_took_is_queued_again_but_not_what_was_cancelled(store: Store) -> None:
    """The contract with DBOS's private recovery."""
    jobs = store.submit_all([SPEC] * 3)
    with store.engine.begin() as connection:
        table = dbos(store, "workflow_status")
        connection.execute(sa.text(f"UPDATE {table} SET status='PENDING', executor_id='gone'"))  # noqa: S608
    store.client.cancel_workflow(f"{jobs[0].id}.1")
    assert deliveries.takers(store.client) == {"gone"}
    assert deliveries.take_back(store.client, "gone") == 2
    assert deliveries.take_back(store.client, "gone") == 0
    states = {row["workflow_uuid"]: row["status"] for row in rows_of(store, "workflow_status")}
    assert [states[f"{job.id}.1"] for job in jobs] == ["CANCELLED", "ENQUEUED", "ENQUEUED"]


def test_the_embedded_database_keeps_a_write_ahead_log(tmp_path: Path) -> None:
    with Store(settings(tmp_path, {})) as store, store.engine.connect() as connection:
        assert connection.scalar(sa.text("PRAGMA journal_mode")) == "wal"


def test_queued_jobs_carry_the_constant_version(store: Store) -> None:
    store.submit(SPEC)
    assert {row["application_version"] for row in rows_of(store, "workflow_status")} == {deliveries.VERSION}


SUBMIT = """
import sys
from pathlib import Path
from app.service.jobs import JobSpec
from app.service.settings import settings
from app.service.store import Store
store = Store(settings(Path(sys.argv[1]), {"KNITLAB_DB": sys.argv[2]}))
print("go", flush=True)
store.submit_all([JobSpec(name="a", protocol="p")] * 4000)
"""


@pytest.mark.parametrize(
    "after", [0.1, *(pytest.param(after, marks=pytest.mark.slow) for after in (0.02, 0.2, 0.4, 0.8))]
)
def test_a_sweep_cut_short_is_there_whole_or_not_at_all(database: str, tmp_path: Path, after: float) -> None:
    command = [sys.executable, "-c", SUBMIT, str(tmp_path), database]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE) as submitting:  # noqa: S603 (our own)
        assert submitting.stdout is not None
        submitting.stdout.readline()
        time.sleep(after)
        submitting.kill()
    with Store(settings(tmp_path, {"KNITLAB_DB": database})) as store:
        jobs = sum(store.counts().values())
        assert jobs in {0, 4000}
        assert len(rows_of(store, "workflow_status")) == len(rows_of(store, "workflow_input")) == jobs


def test_a_database_that_is_no_postgresql_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SpecificationError, match="KNITLAB_DB"):
        settings(tmp_path, {"KNITLAB_DB": "mysql://root:secret@host/db"})


def test_settings_come_from_the_environment(tmp_path: Path) -> None:
    assert settings(None, {"KNITLAB_DATA": str(tmp_path)}).data == tmp_path
    many = settings(tmp_path, {"KNITLAB_DB": "postgresql://lab@db/knitlab"})
    assert (many.database, many.embedded) == ("postgresql+psycopg://lab@db/knitlab", False)


def test_the_public_client_still_takes_our_connections(store: Store) -> None:
    assert isinstance(store.client, DBOSClient)
    assert store.client.list_workflows() == []

"""The promise: no accepted job is lost or finished twice, whatever dies, freezes or leaves."""

from __future__ import annotations

import shutil
import signal
from typing import TYPE_CHECKING

import pytest

from app.service.deliveries import QUEUE, VERSION
from tests.service.lab import LONG, ROOT, TINY, begun, cycles, gone, until
from tests.service.storm import Storm, endure

if TYPE_CHECKING:
    from pathlib import Path

    from tests.service.lab import Lab

long = pytest.mark.slow


@long
def test_sigterm_lets_running_jobs_be_queued_again_before_their_end(lab: Lab) -> None:
    worker = lab.start(slots=1)
    job, waiting = lab.store.submit(cycles(120)), lab.store.submit(TINY)
    until(lambda: lab.process(job) is not None and lab.has_rows(job, 5))
    worker.send_signal(signal.SIGTERM)
    assert worker.wait() == 0
    assert [lab.job(one).state for one in (job, waiting)] == ["queued", "queued"]
    assert lab.process(job) is None
    assert 5 <= len(lab.files(job).rows()) < 241
    lab.start(slots=1)
    until(lab.finished)
    done = lab.job(job)
    assert (done.state, done.attempts, done.progress.rows) == ("succeeded", 2, 241)


@long
def test_a_newer_build_runs_what_an_older_one_queued(lab: Lab, tmp_path: Path) -> None:
    """DBOS would give changed code a new version, and let the old version's jobs wait for ever."""
    job = lab.store.submit(TINY)
    newer = tmp_path / "newer"
    shutil.copytree(ROOT / "app", newer / "app", ignore=shutil.ignore_patterns("__pycache__"))
    source = newer / "app" / "service" / "deliveries.py"
    text = source.read_text()
    assert "work(str(DBOS.workflow_id))" in text
    source.write_text(text.replace("work(str(DBOS.workflow_id))", "newer = str(DBOS.workflow_id)\n        work(newer)"))
    lab.start(root=newer)
    until(lab.finished)
    assert lab.job(job).state == "succeeded"


@long
@pytest.mark.postgres
def test_a_worker_that_never_returns_is_replaced(lab: Lab) -> None:
    lost = lab.start(slots=1)
    job = lab.store.submit(cycles(120))
    until(lambda: lab.process(job) is not None and lab.has_rows(job, 5))
    lab.start(slots=1)
    lab.kill(lost)
    until(lab.finished)
    assert (lab.job(job).state, begun(lab.files(job))) == ("succeeded", 2)


@long
@pytest.mark.postgres
def test_a_frozen_worker_that_comes_back_does_no_harm(lab: Lab) -> None:
    frozen = lab.start(slots=1)
    job = lab.store.submit(cycles(400))
    until(lambda: lab.process(job) is not None and lab.has_rows(job, 5))
    child = lab.process(job)
    assert child is not None
    frozen.send_signal(signal.SIGSTOP)
    child.suspend()
    lab.start(slots=1)
    until(lambda: begun(lab.files(job)) == 2)
    assert gone(child)
    frozen.send_signal(signal.SIGCONT)
    until(lab.finished)
    assert (lab.job(job).state, begun(lab.files(job))) == ("succeeded", 2)
    # It starts again under another name, and takes jobs again.
    lab.workers[1].send_signal(signal.SIGTERM)
    lab.workers[1].wait()
    again = lab.store.submit(TINY)
    until(lab.finished)
    assert lab.job(again).state == "succeeded"


@long
def test_a_job_cancelled_while_nobody_is_there_never_begins_again(lab: Lab) -> None:
    worker = lab.start(slots=1)
    job = lab.store.submit(LONG)
    until(lambda: lab.process(job) is not None and lab.has_rows(job, 5))
    lab.kill(worker)
    assert lab.store.cancel(job.id).state == "cancelling"
    lab.start(slots=1)
    until(lambda: lab.job(job).state == "cancelled")
    assert begun(lab.files(job)) == 1


@pytest.mark.parametrize("jobs", [6, pytest.param(200, marks=long)])
def test_a_storm_loses_no_job_and_ends_none_twice(lab: Lab, jobs: int) -> None:
    many = not lab.store.settings.embedded
    storm = Storm(
        jobs=jobs,
        workers=2 if many else 1,
        children_killed=max(jobs // 10, 2),
        workers_killed=max(jobs // 40, 1),
        workers_frozen=max(jobs // 100, 1) if many else 0,
        workers_told_to_leave=max(jobs // 100, 1),
    )
    tally = endure(lab, storm)
    assert (tally.submitted, tally.finished, tally.succeeded) == (jobs, jobs, jobs)
    assert (tally.lost, tally.twice, tally.different) == (0, 0, 0)
    assert tally.redone >= tally.interrupted >= max(storm.children_killed // 2, 1)


@long
def test_a_hundred_thousand_queued_jobs(lab: Lab) -> None:
    jobs = [job.id for job in lab.store.submit_all([TINY] * 100_000)]
    queue = lab.store.client.register_queue(QUEUE, worker_concurrency=2)
    database, taken = lab.store.client._sys_db, []
    for number in range(1, 101):
        taken += database.start_queued_workflows(queue, "test", VERSION, None)[0]
        assert len(taken) == 2 * number
    assert taken == [f"{job}.1" for job in jobs[:200]]  # the first delivery of each; times: benchmarks/service.py

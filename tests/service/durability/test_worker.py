"""One worker on an embedded store: what a job leaves, and every way to stop it."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

import psutil
import pytest

from app.service.jobs import JobSpec, NotEndedError
from tests.service.lab import BUSY, LONG, ROOT, TINY, Lab, begun, cycles, gone, manned, until

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.service.jobs import Job

MEBIBYTE = 1024**2


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with manned(tmp_path_factory.mktemp("lab")) as made:
        yield made


def running(lab: Lab, spec: JobSpec, rows: int = 3) -> str:
    job = lab.store.submit(spec)
    until(lambda: lab.process(job) is not None and lab.has_rows(job, rows))
    return job.id


def ended(lab: Lab, job: str, state: str) -> None:
    until(lambda: lab.store.get(job).state == state)


def test_a_job_runs_to_its_end_and_leaves_its_files(lab: Lab) -> None:
    job = lab.store.submit(TINY)
    ended(lab, job.id, "succeeded")
    done, files = lab.job(job), lab.files(job)
    assert (done.end, done.attempts, done.progress.share, done.progress.rows) == ("target", 1, 1.0, 3)
    assert done.started is not None
    assert done.finished is not None
    assert done.created < done.started < done.finished
    assert {"run.h5", "warm.csv"} <= {path.name for path in files.run.iterdir()}
    assert [row["row"] for row in files.rows()] == [0, 1, 2]
    assert files.rows(since=2)[0]["phase"] == "Recover"
    assert files.rows(since=1)[0]["strain"]["C"] == pytest.approx(0.01)
    assert files.log.read_text().count("\n") >= 4


def test_jobs_that_run_show_their_attempt_and_are_deleted_as_soon_as_they_end(lab: Lab) -> None:
    waiting = {job.id for job in lab.store.submit_all([TINY] * 3)}
    folders = [lab.store.files(job).path for job in waiting]

    def delete_what_ended() -> bool:
        for job in list(waiting):
            now = lab.store.get(job)
            assert now.state == "queued" or now.attempts == 1
            with suppress(NotEndedError):
                lab.store.delete(job)
                waiting.remove(job)
        return not waiting

    until(delete_what_ended, every=0.02)
    after = lab.store.submit(TINY)
    ended(lab, after.id, "succeeded")
    assert not any(folder.exists() for folder in folders)


def test_a_queued_job_that_is_cancelled_never_begins(lab: Lab) -> None:
    first = running(lab, LONG)
    job = lab.store.submit(TINY)
    assert lab.store.cancel(job.id).state == "cancelled"
    lab.store.cancel(first)
    ended(lab, first, "cancelled")
    after = lab.store.submit(TINY)
    ended(lab, after.id, "succeeded")
    assert not lab.files(job).path.exists()


@pytest.mark.parametrize(
    ("spec", "rows", "most"), [(LONG, 3, 4001), (BUSY, 1, 1001)], ids=["between rows", "busy in a kernel"]
)
def test_a_running_job_that_is_cancelled_stops_before_its_end(lab: Lab, spec: JobSpec, rows: int, most: int) -> None:
    job = running(lab, spec, rows)
    process = lab.process(lab.store.get(job))
    assert process is not None
    files = lab.store.files(job)
    lab.store.cancel(job)
    until(lambda: gone(process), every=0.01)
    assert rows <= len(files.rows(limit=most)) < most
    ended(lab, job, "cancelled")
    assert lab.store.resume(job).state == "cancelled"


def test_a_paused_job_rests_and_goes_on(lab: Lab) -> None:
    job = running(lab, cycles(100))
    asked = lab.store.pause(job)
    assert asked.wanted == "pause" or asked.state == "paused"
    ended(lab, job, "paused")
    assert lab.process(lab.store.get(job)) is None
    lab.store.resume(job)
    ended(lab, job, "succeeded")
    done = lab.store.get(job)
    assert (done.attempts, done.progress.rows) == (2, 201)
    assert [row["row"] for row in lab.store.files(job).rows()] == list(range(201))
    assert "goes on from its checkpoint" in lab.store.files(job).log.read_text()


def test_a_job_past_its_timeout_has_failed_and_is_not_tried_again(lab: Lab) -> None:
    job = lab.store.submit(JobSpec(name="slow", protocol=LONG.protocol, timeout=1.5, pictures=False))
    ended(lab, job.id, "failed")
    done = lab.job(job)
    assert (done.end, done.attempts, done.message) == ("timeout", 1, "ran longer than its timeout of 1.5 s")


def test_a_job_over_its_memory_limit_has_failed_and_is_not_tried_again(lab: Lab) -> None:
    job = lab.store.submit(JobSpec(name="fat", protocol=LONG.protocol, memory=64 * MEBIBYTE, pictures=False))
    ended(lab, job.id, "failed")
    done = lab.job(job)
    assert (done.end, done.attempts, done.message) == ("memory", 1, "held more than its memory limit of 64 MiB")


def test_a_job_whose_process_dies_is_tried_again(lab: Lab) -> None:
    job = lab.store.get(running(lab, cycles(100)))
    process = lab.process(job)
    assert process is not None
    process.send_signal(signal.SIGSEGV)
    ended(lab, job.id, "succeeded")
    assert lab.job(job).attempts == begun(lab.files(job)) == 2


def test_a_job_whose_process_dies_three_times_has_failed(lab: Lab) -> None:
    job = lab.store.submit(LONG)
    for attempt in (1, 2, 3):
        _dead(lab, job, attempt)
    ended(lab, job.id, "failed")
    done = lab.job(job)
    assert (done.end, done.attempts) == ("crash", 3)
    assert "3 times" in done.message
    assert "SIGKILL" in done.message


def _dead(lab: Lab, job: Job, attempt: int) -> None:
    """Kill the process of an attempt."""
    until(lambda: begun(lab.files(job)) == attempt and lab.process(job) is not None)
    process = lab.process(job)
    assert process is not None
    process.kill()


def test_a_wrong_protocol_is_a_failed_job_with_one_line(lab: Lab) -> None:
    job = lab.store.submit(JobSpec(name="wrong", protocol="schema: knitlab/protocol@1\n"))
    ended(lab, job.id, "failed")
    done = lab.job(job)
    assert (done.end, done.attempts) == ("error", 1)
    assert "\n" not in done.message
    assert "protocol.yaml" in done.message


def test_a_second_server_on_the_store_says_so_in_one_line(lab: Lab) -> None:
    command = [sys.executable, "-c", "from app.cli.main import main; main()", "worker", "--data", str(lab.folder)]
    second = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: S603 (our own)
    assert second.returncode == 2
    assert second.stderr.count("\n") == 1
    assert f"process {lab.workers[-1].pid} " in second.stderr


def test_the_fork_server_has_one_thread(lab: Lab) -> None:
    """OpenMP's threads do not survive a fork: kernels that want them would kill the children."""
    children = psutil.Process(lab.workers[-1].pid).children()
    servers = [child for child in children if any("forkserver" in word for word in child.cmdline())]
    assert [server.num_threads() for server in servers] == [1]


@pytest.mark.parametrize("module", ["app.service.job_process", "app.cli.main"])
def test_what_every_process_imports_is_light(module: str) -> None:
    """The child's target and the entry point are imported again in every process."""
    heavy = {"numba", "h5py", "dbos", "pydantic", "sqlalchemy", "matplotlib", "fastapi"}
    code = f"import sys, {module}; print(*{heavy} & sys.modules.keys())"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)  # noqa: S603 (our own)
    assert done.stdout.split() == []


def test_a_killed_server_comes_back_and_goes_on_and_leaves_no_orphan(lab: Lab) -> None:
    first, second = lab.store.submit(cycles(120)), lab.store.submit(TINY)
    until(lambda: lab.process(first) is not None and lab.has_rows(first, 5))
    orphan = lab.process(first)
    assert orphan is not None
    lab.kill(lab.workers[-1])
    until(lambda: gone(orphan), every=0.01)
    assert len(lab.files(first).rows()) < 241
    assert lab.job(first).state == "running"
    lab.start(slots=1)
    until(lab.finished)
    assert [lab.job(job).state for job in (first, second)] == ["succeeded"] * 2
    assert begun(lab.files(first)) == 2
    assert "goes on from its checkpoint" in lab.files(first).log.read_text()
    assert [row["row"] for row in lab.files(first).rows()] == list(range(241))

"""Faults that are none of the job's: it waits them out, and what is done stays done."""

from __future__ import annotations

import fcntl
import json
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from app.records.reader import RunReader
from app.service import job_process
from app.service.folder import JobFolder, Result
from app.service.row_file import restore
from tests.service.lab import TINY, Lab, begun, cycles, manned, until

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with manned(tmp_path_factory.mktemp("lab")) as made:
        yield made


def test_a_job_waits_until_its_data_folder_is_there(lab: Lab) -> None:
    root = lab.store.settings.jobs
    shutil.rmtree(root, ignore_errors=True)
    root.write_text("in the way")
    job = lab.store.submit(TINY)
    until(lambda: lab.job(job).started is not None)
    time.sleep(1.0)
    assert lab.job(job).state in {"running", "queued"}
    root.unlink()
    until(lab.finished)
    assert (lab.job(job).state, lab.job(job).attempts) == ("succeeded", 1)


def test_what_stands_in_the_working_folder_is_not_run(tmp_path: Path) -> None:
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "__init__.py").write_text("raise SystemExit('not ours')")
    lab = Lab(tmp_path / "data")
    command = [str(Path(sys.executable).with_name("knitlab")), "worker", "--data", str(lab.folder), "--slots", "1"]
    with subprocess.Popen(command, cwd=tmp_path, env=lab.environment) as worker:  # noqa: S603 (our own)
        job = lab.store.submit(TINY)
        until(lab.finished)
        worker.terminate()
    assert lab.job(job).state == "succeeded"
    lab.close()


def test_a_job_whose_folder_is_held_elsewhere_can_be_cancelled(lab: Lab) -> None:
    job = lab.store.submit(TINY)
    files = lab.files(job)
    lab.store.pause(job.id)
    files.write_spec(TINY)
    with (files.path / "lock").open("ab", buffering=0) as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        held.write(json.dumps({"host": "elsewhere", "pid": 1}).encode())
        lab.store.resume(job.id)
        until(lambda: lab.job(job).state == "running")
        time.sleep(2.0)
        assert (lab.job(job).state, lab.job(job).attempts) == ("running", 1)
        lab.store.cancel(job.id)
        until(lambda: lab.job(job).state == "cancelled")


def test_an_interrupt_of_a_whole_group_is_no_end_of_a_test(lab: Lab) -> None:
    job = lab.store.submit(cycles(60))
    until(lambda: lab.process(job) is not None and lab.has_rows(job, 5))
    process = lab.process(job)
    assert process is not None
    process.send_signal(signal.SIGINT)
    until(lab.finished)
    done = lab.job(job)
    assert (done.state, done.end, done.progress.rows) == ("succeeded", "target", 121)
    assert begun(lab.files(job)) == 2


@pytest.fixture(scope="module")
def tested(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a job killed when its test was over and its result not yet kept."""
    files = JobFolder(tmp_path_factory.mktemp("job"))
    files.write_spec(TINY)
    job_process._test(files, job_process._Watch(files))
    return files.path


def test_a_test_that_is_over_is_left_alone(
    tested: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = JobFolder(shutil.copytree(tested, tmp_path / "job"))
    before = (files.run / "run.h5").read_bytes()
    watch, opened, make = job_process._Watch(files), [], RunReader.__init__

    def opening(self: RunReader, path: Path, **more: Any) -> None:  # noqa: ANN401
        opened.append(path)
        make(self, path, **more)

    monkeypatch.setattr(RunReader, "__init__", opening)
    assert job_process._test(files, watch).outcome == "target"
    assert opened == [files.run / "run.h5"]
    assert (files.run / "run.h5").read_bytes() == before
    said = capsys.readouterr().err
    assert "its test has ended" in said
    assert "the test ended:" not in said


def test_rows_that_a_power_cut_took_come_back_from_the_record(tested: Path, tmp_path: Path) -> None:
    files = JobFolder(shutil.copytree(tested, tmp_path / "job"))
    whole = files.rows_file.read_bytes()
    record = RunReader(files.run / "run.h5")
    for left in (whole[: len(whole) // 2], b""):
        files.rows_file.write_bytes(left)
        restore(files.rows_file, record)
        assert files.rows_file.read_bytes() == whole
    files.rows_file.unlink()
    restore(files.rows_file, record)
    assert files.rows_file.read_bytes() == whole


def test_files_of_a_newer_build_are_read(tmp_path: Path) -> None:
    files = JobFolder(tmp_path)
    files.write_spec(TINY)
    for name, data in (("progress", {"share": 0.5, "mood": "good"}), ("result", {"end": "target", "colour": 1})):
        (tmp_path / f"{name}.json").write_text(json.dumps({"message": "", "failed": False} | data))
    spec = json.loads((tmp_path / "spec.json").read_text())
    (tmp_path / "spec.json").write_text(json.dumps(spec | {"later": True}))
    assert files.progress().share == 0.5
    assert files.result() == Result(end="target", message="", failed=False)
    assert files.read_spec() == TINY


def test_orders_of_a_leaving_service_do_not_wait_for_its_database(lab: Lab) -> None:
    from app.service.leases import take_lease  # noqa: PLC0415
    from app.service.tables import AWAY  # noqa: PLC0415

    leaving = threading.Event()
    leaving.set()
    engine = lab.store.engine

    class Away:
        def begin(self) -> None:
            raise AWAY[0]("", None, ConnectionError("away"))

    lab.store.engine = Away()  # type: ignore[assignment]
    try:
        with pytest.raises(AWAY):
            take_lease(lab.store, "none.1", leaving)
    finally:
        lab.store.engine = engine

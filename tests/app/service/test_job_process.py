from __future__ import annotations

import errno
from pathlib import Path

import pytest

from app.runs.publishing import RunResult
from app.service import job_process
from app.service.folder import JobFolder, Result

DONE = Result(end="target", message="", failed=False)
DONE_RUN = RunResult(outcome="target", message="", folder=Path("run"), figures=())


def test_an_end_is_said_once_it_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = JobFolder(tmp_path)

    def killed(_: JobFolder, __: Result) -> None:
        raise SystemExit

    with monkeypatch.context() as patch:
        patch.setattr(JobFolder, "write_result", killed)
        with pytest.raises(SystemExit):
            job_process._end(files, DONE)
    assert files.result() is None
    assert "done" not in capsys.readouterr().err
    job_process._end(files, DONE)
    assert files.result() == DONE
    assert capsys.readouterr().err.endswith(" done: target\n")


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), job_process.TROUBLE),
        (OSError("Can't write data (file write failed: errno = 28, error message = 'No space left on device')"), 74),
        (OSError(errno.ENOENT, "No such file or directory"), 1),
        (ValueError("of ours"), 1),
    ],
)
def test_a_full_disk_is_no_fault_of_the_job(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, code: int
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(job_process, "_test", fail)
    monkeypatch.setattr(job_process, "_redirect_output", lambda _: None)
    monkeypatch.setattr("app.service.job_process.when_asked", lambda *_: None)  # of this process, not of a job's
    with pytest.raises(SystemExit) as left:
        job_process._work_in(JobFolder(tmp_path))
    assert left.value.code == code
    assert JobFolder(tmp_path).result() is None


def test_a_result_that_finds_no_room_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(job_process, "_test", lambda *_: DONE_RUN)
    monkeypatch.setattr(job_process, "_redirect_output", lambda _: None)
    monkeypatch.setattr("app.service.job_process.when_asked", lambda *_: None)
    monkeypatch.setattr(JobFolder, "write_result", full)
    monkeypatch.setattr("app.service.job_process.sys.stderr.write", full)
    with pytest.raises(SystemExit) as left:
        job_process._work_in(JobFolder(tmp_path))
    assert left.value.code == job_process.TROUBLE

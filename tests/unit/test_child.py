from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.service import child
from app.service.folder import JobFolder, Result

if TYPE_CHECKING:
    from pathlib import Path

DONE = Result(end="target", message="", failed=False)


def test_an_end_is_said_once_it_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = JobFolder(tmp_path)

    def killed(_: JobFolder, __: Result) -> None:
        raise SystemExit

    with monkeypatch.context() as patch:
        patch.setattr(JobFolder, "write_result", killed)
        with pytest.raises(SystemExit):
            child._end(files, DONE)
    assert files.result() is None
    assert "done" not in capsys.readouterr().err
    child._end(files, DONE)
    assert files.result() == DONE
    assert capsys.readouterr().err.endswith(" done: target\n")

"""Commands and the service run where nothing of ours can use what Windows lacks: fork, sessions, signals, fcntl."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

from app.client import Client
from tests.service.knitlab_serve import QUICK, ROOT, knitlab, serving
from tests.service.lab import until

#: Its `sitecustomize` hides them in every process that is started, jobs included.
PATH: Final = os.pathsep.join((str(Path(__file__).parent / "without_posix"), str(ROOT)))
LONG: Final = QUICK.replace("n: 1", "n: 600")
MODULES: Final = """\
import pathlib, importlib, os, sys
assert not hasattr(os, "fork")
for package in ("app", "knitlab", "knitlab_core", "rigs"):
    for path in sorted(pathlib.Path(sys.argv[1], package).rglob("*.py")):
        name = ".".join(path.relative_to(sys.argv[1]).with_suffix("").parts).removesuffix(".__init__")
        if name != "app.service.warm":
            importlib.import_module(name)
print(len(sys.modules))
"""


def test_every_module_can_be_imported(tmp_path: Path) -> None:
    done = subprocess.run(  # noqa: S603 (our own interpreter and text)
        [sys.executable, "-P", "-c", MODULES, str(ROOT)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": PATH},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 500


def test_a_test_is_checked_and_run(tmp_path: Path) -> None:
    (tmp_path / "quick.yaml").write_text(QUICK, encoding="utf-8")
    checked = knitlab("check", "quick.yaml", folder=tmp_path, PYTHONPATH=PATH)
    assert checked.returncode == 0, checked.stderr
    run = knitlab("run", "quick.yaml", "--out", "run", "--no-pictures", folder=tmp_path, PYTHONPATH=PATH)
    assert run.returncode == 0, run.stderr
    assert len((tmp_path / "run" / "quick.csv").read_bytes().splitlines()) > 50


@pytest.mark.slow
def test_jobs_are_done_paused_resumed_and_cancelled(tmp_path: Path) -> None:
    with serving(tmp_path, "--slots", 1, PYTHONPATH=PATH) as (address, _), Client(address) as client:
        quick = client.submit(QUICK).id
        until(lambda: client.job(quick).over)
        assert client.job(quick).end == "target"
        long = client.submit(LONG).id
        until(lambda: client.job(long).progress.rows > 2)
        client.pause(long)
        until(lambda: client.job(long).state == "paused")
        done = client.job(long).progress.rows
        client.resume(long)
        until(lambda: client.job(long).progress.rows > done)
        client.cancel(long)
        until(lambda: client.job(long).state == "cancelled")
        assert not any("crash" in path.name for path in tmp_path.rglob("*"))

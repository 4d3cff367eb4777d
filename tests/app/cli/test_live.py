"""`knitlab live` as a user starts and ends it."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING

import pytest

import knitlab as kl
from tests.app.live.test_rig import HEAD
from tests.app.live.test_server import Client

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

CODE = "from app.cli.main import main; import sys; sys.argv[0] = 'knitlab'; main()"


@contextmanager
def served(folder: Path, *words: str) -> Iterator[tuple[subprocess.Popen[str], IO[str], int]]:
    """Serve a head without steps; yield the process, its messages, and the port."""
    head = folder / "head.yaml"
    head.write_text(kl.to_yaml(HEAD), encoding="utf-8")
    command = [sys.executable, "-c", CODE, "live", str(head), "--port", "0", "--no-pictures", *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:  # noqa: S603 (our own code)
        assert process.stderr is not None
        said = None
        try:
            while said is None:
                line = process.stderr.readline()
                assert line, process.wait()
                said = re.match(r"knitlab live on 127\.0\.0\.1:(\d+), biaxial-hook; run in (.*)", line)
            yield process, process.stderr, int(said[1])
        except BaseException:
            process.kill()
            raise


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is Unix")
def test_sigterm_ends_the_run_at_rest_and_breaks_off_a_move(tmp_path: Path) -> None:
    at_rest = served(tmp_path, "--out", str(tmp_path / "rest"))
    with at_rest as (process, messages, port), Client(port) as client:
        assert client.ask("ZERO;MOVE:ABS C,0.2 mm,2e-4;*OPC?") == "1"
        process.send_signal(signal.SIGTERM)
        assert messages.read() == f"{tmp_path / 'rest'}: 2 steps, target\n"
    assert process.returncode == 0
    assert kl.open_run(tmp_path / "rest").outcome.end == "target"

    moving = served(tmp_path, "--out", str(tmp_path / "moving"), "--pace", "1")
    with moving as (process, messages, port), Client(port) as client:
        client.send("MOVE:ABS C,4 mm,2e-4")
        while float(client.ask("MEAS:TIME?")) == 0.0:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        said = messages.read()
    kept = len(kl.open_run(tmp_path / "moving").trace)
    assert said == f"{tmp_path / 'moving'}: 1 steps, abort: interrupted; {kept} equilibria kept\n"
    assert 2 <= kept < 15
    assert process.returncode == 130

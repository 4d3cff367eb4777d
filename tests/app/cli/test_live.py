"""`knitlab live` as a user starts and ends it."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from typing import IO, TYPE_CHECKING

import pytest

import knitlab as kl
from tests.app.live.test_rig import HEAD
from tests.app.live.test_server import Client

if TYPE_CHECKING:
    from pathlib import Path

CODE = "from app.cli.main import main; import sys; sys.argv[0] = 'knitlab'; main()"


def served(folder: Path, *words: str) -> tuple[subprocess.Popen[str], IO[str], int]:
    """Serve a head without steps; return the process, its messages, and the port."""
    head = folder / "head.yaml"
    head.write_text(kl.to_yaml(HEAD), encoding="utf-8")
    command = [sys.executable, "-c", CODE, "live", str(head), "--port", "0", "--no-pictures", *words]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)  # noqa: S603 (our own code)
    messages = process.stderr
    assert messages is not None
    for line in messages:
        said = re.match(r"knitlab live on 127\.0\.0\.1:(\d+), biaxial-hook; run in (.*)", line)
        if said:
            return process, messages, int(said[1])
    raise AssertionError(process.wait())


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is Unix")
def test_sigterm_ends_the_run_at_rest_and_breaks_off_a_move(tmp_path: Path) -> None:
    process, messages, port = served(tmp_path, "--out", str(tmp_path / "rest"))
    with Client(port) as client:
        assert client.ask("ZERO;MOVE:ABS C,0.2 mm,2e-4;*OPC?") == "1"
        process.send_signal(signal.SIGTERM)
        assert messages.read() == f"{tmp_path / 'rest'}: 2 steps, target\n"
    assert process.wait(120.0) == 0
    assert kl.open_run(tmp_path / "rest").outcome.end == "target"

    process, messages, port = served(tmp_path, "--out", str(tmp_path / "moving"), "--pace", "1")
    with Client(port) as client:
        client.send("MOVE:ABS C,2 mm,1e-6")
        while not kl.open_run(tmp_path / "moving").steps:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        assert messages.read() == f"{tmp_path / 'moving'}: 1 steps, abort: interrupted; 1 equilibria kept\n"
    assert process.wait(120.0) == 130

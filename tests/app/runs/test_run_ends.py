"""End runs before their time, as a user would see it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import pytest

from app.cli.main import main
from app.records.export import export_run
from app.records.reader import RunReader
from app.runs.use_cases import run_protocol
from knitlab_core.equilibrium.newton import Options
from knitlab_core.errors import FormatError
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Outcome

if TYPE_CHECKING:
    from pathlib import Path

PROTOCOL = """
schema: knitlab/protocol@1
name: tiny
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [3, 3], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 24}
speed_ref: pair
others: hold
log: {rate: 5 Hz, noise: off}
max_strain_increment: 0.002
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: 0.3, rate: 0.2 mm/s, n: 200}
"""


def run_cli(*words: object) -> subprocess.Popen[str]:
    # A shell's background jobs ignore SIGINT, and children inherit that.
    code = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from app.cli.main import main; sys.argv[0] = 'knitlab'; main()"
    )
    command = [sys.executable, "-c", code, *map(str, words)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # noqa: S603


def begun(folder: Path, rows: int) -> tuple[subprocess.Popen[str], Path]:
    """Start a test of ``p.yaml`` in a folder; return its process and record when that has so many rows."""
    protocol, record = folder / "p.yaml", folder / "run" / "run.h5"
    protocol.write_text(PROTOCOL, encoding="utf-8")
    process = run_cli("run", protocol, "--out", folder / "run", "--quiet")
    while rows_in(record) < rows:
        assert process.poll() is None, process.communicate()
        time.sleep(0.2)
    return process, record


def test_ctrl_c_keeps_what_was_recorded(tmp_path: Path) -> None:
    process, record = begun(tmp_path, 10)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=240.0)
    assert process.returncode == 130, err
    run = RunReader(record)
    assert run.outcome.end == "abort"
    assert run.outcome.message == f"interrupted; {len(run.trace)} equilibria kept"
    assert err.splitlines()[-1] == (
        f"{tmp_path / 'p.yaml'}: abort: {run.outcome.message}; go on with: knitlab resume {tmp_path / 'run'}"
    )
    # The step under way is recorded as far as it went.
    under_way = run.steps[-1]
    assert (under_way.end, under_way.start) == ("abort", 0.0)
    assert under_way.time == run.trace.columns["time"][-1] > 0.0
    rows = len(run.samples["biaxial-hook"].time)
    assert (tmp_path / "run" / "tiny.csv").read_bytes().count(b"\r\n") == rows + 1


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 is Unix")
def test_a_killed_run_is_exported_up_to_its_last_row(tmp_path: Path) -> None:
    process, record = begun(tmp_path, 5)
    process.kill()
    process.communicate()
    run = RunReader(record)
    reached = run.trace.columns["time"][-1]
    assert [step.end for step in run.steps] == ["target", "abort"]
    assert run.steps[-1].time == reached > 0.0
    (path,) = export_run(record, out=tmp_path / "log")
    # One sample at every tick of 5 Hz up to the last row.
    assert path.read_bytes().count(b"\r\n") == int(5.0 * reached + 1e-9) + 1 + 1


def test_the_progress_of_an_interrupted_run_stays_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    protocol = tmp_path / "p.yaml"
    protocol.write_text(PROTOCOL, encoding="utf-8")
    shown: list[tuple[float, str]] = []

    def interrupted(*arguments: Any) -> Any:  # noqa: ANN401 (handed through)
        for number, event in enumerate(perform(*arguments)):
            if number > 12:
                raise KeyboardInterrupt
            yield event

    monkeypatch.setattr("app.runs.runner.perform", interrupted)
    result = run_protocol(protocol, tmp_path / "run", lambda share, text: shown.append((share, text)), draw=None)
    assert result.outcome == "abort"
    assert shown[-1][1] == "interrupted"
    assert 0.0 < max(share for share, _ in shown) == shown[-1][0] < 0.01


def rows_in(record: Path) -> int:
    try:
        return len(RunReader(record).trace)
    except (FileNotFoundError, FormatError):
        return 0


@pytest.mark.parametrize("cold", [True, False])
def test_the_first_run_says_that_it_compiles_and_how_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *, cold: bool
) -> None:
    protocol = tmp_path / "p.yaml"
    protocol.write_text(PROTOCOL, encoding="utf-8")
    said: list[str] = []

    def mount_and_listen(*arguments: Any) -> Any:  # noqa: ANN401 (handed through)
        said.append(capsys.readouterr().err)
        return mount(*arguments)

    monkeypatch.setattr("app.runs.use_cases.cache_is_cold", lambda: cold)
    monkeypatch.setattr("app.runs.runner.mount", mount_and_listen)
    monkeypatch.setattr("app.runs.runner.perform", lambda *_: iter([Outcome(end="target")]))
    run_protocol(protocol, tmp_path / "run", lambda _share, _text: None)
    assert [("compiling" in text, "about a minute" in text) for text in said] == [(cold, cold)]


def test_a_run_that_diverges_is_code_3_with_a_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    protocol = tmp_path / "p.yaml"
    protocol.write_text(PROTOCOL.replace("increment: 0.002", "increment: 0.02"), encoding="utf-8")
    monkeypatch.setattr("app.runs.runner.perform", partial(perform, options=Options(max_iterations=1)))
    monkeypatch.setattr("knitlab_core.equilibrium.continuation.MOST_ITERATIONS", 0)
    monkeypatch.setattr("knitlab_core.equilibrium.march.MOST_MOVES", 2)
    monkeypatch.setattr(
        sys, "argv", ["knitlab", "run", str(protocol), "--out", str(tmp_path / "run"), "--quiet", "--no-pictures"]
    )
    with pytest.raises(SystemExit) as raised:
        main()
    assert raised.value.code == 3
    run = RunReader(tmp_path / "run" / "run.h5")
    assert run.outcome.end == "diverged"
    assert len(run.trace) > 3
    assert capsys.readouterr().err.splitlines()[-1] == f"{protocol}: diverged: {run.outcome.message}"
    assert (tmp_path / "run" / "tiny.csv").exists()

"""What a run does once: it parses its protocol, builds its knit, and does not read back what it has just computed."""

from __future__ import annotations

import sys
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
import pytest
from typer.testing import CliRunner

from app.cli.main import knitlab
from app.records.reader import RunReader
from app.runs.use_cases import resume_run, run_protocol
from app.schemas.document import parse_text
from knitlab_core.knits import knit_specimen
from rigs.protocol.made_specimen import _made

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path
    from types import CodeType, FrameType

SMALL = """
schema: knitlab/protocol@1
name: once
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 16}
others: hold
log: {rate: 10 Hz, noise: off}
steps:
  - ramp: {axes: [C, W], to: 6 %, rate: 0.2 mm/s}
"""

COUNTED: dict[CodeType, str] = {
    parse_text.__code__: "protocol parsed",
    knit_specimen.__code__: "knit built",
    RunReader.__init__.__code__: "record opened",
    RunReader._read_trace.__code__: "rows read",
}


def counted(work: Callable[[], object]) -> Counter[str]:
    """Return how often each function of `COUNTED` is called by some work."""
    calls: Counter[str] = Counter()

    def count(frame: FrameType, event: str, _argument: object) -> None:
        if event == "call" and frame.f_code in COUNTED:
            calls[COUNTED[frame.f_code]] += 1

    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(None)
    return calls


@pytest.fixture
def protocol(tmp_path: Path) -> Path:
    _made.cache_clear()
    path = tmp_path / "once.yaml"
    path.write_text(SMALL, encoding="utf-8")
    return path


def test_the_command_parses_once_builds_once_and_reads_no_row_back(protocol: Path, tmp_path: Path) -> None:
    arguments = ["run", str(protocol), "--out", str(tmp_path / "run"), "--quiet", "--no-pictures"]
    results = []
    calls = counted(lambda: results.append(CliRunner().invoke(knitlab, arguments)))
    assert results[0].exit_code == 0, results[0].output
    assert calls == {"protocol parsed": 1, "knit built": 1, "record opened": 1}


def test_pictures_drawn_in_the_same_process_need_no_second_reading(protocol: Path, tmp_path: Path) -> None:
    calls = counted(lambda: run_protocol(protocol, tmp_path / "run"))
    assert calls == {"protocol parsed": 1, "knit built": 1, "record opened": 1}


def assert_same(shown: RunReader) -> None:
    """Raise unless the rows that a run had in memory are those of its record, to the bit."""
    stored = RunReader(shown.path)
    assert stored.trace is not shown.trace
    assert stored.trace.columns.keys() == shown.trace.columns.keys()
    for name, column in stored.trace.columns.items():
        np.testing.assert_array_equal(column, shown.trace.columns[name], err_msg=name)
    assert (stored.trace.phase, stored.trace.tag) == (shown.trace.phase, shown.trace.tag)
    assert stored.test == shown.test


def test_rows_in_memory_are_those_of_the_record_also_in_a_resumed_run(protocol: Path, tmp_path: Path) -> None:
    shown: list[RunReader] = []

    def draw(run: RunReader, _name: str) -> Callable[[], None]:
        shown.append(run)
        return lambda: None

    def interrupt(number: int, _row: object, _strain: object) -> None:
        if number == 1:
            raise KeyboardInterrupt

    cut = run_protocol(protocol, tmp_path / "run", watch=interrupt, draw=draw)
    assert cut.outcome == "abort"
    assert_same(shown[-1])
    ended = resume_run(cut.folder, draw=draw)
    assert ended.outcome == "target"
    assert len(shown[1].trace) > len(shown[0].trace) == 2
    assert_same(shown[-1])

"""A rig that is driven step by step leaves what a run of its protocol leaves, whatever was tried between."""

from __future__ import annotations

import shutil
import signal
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import knitlab as kl
from app.live.pace import Pace
from rigs.record import units

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from app.live.rig import LiveRig
    from rigs.record import Equilibrium

SPECIMEN = kl.SpecimenSpec(
    knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=16
)
HEAD = kl.Protocol(specimen=SPECIMEN, others="hold", name="live")


def opened(folder: Path, head: kl.Protocol = HEAD, **named: Any) -> LiveRig:  # noqa: ANN401 (handed through)
    return kl.Rig(head, folder, draw=None, **named)


def log_of(folder: Path) -> bytes:
    (log,) = folder.rglob("*.csv")
    return log.read_bytes()


def same_record(one: Path, other: Path) -> bool:
    """Compare rows, steps, zeros and shapes of two runs; the solver's time is another one each time."""
    first, second = kl.open_run(one), kl.open_run(other)
    columns = set(units(first.trace.axes, cell=())) - {"seconds"}
    rows = all(np.array_equal(first.trace.columns[name], second.trace.columns[name]) for name in columns)
    shapes = [frame.nodes.tobytes() for frame in first.frames()] == [frame.nodes.tobytes() for frame in second.frames()]
    return rows and shapes and first.steps == second.steps and first.zeroings == second.zeroings


def test_the_record_is_that_of_the_protocol_as_if_what_was_undone_had_never_been_tried(tmp_path: Path) -> None:
    with opened(tmp_path / "live") as rig:
        rig.zero()
        assert rig.move(C="0.2 mm", rate=2e-4).end == "target"
        mark = rig.checkpoint()
        before = rig.read()
        rig.do(kl.Image(every=1.0))
        rig.zero()
        rig.move_strain(W=0.02, rate=2e-4)
        rig.go_back(mark)
        assert rig.read() == before
        rig.move_strain(C=0.02, W=0.02, rate="1e-3 1/s", log=kl.StepLog(rate=2.0))
        rig.move_force(W=0.01, rate=0.005, tag="let go")
        rig.do(kl.Repeat(n=1, steps=(kl.Hold(duration=1.0), kl.Zero(channels=("force",)))))
        reading = rig.read()
        protocol = rig.protocol
    assert len(protocol.steps) == 6
    kl.run(protocol, tmp_path / "run", draw=None)
    assert log_of(tmp_path / "live") == log_of(tmp_path / "run")
    assert same_record(tmp_path / "live", tmp_path / "run")
    record = kl.open_run(tmp_path / "live")
    assert record.test == protocol
    assert record.outcome.end == rig.result.outcome == "target"
    assert reading.time == record.trace.columns["time"][-1]
    assert reading.strain["C"] == pytest.approx(0.02)
    assert reading.displacement["C"] == pytest.approx(0.02 * 16e-3)


def test_steps_of_the_head_come_first_and_a_text_is_a_head_too(tmp_path: Path) -> None:
    head = kl.to_yaml(kl.Protocol(specimen=SPECIMEN, others="hold", steps=(kl.Zero(), kl.Hold(duration=1.0))))
    with kl.Rig(head, tmp_path / "live", draw=None) as rig:
        assert [type(step).__name__ for step in rig.protocol.steps] == ["Zero", "Hold"]
        assert rig.hold("2 s").start == 1.0
        assert rig.knit().time == 3.0
    with pytest.raises(kl.ProtocolError, match=r"steps: found \[\], allowed one step or more"):
        kl.run(HEAD, tmp_path / "none")


REFUSED: dict[str, Callable[[LiveRig], object]] = {
    "move: found 'X', allowed axes of this rig: C=... or W=...": lambda rig: rig.move(X=1e-3, rate=1e-4),
    "move: found 'no axis', allowed": lambda rig: rig.move(rate=1e-4),
    "move: found 'C', allowed a target too": lambda rig: rig.move("C", rate=1e-4),
    "move: found 'C=0.001, W=0.002', allowed one level": lambda rig: rig.move(C=1e-3, W=2e-3, rate=1e-4),
    "ramp: found 'travel: axis C would go 1000 mm, limit 100 mm'": lambda rig: rig.move(C=1.0, rate=1e-3),
    "ramp: found 'speed: a pair would move at 500 mm/s": lambda rig: rig.move(C=1e-3, rate=0.5),
    "ramp: found 'force: 1000 N asked for, limit 100 N'": lambda rig: rig.move_force(C=1e3, rate=1.0),
    "steps: found '-0.05 m on axis C'": lambda rig: rig.move(C="-50 mm", rate="1 mm/s"),
    "C: found '1 N', allowed a length": lambda rig: rig.move(C="1 N", rate=1e-4),
    "C: found None, allowed a length": lambda rig: rig.move(C=None, rate=1e-4),  # type: ignore[arg-type]
    "rate: found '1 N/s', allowed a speed or a strain rate": lambda rig: rig.move(C=1e-3, rate="1 N/s"),
    "duration: found '-1 s'": lambda rig: rig.hold(-1.0),
    "hold: found 'a log of 1e+08 rows'": lambda rig: rig.hold(1e7),
    "go_back: found 'a mark of another rig, or one that was undone'": lambda rig: rig.go_back(None),  # type: ignore[arg-type]
    "ramp.log.rate: found '5000 Hz'": lambda rig: rig.move(C=1e-3, rate=1e-4, log=kl.StepLog(rate=5e3)),
}


def test_what_cannot_be_done_is_refused_in_a_line_and_leaves_nothing(tmp_path: Path) -> None:
    with opened(tmp_path / "live") as rig:
        mark = rig.checkpoint()
        rig.move_strain(C=0.02, rate=1e-3)
        undone = rig.checkpoint()
        rig.go_back(mark)
        for line, ask in REFUSED.items():
            with pytest.raises(kl.KnitlabError) as raised:
                ask(rig)
            assert line in str(raised.value)
            assert "\n" not in str(raised.value)
        with pytest.raises(kl.KnitlabError, match="a mark of another rig, or one that was undone"):
            rig.go_back(undone)
        rig.move_strain(C=0.02, rate=1e-3)
    assert len(kl.open_run(rig.folder).steps) == 1
    closed: tuple[Callable[[], object], ...] = (rig.zero, rig.checkpoint, rig.knit, lambda: rig.go_back(mark))
    for late in closed:
        with pytest.raises(kl.KnitlabError, match=r"found 'a rig that is closed; its run is in .*live'"):
            late()
    assert rig.close() == rig.result


def test_moves_after_a_limit_are_refused_with_its_reason_until_it_is_undone(tmp_path: Path) -> None:
    filament = kl.SpecimenSpec(
        knit=kl.Filament(fibre_radius=0.05), rows=1, loops=1, loop_width=0.02, material="RGD8530-DM", nodes_per_loop=16
    )
    head = kl.Protocol(specimen=filament, rig="uniaxial-frame", mount="C", load_cell=500.0, others="free")
    with opened(tmp_path / "live", head) as rig:
        mark = rig.checkpoint()
        ended = rig.move_strain(C=0.5, rate=1e-4)
        assert ended.end == "limit"
        assert rig.outcome is not None
        assert ended.message == rig.outcome.message
        with pytest.raises(kl.KnitlabError, match=r"hold: found 'a test that has ended: limit: .* passed its limit of"):
            rig.hold(1.0)
        with pytest.raises(kl.KnitlabError, match="checkpoint: found 'a test that has ended"):
            rig.checkpoint()
        rig.go_back(mark)
        assert rig.protocol.steps == ()
        assert rig.move_strain(C=0.001, rate=1e-4).end == "target"
        rig.move_strain(C=0.5, rate=1e-4)
    assert rig.result.outcome == kl.open_run(rig.folder).outcome.end == "limit"


def test_an_error_in_the_block_leaves_a_run_that_resumes_to_its_steps(tmp_path: Path) -> None:
    def drive(rig: LiveRig) -> None:
        with rig:
            rig.zero()
            rig.move_strain(C=0.02, rate=1e-3)
            rig.hold(1.0)
            raise ValueError("no idea")

    rig = opened(tmp_path / "live")
    with pytest.raises(ValueError, match="no idea"):
        drive(rig)
    record = kl.open_run(rig.folder)
    assert (record.outcome.end, rig.result.outcome) == ("abort", "abort")
    assert record.outcome.message == f"broken off by ValueError: no idea; {len(record.trace)} equilibria kept"
    written = log_of(rig.folder)
    assert kl.resume(rig.folder, draw=None).outcome == "target"
    assert written == log_of(rig.folder)


def test_ctrl_c_keeps_what_was_recorded_and_can_be_undone(tmp_path: Path) -> None:
    seen: list[int] = []

    def interrupt(number: int, *_: object) -> None:
        seen.append(number)
        if len(seen) == 4:
            signal.raise_signal(signal.SIGINT)

    def drive(rig: LiveRig) -> None:
        with rig:
            mark = rig.checkpoint()
            with pytest.raises(KeyboardInterrupt):
                rig.move_strain(C=0.06, rate=1e-3)
            with pytest.raises(kl.KnitlabError, match="a test that has ended: abort: interrupted; 4 equilibria kept"):
                rig.hold(1.0)
            rig.go_back(mark)
            seen[:] = [0]
            rig.move_strain(C=0.06, rate=1e-3)

    rig = opened(tmp_path / "live", watch=interrupt)
    # A shell's background jobs ignore SIGINT, and children inherit that.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            drive(rig)
    finally:
        signal.signal(signal.SIGINT, before)
    record = kl.open_run(rig.folder)
    assert record.outcome.message == "interrupted; 4 equilibria kept"
    assert (len(record.trace), record.steps[-1].end) == (4, "abort")
    assert log_of(rig.folder).count(b"\n") > 4
    assert kl.resume(rig.folder, draw=None).outcome == "target"
    assert kl.open_run(rig.folder).strain("C")[-1] == pytest.approx(0.06)


def test_a_step_that_is_stopped_ends_at_a_row_and_the_protocol_says_so(tmp_path: Path) -> None:
    def stop(number: int, *_: object) -> None:
        if number == 3:
            rig.stop()

    rig = opened(tmp_path / "live", watch=stop)
    with rig:
        rig.stop()  # nothing moves: nothing to stop
        stopped = rig.move_strain(C=0.06, rate=1e-3)
        assert (stopped.end, stopped.message) == ("abort", "stopped")
        assert 0.0 < rig.read().strain["C"] < 0.05
        (step,) = rig.protocol.steps
        assert isinstance(step, kl.Ramp)
        assert step.until == kl.Until(time=stopped.time)
        rig.hold(1.0)
    assert rig.result.outcome == "target"
    assert [step.end for step in rig.result.steps] == ["abort", "target"]
    again = kl.run(rig.protocol, tmp_path / "run", draw=None)
    assert again.steps[-1].time == pytest.approx(rig.result.steps[-1].time)


@pytest.mark.slow
def test_what_a_kill_leaves_resumes_to_the_steps_that_it_knows(tmp_path: Path) -> None:
    def copy(number: int, *_: object) -> None:
        if number == 6:
            shutil.copytree(tmp_path / "live", tmp_path / "killed")

    with opened(tmp_path / "live", watch=copy) as rig:
        rig.move_strain(C=0.02, rate=1e-3)
        mark = rig.checkpoint()
        rig.move_strain(W=0.02, rate=1e-3)
        rig.go_back(mark)
        for strain in (0.03, 0.04, 0.06):
            rig.move_strain(C=strain, rate=1e-3)
    left = kl.open_run(tmp_path / "killed")
    assert left.going_on
    known = left.test
    assert rig.protocol.steps[: len(known.steps)] == known.steps
    assert kl.resume(tmp_path / "killed", draw=None).outcome == "target"
    kl.run(known, tmp_path / "run", draw=None)
    assert log_of(tmp_path / "killed") == log_of(tmp_path / "run")


def test_the_pace_waits_for_the_rigs_clock_and_a_stop_cuts_it(tmp_path: Path) -> None:
    rows: list[Equilibrium] = []
    with opened(tmp_path / "live", pace=20.0, watch=lambda _number, row, _strain: rows.append(row)) as rig:
        began = perf_counter()
        rig.hold(4.0)
        assert perf_counter() - began >= 0.2
    for wrong in (0.0, -1.0, "fast", float("nan"), True):
        with pytest.raises(kl.SpecificationError, match="pace: found"):
            Pace(wrong)  # type: ignore[arg-type]
    slow = Pace("real")
    slow.begin(0.0)
    slow.cut()
    late = replace(rows[-1], time=1e6)
    assert list(slow.keep(iter([late]))) == [late]

"""How densely a test is logged."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.checks.dry_run import dry_run
from app.records.export import export_log
from app.records.reader import MOST_SHOWN, RunReader
from app.schemas import load, loads
from knitlab_core.errors import SpecificationError
from rigs.control.log_rate import stretches_of
from rigs.instruments.channels import measure, measured_parts
from rigs.instruments.samples import thinned
from rigs.instruments.ticks import Stretch, ticks
from rigs.protocol.protocol import Cycle, Hold, LogSpec, Protocol, Ramp, SpecimenSpec, StepLog, Target, Zero
from rigs.record import Outcome
from rigs.trace import trace_of
from tests.app.records.test_records import writer
from tests.synthetic_run import row, rows, stage_instrument

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import Axis, FloatArray
    from rigs.protocol.step import Step
    from rigs.trace import Trace

SPECIMEN = SpecimenSpec(knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM")
CYCLES = Cycle(axes=("C", "W"), lower=0.0, upper=0.4, rate=2e-4, n=7)
FILE = """
schema: knitlab/protocol@1
rig: {rig}
specimen: {{knit: stockinette-default, loops: [1, 1], loop: 8 mm, material: RGD8530-DM, friction: 0.3}}
speed_ref: pair
others: {others}
log: {{rate: {rate}}}
steps:
  - zero: {{channels: [force, displacement]}}
  - hold: {{for: {time}, log: {{rate: {own}}}}}
"""


def protocol(*steps: Step, **log: float) -> Protocol:
    return Protocol(
        specimen=SPECIMEN,
        speed_ref="pair",
        others="hold",
        steps=steps,
        log=LogSpec(noise=False, **log),  # type: ignore[arg-type]
    )


def text(rig: str = "biaxial-hook", rate: str = "10 Hz", own: str = "1 Hz", time: str = "10 s") -> str:
    others = "hold" if rig == "biaxial-hook" else "free\nmount: W"
    return FILE.format(rig=rig, others=others, rate=rate, own=own, time=time)


def clock(*stretches: Stretch, skew: float = 0.0) -> FloatArray:
    return np.concatenate([some.time for some in ticks(0.0, stretches, skew=skew)])


def cycled(count: int) -> Trace:
    """Return cycles of ten seconds up and ten seconds down, a row every two, in the step 1 after a zero."""
    made = [row(0.0, 0.0, 1, "Zero")]
    for number in range(count):
        for k in range(1, 11):
            strain = 0.08 * (5 - abs(k - 5))
            made.append(
                replace(row(20.0 * number + 2.0 * k, strain, number + 1, "Stretch" if k < 6 else "Recover"), step=1)
            )
    return trace_of(made)


def logged(trace: Trace, test: Protocol) -> FloatArray:
    machine = stage_instrument(test.log.rate)
    return measure(machine, trace, seed=0, noise=False, stretches=stretches_of(trace, test)).time


def test_ticks_of_all_rates_are_counted_from_the_start() -> None:
    found = clock(Stretch(end=1.0, rate=2.0), Stretch(end=2.0, rate=0.0), Stretch(end=2.5, rate=8.0))
    assert found.tolist() == [0.0, 0.5, 1.0, 2.125, 2.25, 2.375, 2.5]
    assert np.all(np.diff(clock(Stretch(end=0.93, rate=7.0), Stretch(end=3.0, rate=11.0), skew=1e-3)) > 0.0)


def test_a_test_that_says_nothing_is_one_stretch() -> None:
    trace = trace_of(rows())
    test = protocol(Zero(), CYCLES)
    assert stretches_of(trace, test) == [Stretch(end=trace.columns["time"][-1], rate=10.0)]


def test_a_step_has_a_rate_of_its_own() -> None:
    test = protocol(Zero(), replace(CYCLES, log=StepLog(rate=0.5)), rate=2.0)
    trace = cycled(2)
    assert np.diff(logged(trace, test)) == pytest.approx(2.0)
    assert dry_time(test) == pytest.approx(0.5, rel=0.01)


def dry_time(test: Protocol) -> float:
    """Return rows a second as planned [Hz]."""
    from rigs.control.plan import planned_duration, planned_rows  # noqa: PLC0415

    gauges: dict[Axis, float] = {"C": 0.016, "W": 0.0189}
    return planned_rows(test, gauges) / planned_duration(test, gauges)


def test_every_nth_cycle_is_kept_and_the_first_and_the_last() -> None:
    test = protocol(Zero(), replace(CYCLES, log=StepLog(every_cycle=3)), rate=1.0)
    time = logged(cycled(7), test)
    cycles = np.unique(np.ceil(time[1:] / 20.0)).astype(int)
    assert cycles.tolist() == [1, 3, 6, 7]
    assert len(time) == 1 + 4 * 20
    assert dry_time(test) == pytest.approx(4 / 7, rel=0.02)
    assert logged(cycled(7), protocol(Zero(), CYCLES, rate=1.0, every_cycle=3)).tolist() == time.tolist()


@pytest.mark.parametrize("every", [1, 5])
def test_near_a_jump_the_log_is_denser(every: int) -> None:
    trace = cycled(4)
    # A fibre breaks after the row at 46 s, in the third cycle.
    trace.columns["fracture_work"][trace.columns["time"] > 46.0] = 1e-3
    time = logged(trace, protocol(Zero(), CYCLES, rate=1.0, events=20.0, every_cycle=every))
    near = (time > 45.0) & (time <= 47.0)
    assert np.diff(time[near]) == pytest.approx(0.05)
    assert np.count_nonzero(near) == 40
    assert np.all(np.diff(time[~near]) >= 1.0 - 1e-9)
    assert np.any((time > 40.0) & (time < 45.0)) == (every == 1)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (text(rate="10 kHz"), "p.yaml:7:13: log.rate: found 10000 Hz, allowed 100 Hz or less: biaxial-hook samples no"),
        (
            text(own="101 Hz"),
            "p.yaml:10:35: steps[1].hold.log.rate: found 101 Hz, allowed 100 Hz or less: biaxial-hook",
        ),
    ],
)
def test_a_log_faster_than_its_machine_is_refused(said: str, message: str) -> None:
    with pytest.raises(SpecificationError) as caught:
        dry_run(loads(said, "p.yaml"))
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_a_frame_logs_as_fast_as_it_samples() -> None:
    assert dry_run(loads(text(rig="uniaxial-frame", rate="10 kHz", own="10 kHz"), "p.yaml")).rows == 100_001


def test_check_knows_rows_and_size() -> None:
    plan = dry_run(loads(text(time="100 h"), "p.yaml"))
    assert plan.rows == 360_001
    # A sample of the stage is 117 bytes in the record; a line of its log some 60.
    assert 150.0 < plan.size / plan.rows < 250.0


def test_the_largest_and_smallest_samples_are_shown_of_a_long_log() -> None:
    samples = measure(stage_instrument(200.0), trace_of(rows()), seed=2)
    some = thinned(samples, 4_000)
    assert len(some) <= 4_000 + 4 * 2 < len(samples)
    for name, values in samples.measured.items():
        assert (some.measured[name].min(), some.measured[name].max()) == (values.min(), values.max())
    assert (some.time[0], some.time[-1]) == (samples.time[0], samples.time[-1])
    # Each stroke keeps its ends.
    turns = np.flatnonzero([a != b for a, b in zip(samples.phase, samples.phase[1:], strict=False)])
    assert set(samples.time[turns]) | set(samples.time[turns + 1]) <= set(some.time)
    assert thinned(samples, len(samples)).time.tolist() == samples.time.tolist()


def peak_memory(folder: Path, hold: float) -> float:
    """Return the most memory that logging a hold [s] at 100 Hz and exporting it takes [bytes]."""
    trace = trace_of([row(0.0, 0.0, 1, "Zero"), row(hold, 0.0, 1, "Hold")])
    folder.mkdir()
    tracemalloc.start()
    with writer(folder / "run.h5", stage_instrument(100.0)) as run:
        run.append(row(0.0, 0.0, 1, "Zero"))
        run.append(row(hold, 0.0, 1, "Hold"))
        for samples in measured_parts(stage_instrument(100.0), trace, seed=1):
            run.write_samples(samples)
        run.finish(Outcome(end="target"))
    record = RunReader(folder / "run.h5")
    record.provenance |= {"name": "long", "rig.convention.temperature": 22.0}
    path = export_log(record, folder, "biotester")
    shown = record.samples["biaxial-hook"]
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    with path.open("rb") as file:
        assert sum(1 for _ in file) == round(100.0 * hold) + 2
    assert len(shown) <= MOST_SHOWN
    return most


@pytest.mark.slow
def test_memory_does_not_grow_with_the_log(tmp_path: Path) -> None:
    short = peak_memory(tmp_path / "short", 200.0)
    assert peak_memory(tmp_path / "long", 800.0) < 1.1 * short + 80_000 * 100


def test_a_file_says_it_as_python_does(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(
        text().replace("rate: 10 Hz", "rate: 10 Hz, events: 50 Hz, every_cycle: 4")
        + "  - cycle: {axes: [C], lower: 0, upper: 1 %, rate: 0.2 mm/s, n: 9, log: {rate: 2 Hz, every_cycle: 5}}\n"
        + "  - ramp: {axes: [C], to: {strain: 1 %}, rate: 0.2 mm/s, log: {events: 100 Hz}}\n",
        encoding="utf-8",
    )
    test = load(path).protocol
    assert (test.log.rate, test.log.events, test.log.every_cycle) == (10.0, 50.0, 4)
    said = [step.log for step in test.steps if isinstance(step, Hold | Cycle | Ramp)]
    assert said == [StepLog(rate=1.0), StepLog(rate=2.0, every_cycle=5), StepLog(events=100.0)]
    with pytest.raises(SpecificationError, match="only a step cycle has cycles"):
        Ramp(axes=("C",), to=Target(kind="strain", value=0.1), rate=2e-4, log=StepLog(every_cycle=2))

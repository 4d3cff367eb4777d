from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knitlab_core.errors import SpecificationError
from rigs.instruments.channels import Channel, Instrument, measure, overloaded
from rigs.instruments.signals import Curve, add_noise, noise_stream, quantise, saturate, zero_offset
from rigs.instruments.ticks import Stretch, ticks
from rigs.instruments.zeros import Zeroing
from rigs.trace import Trace, trace_of
from tests.synthetic_run import row, rows, stage_instrument

if TYPE_CHECKING:
    from rigs.axes import FloatArray

STAGE = stage_instrument()
TRACE = trace_of(rows())


def cell(name: str = "XForce", **changes: float) -> Channel:
    channel = Channel(name=name, reads="force_C", kind="force", unit="N", limit=10.0, noise=0.01, resolution=0.0)
    return replace(channel, **changes)  # type: ignore[arg-type]


def clock(end: float, rate: float = 10.0) -> FloatArray:
    return np.concatenate([some.time for some in ticks(0.0, [Stretch(end=end, rate=rate)])])


def test_clock_counts_both_ends_when_they_are_ticks() -> None:
    assert clock(1.0).tolist() == pytest.approx(np.arange(11) / 10)
    assert len(clock(0.99)) == 10


def test_interpolation_passes_through_the_rows() -> None:
    times = TRACE.columns["time"]
    for name in ("force_C", "displacement_W"):
        read = Curve.through(times, TRACE.columns[name], TRACE.strokes())(times)
        assert read == pytest.approx(TRACE.columns[name])


@given(st.lists(st.floats(0.001, 1.0), min_size=2, max_size=8), st.integers(2, 6))
def test_interpolation_never_overshoots_at_a_turning_point(rises: list[float], per_stroke: int) -> None:
    values, strokes, level = [0.0], [0], 0.0
    for number, rise in enumerate(rises):
        target = level + rise if number % 2 == 0 else level - rise
        steps = np.linspace(0, 1, per_stroke + 1)[1:] ** 2
        values += list(level + (target - level) * steps)
        strokes += [number] * per_stroke
        level = target
    time = np.arange(len(values), dtype=float)
    at = np.linspace(0, time[-1], 500)
    read = Curve.through(time, np.array(values), np.array(strokes))(at)
    below, above = np.floor(at).astype(int), np.ceil(at).astype(int)
    ends = np.sort(np.stack([np.array(values)[below], np.array(values)[above]]), axis=0)
    assert np.all(read >= ends[0] - 1e-12)
    assert np.all(read <= ends[1] + 1e-12)


def test_a_straight_stroke_stays_straight_up_to_its_peak() -> None:
    time, values = np.array([0.0, 1, 2, 3, 4]), np.array([0.0, 1, 2, 1, 0])
    at = np.linspace(0, 4, 81)
    read = Curve.through(time, values, np.array([0, 0, 0, 1, 1]))(at)
    assert read == pytest.approx(2 - np.abs(at - 2))


def test_a_step_of_no_duration_is_a_jump() -> None:
    time, values = np.array([0.0, 1, 1, 2]), np.array([0.0, 1, 5, 6])
    read = Curve.through(time, values, np.array([0, 0, 1, 2]))(np.array([0.5, 1.5]))
    assert read == pytest.approx([0.5, 5.5])


def test_another_channel_changes_no_other_stream() -> None:
    alone = Instrument(name="one", channels=(cell("YForce"),), rate=10.0)
    joined = Instrument(name="one", channels=(cell("New"), cell("YForce")), rate=10.0)
    first, second = measure(alone, TRACE, seed=3), measure(joined, TRACE, seed=3)
    assert first.measured["YForce"].tolist() == second.measured["YForce"].tolist()
    assert second.measured["New"].tolist() != second.measured["YForce"].tolist()


def test_noise_has_its_deviation_and_its_seed() -> None:
    quiet = np.zeros(20_000)
    noisy = add_noise(quiet, 0.02, noise_stream(seed=1, name="XForce"))
    assert noisy.std() == pytest.approx(0.02, rel=0.03)
    assert abs(noisy.mean()) < 4 * 0.02 / np.sqrt(20_000)
    assert noisy.tolist() == add_noise(quiet, 0.02, noise_stream(seed=1, name="XForce")).tolist()
    assert noisy.tolist() != add_noise(quiet, 0.02, noise_stream(seed=2, name="XForce")).tolist()


@given(st.lists(st.floats(-50, 50), min_size=1), st.sampled_from([0.0, 0.001, 0.25]))
def test_quantising_moves_by_half_a_step_at_most(values: list[float], step: float) -> None:
    given_values = np.array(values)
    shown = quantise(given_values, step)
    assert np.all(np.abs(shown - given_values) <= step / 2 + 1e-9)
    if step:
        assert shown / step == pytest.approx(np.round(shown / step), abs=1e-6)


def test_saturation_holds_and_is_told() -> None:
    assert saturate(np.array([-3.0, 1.0, 3.0]), 2.0).tolist() == [-2.0, 1.0, 2.0]
    weak = Instrument(name="one", channels=(cell(limit=1.0),), rate=10.0)
    samples = measure(weak, TRACE, seed=0)
    assert samples.overloads == ("XForce",)
    assert samples.measured["XForce"].max() == 1.0
    assert measure(STAGE, TRACE, seed=0).overloads == ()


def test_overload_is_seen_row_by_row() -> None:
    weak = Instrument(name="one", channels=(cell(limit=1.0),), rate=10.0)
    assert overloaded(weak, row(0.0, 0.0, 1, "Stretch")) is None
    assert overloaded(weak, row(0.0, 0.4, 1, "Stretch")) == weak.channels[0]


def test_without_noise_the_clean_signal_is_logged() -> None:
    samples = measure(STAGE, TRACE, seed=0, noise=False)
    for name in samples.clean:
        assert samples.measured[name].tolist() == samples.clean[name].tolist()


def test_zero_takes_the_reading_off_from_then_on() -> None:
    time, values = np.arange(5.0), np.array([1.0, 2, 3, 4, 5])
    assert zero_offset(time, values, [2.0]).tolist() == [0, 0, 3, 3, 3]
    assert zero_offset(time, values, [0.0, 3.0]).tolist() == [1, 1, 1, 4, 4]
    assert zero_offset(time, values, [9.0]).tolist() == [0] * 5


def test_the_row_that_led_to_a_zero_is_not_zeroed() -> None:
    # A ramp to 2, and the row of the zeroing, at the same time.
    time, values = np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 2.0, 2.0, 5.0])
    assert zero_offset(time, values, [1.0]).tolist() == [0, 0, 2, 2]


def test_zero_is_for_the_channels_it_names() -> None:
    shift = Trace(
        columns=TRACE.columns | {"force_C": TRACE.columns["force_C"] + 1.0},
        phase=TRACE.phase,
        tag=TRACE.tag,
    )
    zero = Zeroing(time=0.0, kinds=frozenset({"displacement"}))
    assert measure(STAGE, shift, seed=0, noise=False, zeroings=[zero]).measured["XForce"][0] == 1.0
    zero = Zeroing(time=0.0, kinds=frozenset({"force"}))
    assert measure(STAGE, shift, seed=0, noise=False, zeroings=[zero]).measured["XForce"][0] == 0.0


def test_samples_know_their_stroke() -> None:
    samples = measure(STAGE, TRACE, seed=0)
    peak = int(np.argmax(samples.clean["XDisplacement"]))
    assert samples.phase[0] == "Zero"
    assert samples.phase[1] == samples.phase[peak] == "Stretch"
    assert samples.phase[peak + 1] == "Recover"
    assert samples.cycle[-1] == 2
    assert set(samples.tag) == {"equibiaxial"}


def test_nothing_can_be_sampled_from_nothing() -> None:
    with pytest.raises(SpecificationError, match="at least one row"):
        measure(STAGE, trace_of([]), seed=0)


def test_stage_reads_course_as_x_and_wale_as_y() -> None:
    reads = {channel.name: (channel.reads, channel.unit) for channel in STAGE.channels}
    assert reads == {
        "XDisplacement": ("crosshead_C", "m"),
        "YDisplacement": ("crosshead_W", "m"),
        "XForce": ("force_C", "N"),
        "YForce": ("force_W", "N"),
    }
    assert stage_instrument(rate=25.0).rate == 25.0

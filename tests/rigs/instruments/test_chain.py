"""Hold every stage of a channel's chain to its closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.schemas.machine_data import read_machine
from rigs.instruments.channels import Channel, Instrument, measure
from rigs.instruments.signals import Lag, drift, stamps, true_times
from rigs.instruments.zeros import Zeroing
from rigs.machines.machine import instrument_of, instruments_of
from rigs.protocol.protocol import LogSpec
from rigs.trace import Trace

if TYPE_CHECKING:
    from rigs.axes import Axis, FloatArray
    from rigs.protocol.catalogue import MachineName

STEP = 0.1
TIME: FloatArray = STEP * np.arange(80.0)
T = 0.37


@pytest.mark.parametrize(
    ("signal", "filtered"),
    [
        (np.full(80, 7.0), np.full(80, 7.0)),
        (2 + 3 * TIME, 2 + 3 * (TIME - T + T * np.exp(-TIME / T))),
        # Up to t = 2, then down: the second ramp adds minus twice the first.
        (
            np.minimum(TIME, 4 - TIME),
            TIME
            - T
            + T * np.exp(-TIME / T)
            - 2 * np.where(TIME > 2, TIME - 2 - T + T * np.exp(-np.maximum(TIME - 2, 0) / T), 0.0),
        ),
    ],
    ids=["rest", "ramp", "corner"],
)
def test_lag_is_exact_for_straight_pieces(signal: FloatArray, filtered: FloatArray) -> None:
    assert Lag(time_constant=T)(signal, STEP, STEP) == pytest.approx(filtered, abs=1e-12)


def test_lag_of_a_sine_is_damped_and_late() -> None:
    time = 1e-3 * np.arange(40_000)
    omega = 2.0
    late = Lag(time_constant=T)(np.sin(omega * time), 1e-3, 1e-3)[20_000:]
    gain, phase = 1 / np.hypot(1, omega * T), np.arctan(omega * T)
    assert late == pytest.approx(gain * np.sin(omega * time[20_000:] - phase), abs=1e-6)


@given(st.floats(1e-6, 1e6), st.lists(st.floats(-1, 1), min_size=1, max_size=30))
def test_lag_stays_within_the_signal(time_constant: float, values: list[float]) -> None:
    late = Lag(time_constant=time_constant)(np.array(values), STEP, STEP)
    assert np.all(late <= max(values) + 1e-9)
    assert np.all(late >= min(values) - 1e-9)


def test_no_time_constant_changes_nothing() -> None:
    assert Lag(time_constant=0.0)(TIME, STEP, STEP) is TIME


def test_drift_is_a_ramp_from_the_first_sample() -> None:
    assert drift(np.ones(3), np.array([5.0, 6.0, 8.0]), 0.25, 5.0).tolist() == [1.0, 1.25, 1.75]


@given(st.floats(-3600, 3600), st.floats(-0.01, 0.01), st.floats(0, 1e5))
def test_a_stamp_gives_its_true_time_back(offset: float, skew: float, time: float) -> None:
    stamped = stamps(np.array([time]), offset, skew)
    assert stamped[0] == pytest.approx(time * (1 + skew) + offset)
    assert true_times(stamped, offset, skew)[0] == pytest.approx(time, abs=1e-9)


def ramp(duration: float = 8.0, speed: float = 1.0) -> Trace:
    times = np.linspace(0.0, duration, 9)
    columns = {"time": times, "force_C": speed * times, "cycle": np.ones(9)}
    return Trace(columns=columns, phase=("Stretch",) * 9, tag=(None,) * 9)


CELL = Channel(name="F", reads="force_C", kind="force", unit="N", limit=100.0, noise=0.0, resolution=0.0)


def one(channel: Channel = CELL, **clock: float) -> Instrument:
    return replace(Instrument(name="i", channels=(channel,), rate=10.0), **clock)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, lambda t: t),
        ({"lag": T}, lambda t: t - T + T * np.exp(-t / T)),
        ({"drift": 0.5}, lambda t: 1.5 * t),
        ({"resolution": 0.25}, lambda t: np.round(t / 0.25) * 0.25),
        ({"limit": 3.0}, lambda t: np.minimum(t, 3.0)),
        ({"delay": 0.05}, lambda t: np.minimum(t + 0.05, 8.0)),
        # The order: drift is quantised, what is quantised saturates.
        ({"drift": 0.5, "resolution": 0.4, "limit": 3.1}, lambda t: np.minimum(np.round(1.5 * t / 0.4) * 0.4, 3.1)),
    ],
    ids=["none", "lag", "drift", "resolution", "limit", "delay", "order"],
)
def test_each_stage_of_the_chain(changes: dict[str, float], expected: object) -> None:
    samples = measure(one(replace(CELL, **changes)), ramp(), seed=1)  # type: ignore[arg-type]
    assert samples.measured["F"] == pytest.approx(expected(samples.time), abs=1e-12)  # type: ignore[operator]
    assert samples.overloads == (("F",) if "limit" in changes else ())


def test_noise_off_is_the_clean_signal() -> None:
    poor = replace(CELL, lag=T, drift=1.0, noise=2.0, resolution=0.5)
    samples = measure(one(poor), ramp(), seed=1, noise=False)
    assert samples.measured["F"].tolist() == samples.clean["F"].tolist()
    assert samples.clean["F"] == pytest.approx(samples.time, abs=1e-12)


def test_zero_takes_drift_and_lag_off_too() -> None:
    zeroing = Zeroing(time=4.0, kinds=frozenset({"force"}))
    samples = measure(one(replace(CELL, drift=0.5)), ramp(), seed=1, zeroings=[zeroing])
    assert samples.measured["F"][samples.time >= 4.0] == pytest.approx(1.5 * (samples.time[40:] - 4.0), abs=1e-12)


def test_a_clock_is_sampled_at_its_own_ticks() -> None:
    samples = measure(one(offset=0.3, skew=0.01), ramp(), seed=0)
    assert samples.time == pytest.approx(0.3 + 0.1 * np.arange(len(samples.time)))
    assert samples.true_time == pytest.approx((samples.time - 0.3) / 1.01)
    assert samples.measured["F"] == pytest.approx(samples.true_time, abs=1e-12)
    assert len(samples.time) == 81


def test_a_lead_shows_the_knit_at_rest() -> None:
    samples = measure(one(lead=0.55), ramp(), seed=0)
    before = samples.time < 0
    assert samples.time[0] == pytest.approx(-0.55)
    assert before.sum() == 6
    assert set(samples.measured["F"][before]) == {0.0}
    assert samples.measured["F"][~before] == pytest.approx(samples.time[~before], abs=1e-12)


def test_the_stages_clock_differs_from_the_frames_on_a_common_rig_alone() -> None:
    machines: tuple[MachineName, ...] = ("biaxial-hook", "uniaxial-frame")
    data = {name: read_machine(name) for name in machines}
    driven: dict[MachineName, list[Axis]] = {"biaxial-hook": ["C", "W"], "uniaxial-frame": ["P"]}
    stage, frame = instruments_of(driven, data, LogSpec())
    clock = data["biaxial-hook"].clock
    assert clock.offset is not None
    assert clock.skew is not None
    assert (stage.offset, stage.skew) == (clock.offset.value, clock.skew.value)
    assert (frame.offset, frame.skew) == (0.0, 0.0)
    stage, frame = instruments_of(driven, data, LogSpec(clock_offset=-2.0, clock_skew=0.0))
    assert (stage.offset, stage.skew, frame.offset) == (-2.0, 0.0, 0.0)
    (alone,) = instruments_of({"biaxial-hook": ["C", "W"]}, data, LogSpec())
    assert alone == instrument_of("biaxial-hook", data["biaxial-hook"], ["C", "W"], 10.0)
    assert (alone.offset, alone.skew) == (0.0, 0.0)

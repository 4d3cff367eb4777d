"""What an instrument shows of a fibre or a fused point that breaks, and of strands that snap."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.instruments.channels import measure, measured_parts
from rigs.instruments.samples import merged
from rigs.jumps import joined, jump_times, jumped, parted
from rigs.logs.catalogue import LOGS
from rigs.trace import trace_of
from tests.logged_forces import logged_forces
from tests.synthetic_run import SIZE, row, stage_instrument

if TYPE_CHECKING:
    from rigs.record import Equilibrium
    from rigs.trace import Trace

PEAK, DROP, AT = 2.0, 0.5, 1.234
"""Force before and after the jump [N], and its time [s]."""


def pull(kind: str, late: float = 0.0) -> Trace:
    """Return a pull at 1 N/s that jumps at AT; the first row after it is so much later [s]."""

    def at(time: float, force: float, **after: float) -> Equilibrium:
        return replace(
            row(time, 0.01 * time, 1, "Stretch"),
            force={"C": force, "W": 2.0 * force},
            **after,  # type: ignore[arg-type]
        )

    after = {kind: 1.0} if kind == "bonds_broken" else {kind: 1e-2}
    rows = [at(0.0, PEAK - AT), at(0.7, PEAK - AT + 0.7), at(AT, PEAK)]
    rows += [at(time, DROP + time - AT - late, **after) for time in (AT + late, 1.9, 2.6)]
    return trace_of(rows)


KINDS = pytest.mark.parametrize("kind", ["fracture_work", "bonds_broken", "snap_work"])
LATE = pytest.mark.parametrize("late", [0.0, 0.05, 0.3])


@KINDS
@LATE
@pytest.mark.parametrize("rate", [3.0, 10.0, 97.0])
def test_a_jump_is_logged_at_its_time_with_its_peak(kind: str, late: float, rate: float) -> None:
    trace = pull(kind, late)
    samples = measure(stage_instrument(rate), trace, seed=0, noise=False)
    before = samples.time <= AT
    force, beyond = samples.measured["XForce"], (samples.time > AT) & (samples.time <= AT + late)
    # Up to the jump the force rises to its peak; from the next sample on it is what was found after.
    assert force[before] == pytest.approx(PEAK - AT + samples.time[before], abs=1e-9)
    assert force[before].max() > PEAK - 1.0 / rate - 1e-9
    assert np.all(force[beyond] == pytest.approx(DROP))
    later = samples.time > AT + late
    assert np.all((force[later] >= DROP) & (force[later] <= DROP + 2.6 - AT - late + 1e-9))
    assert np.all(np.diff(force[later]) > 0.0)
    assert samples.measured["YForce"] == pytest.approx(2.0 * force)
    # Axes move on steadily.
    assert samples.measured["XDisplacement"] == pytest.approx(0.01 * samples.time * SIZE.extents["C"])


@KINDS
def test_a_jump_is_two_rows_at_one_time(kind: str) -> None:
    assert jumped(pull(kind)).tolist() == jumped(pull(kind, 0.3)).tolist() == [False] * 3 + [True] + [False] * 2
    assert jump_times(pull(kind, 0.3)).tolist() == [AT]
    whole = pull(kind)
    assert parted(whole) is whole
    found = parted(pull(kind, 0.3)).columns
    assert found["time"].tolist() == pytest.approx([0.0, 0.7, AT, AT, AT + 0.3, 1.9, 2.6])
    assert found["force_C"][2:5].tolist() == pytest.approx([PEAK, DROP, DROP])


def test_a_step_that_loses_no_more_than_its_rule_errs_is_no_jump() -> None:
    trace = pull("snap_work", 0.3)
    trace.columns["snap_work"][3:] = 1e-6
    assert not jumped(trace).any()
    assert parted(trace) is trace


@KINDS
def test_a_test_that_ends_with_a_jump_shows_it(kind: str) -> None:
    columns = {name: values[:4] for name, values in pull(kind).columns.items()}
    trace = replace(pull(kind), columns=columns, phase=("Stretch",) * 4, tag=(None,) * 4)
    samples = measure(stage_instrument(10.0), trace, seed=0, noise=False)
    assert samples.time[-2:] == pytest.approx([1.2, 1.3])
    assert samples.measured["XForce"][-2:] == pytest.approx([PEAK - AT + 1.2, DROP])


@pytest.mark.parametrize("dialect", LOGS)
def test_every_dialect_shows_the_peak_and_drops_within_a_sample(dialect: str) -> None:
    force = logged_forces(dialect, pull("fracture_work"))
    peak = int(np.argmax(force))
    assert PEAK - 0.1 <= force[peak] <= PEAK
    assert DROP <= force[peak + 1] <= DROP + 0.1
    assert np.all(np.diff(np.delete(force, peak + 1)[: peak + 1]) > 0.0)


def test_samples_are_not_joined_across_a_jump() -> None:
    time, values = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 10.0, 1.0, 2.0])
    at = np.array([-1.0, 0.5, 1.2, 1.4, 1.41, 1.9, 2.5, 4.0])
    found = joined(at, time, values, np.array([1.4]))
    assert found.tolist() == [0.0, 5.0, 10.0, 10.0, 1.0, 1.0, 1.5, 2.0]
    assert joined(at, time, values, np.zeros(0)).tolist() == np.interp(at, time, values).tolist()


@settings(deadline=None, max_examples=30)
@given(st.integers(1, 40), st.sampled_from([0.0, 0.2]), st.booleans())
def test_a_log_has_the_same_bits_in_parts_of_any_size(most: int, lag: float, noise: bool) -> None:  # noqa: FBT001
    machine = stage_instrument(17.0)
    poor = tuple(replace(channel, lag=lag, drift=1e-3, delay=0.01) for channel in machine.channels)
    machine = replace(machine, channels=poor, skew=1e-3, lead=0.3)
    trace = pull("bonds_broken", 0.3)
    whole = measure(machine, trace, seed=5, noise=noise)
    parts = list(measured_parts(machine, trace, seed=5, noise=noise, most=most))
    assert max(len(part) for part in parts) <= most
    again = merged(parts)
    for kind in ("measured", "clean", "offset"):
        for name, values in getattr(whole, kind).items():
            assert values.tobytes() == getattr(again, kind)[name].tobytes()
    assert whole.time.tobytes() == again.time.tobytes()
    assert whole.phase == again.phase

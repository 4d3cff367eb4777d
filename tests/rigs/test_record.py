from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from rigs.record import PHASES, units
from rigs.trace import trace_of
from tests.synthetic_run import BOTH, row, rows


def test_every_number_of_an_equilibrium_has_a_unit() -> None:
    assert list(row(0.0, 0.0, 1, "Zero").numbers()) == list(units(BOTH))


def test_an_equilibrium_cannot_be_changed() -> None:
    one = row(0.0, 0.0, 1, "Zero")
    with pytest.raises(FrozenInstanceError):
        one.time = 1.0  # type: ignore[misc]


def test_trace_keeps_every_row() -> None:
    made = rows(steps=3)
    trace = trace_of(made)
    assert len(trace) == len(made) == 13
    assert trace.columns["force_W"].tolist() == [one.force["W"] for one in made]
    assert trace.phase[0] == PHASES[0]


def test_strokes_change_with_phase_cycle_and_tag() -> None:
    made = [
        row(0.0, 0.0, 1, "Zero"),
        row(1.0, 0.1, 1, "Stretch"),
        row(2.0, 0.2, 1, "Stretch"),
        row(3.0, 0.1, 1, "Recover"),
        row(4.0, 0.2, 2, "Stretch"),
        replace(row(5.0, 0.3, 2, "Stretch"), tag="other"),
    ]
    assert trace_of(made).strokes().tolist() == [0, 1, 1, 2, 3, 4]
    assert trace_of([]).strokes().shape == (0,)


def test_trace_is_in_double_precision() -> None:
    assert trace_of(rows(2)).columns["cycle"].dtype == np.float64

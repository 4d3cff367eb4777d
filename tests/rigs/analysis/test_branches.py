from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.branches import branch, holds, strokes_of
from rigs.trace import trace_of
from tests.synthetic_run import rows


def test_a_branch_begins_where_it_sets_out_from() -> None:
    trace = trace_of(rows(steps=3))
    cycle = trace.columns["cycle"].astype(np.int64)
    assert branch(trace.phase, cycle, 1, ["Stretch"]).tolist() == [0, 1, 2, 3]
    assert branch(trace.phase, cycle, 1, ["Recover"]).tolist() == [3, 4, 5, 6]
    assert branch(trace.phase, cycle, 2, ["Stretch", "Recover"]).tolist() == list(range(6, 13))
    assert branch(trace.phase, cycle, 9, ["Stretch"]).tolist() == []


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_strokes_are_told_from_travel_alone(noise: float) -> None:
    up, down = np.linspace(0.0, 1.0, 100), np.linspace(1.0, 0.1, 90)
    parts = [np.zeros(20), up, np.ones(30), down, np.linspace(0.1, 1.0, 90), down]
    phases = ["Hold", "Stretch", "Hold", "Recover", "Stretch", "Recover"]
    travel = np.concatenate(parts) + noise * np.random.default_rng(4).uniform(-1.0, 1.0, 420)
    cycle, phase = strokes_of(travel)
    at = np.cumsum([0, *map(len, parts)])
    middle = (at[:-1] + at[1:]) // 2
    assert [phase[row] for row in middle] == phases
    assert cycle[middle].tolist() == [1, 1, 1, 1, 2, 2]
    assert [part.start for part in holds(phase)] == pytest.approx([0, 119], abs=3)


def test_a_log_that_goes_one_way_is_one_stroke() -> None:
    cycle, phase = strokes_of(np.linspace(0.0, 1.0, 40))
    assert set(cycle.tolist()) == {1}
    assert set(phase) == {"Stretch"}
    cycle, phase = strokes_of(np.linspace(1.0, 0.0, 40))
    assert set(phase[1:]) == {"Recover"}
    assert strokes_of(np.zeros(0))[1] == ()


def test_holds_keep_the_row_they_set_out_from() -> None:
    assert holds(["Zero", "Stretch", "Hold", "Hold", "Recover", "Hold"]) == [slice(1, 4), slice(4, 6)]
    assert holds(["Hold"]) == [slice(0, 1)]

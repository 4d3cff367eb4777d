from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.cycles import cycle_figures
from rigs.analysis.stress_strain import stress_strain
from rigs.trace import trace_of
from tests.synthetic_run import SIZE, rows


def test_figures_of_the_made_up_test() -> None:
    trace = trace_of(rows(steps=40))
    cycle = trace.columns["cycle"].astype(np.int64)
    strain, stress = stress_strain(trace.columns["displacement_C"], trace.columns["force_C"], "C", SIZE)
    first, second = cycle_figures("C", strain, stress, trace.phase, cycle)
    assert (first.cycle, second.cycle, first.axis) == (1, 2, "C")
    assert first.stress[0.4] == pytest.approx(90 * (np.exp(16.5 * 0.4) - 1))
    assert first.stress[0.2] == pytest.approx(90 * (np.exp(16.5 * 0.2) - 1))
    assert first.loading_work > second.loading_work
    assert 0 < first.loop_area < first.loading_work
    assert first.hysteresis == pytest.approx(first.loop_area / first.loading_work)


@pytest.mark.parametrize("kept", [8, 18])
def test_a_cycle_cut_off_has_no_loop(kept: int) -> None:
    # Ten rows up, ten down: cut on the way up, and on the way back.
    trace = trace_of(rows(steps=10)[:kept])
    cycle = trace.columns["cycle"].astype(np.int64)
    strain, stress = stress_strain(trace.columns["displacement_C"], trace.columns["force_C"], "C", SIZE)
    (only,) = cycle_figures("C", strain, stress, trace.phase, cycle)
    assert np.isnan(only.loop_area)
    assert np.isnan(only.hysteresis)
    assert np.isnan(only.stress[0.3]) == (kept == 8)
    assert only.stress[0.2] > 0

from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.holding import creeps, hold_figures


def test_relaxation_along_the_logarithm_of_time() -> None:
    time = np.concatenate([[0.0], np.geomspace(1.0, 1000.0, 200)])
    stress = np.concatenate([[100.0], 100.0 - 10.0 * np.log10(time[1:])])
    found = hold_figures(time + 50.0, stress)
    assert found.per_decade == pytest.approx(-10.0)
    assert found.per_decade_low <= -10.0 <= found.per_decade_high + 1e-9
    assert (found.start, found.end, found.change, found.duration) == pytest.approx((100.0, 70.0, -0.3, 1000.0))
    # Half of 30 is lost after 10^1.5 s.
    assert found.half_time == pytest.approx(10**1.5, rel=0.02)


def test_a_maxwell_element_relaxes_by_half_at_its_own_time() -> None:
    time = np.linspace(0.0, 60.0, 3001)
    found = hold_figures(time, 20.0 + 80.0 * np.exp(-time / 2.0))
    assert found.half_time == pytest.approx(2.0 * np.log(2.0), rel=1e-3)
    assert found.final_rate == pytest.approx(0.0, abs=1e-6)


def test_steady_creep_has_its_rate() -> None:
    time = np.linspace(0.0, 100.0, 101)
    found = hold_figures(time, 0.1 + 2e-4 * time)
    assert found.final_rate == pytest.approx(2e-4)
    assert found.change == pytest.approx(0.2)


def test_what_is_held_is_told() -> None:
    time = np.linspace(0.0, 1.0, 30)
    assert creeps(0.1 + 0.01 * time, np.full(30, 5.0))
    assert not creeps(np.full(30, 0.1), 5.0 - time)

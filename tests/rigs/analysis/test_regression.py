from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from rigs.analysis.regression import fit_line, segment_modulus, window


@settings(deadline=None, max_examples=30)
@given(slope=st.floats(-1e3, 1e3), start=st.floats(-1e3, 1e3), seed=st.integers(0, 2**32 - 1))
def test_a_line_is_that_of_scipy_with_its_interval(slope: float, start: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 1.0, 30))
    y = start + slope * x + rng.normal(0.0, 0.1, 30)
    found, other = fit_line(x, y), stats.linregress(x, y)
    half = stats.t.ppf(0.975, 28) * other.stderr
    size = abs(slope) + abs(start) + 1.0
    assert found.slope == pytest.approx(other.slope, abs=1e-9 * size)
    assert found.intercept == pytest.approx(other.intercept, abs=1e-9 * size)
    assert (found.low, found.high) == pytest.approx((other.slope - half, other.slope + half), abs=1e-9 * size)
    assert found.r2 == pytest.approx(other.rvalue**2, abs=1e-9)


def test_an_interval_holds_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(3)
    x = np.linspace(0.0, 1.0, 12)
    fits = [fit_line(x, 2.0 + 5.0 * x + rng.normal(0.0, 1.0, 12), 0.9) for _ in range(2000)]
    held = np.mean([fit.low <= 5.0 <= fit.high for fit in fits])
    # 2000 trials of 0.9: three deviations are 0.02.
    assert held == pytest.approx(0.9, abs=0.02)


def test_points_at_one_place_make_no_line() -> None:
    assert np.isnan(fit_line(np.full(9, 0.3), np.arange(9.0)).slope)
    assert np.isnan(fit_line(np.array([0.0, 1.0]), np.array([0.0, 1.0])).slope)


def test_a_modulus_over_a_window_does_not_hang_on_the_step_of_the_solver() -> None:
    # One step of 1.25 % up a curve that stiffens: its chord is far off over the first 0.4 %.
    strain = np.linspace(0.0, 0.2, 17)
    stress = 100.0 * strain + 4e3 * strain**2
    exact = 100.0 + 4e3 * 0.004
    step = stress[1] / strain[1]
    found = segment_modulus(strain, stress, 0.0, 0.004)
    assert abs(step / exact - 1.0) > 0.2
    assert found.slope == pytest.approx(exact, rel=0.05)
    assert found.points > 50


def test_a_noisy_log_is_fitted_through_its_rows() -> None:
    rng = np.random.default_rng(5)
    strain = np.linspace(0.0, 0.1, 400) + rng.normal(0.0, 1e-5, 400)
    found = segment_modulus(strain, 2e3 * strain + rng.normal(0.0, 1.0, 400), 0.02, 0.06)
    assert found.points == np.count_nonzero((strain >= 0.02) & (strain <= 0.06))
    assert found.low < 2e3 < found.high


def test_nothing_is_read_beyond_the_rows() -> None:
    strain, stress = np.array([0.0, 0.05, 0.1]), np.array([0.0, 1.0, 2.0])
    assert np.isnan(segment_modulus(strain, stress, 0.05, 0.2).slope)
    assert np.isnan(segment_modulus(strain, stress, -0.1, 0.05).slope)
    x, _ = window(strain, stress, 0.05, 0.2)
    assert x.max() <= 0.1

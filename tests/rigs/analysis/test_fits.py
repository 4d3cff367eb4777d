from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.analysis.fits import exponential_fit, exponential_or_kinked, kinked_fit


@settings(deadline=None, max_examples=30)
@given(rate=st.floats(1.0, 60.0), amplitude=st.floats(1e-3, 1e6), rows=st.integers(4, 60))
def test_a_known_exponential_is_found(rate: float, amplitude: float, rows: int) -> None:
    strain = np.linspace(0.0, 0.4, rows)
    found = exponential_fit(strain, amplitude * np.exp(rate * strain), 0.0, 0.4)
    # Few rows are read along the shape-preserving cubic, which is not the exponential between them.
    if rows >= 8:
        assert found.rate == pytest.approx(rate, rel=1e-9)
        assert found.amplitude == pytest.approx(amplitude, rel=1e-8)
        assert found.rate_low <= found.rate <= found.rate_high
        assert found.r2 == pytest.approx(1.0, abs=1e-9)
    else:
        assert found.rate > 0.0


def test_the_interval_of_the_rate_holds_the_truth_as_often_as_it_says() -> None:
    rng, strain = np.random.default_rng(2), np.linspace(0.0, 0.4, 40)
    fits = [
        exponential_fit(strain, 90.0 * np.exp(16.5 * strain + rng.normal(0.0, 0.2, 40)), 0.0, 0.4) for _ in range(1000)
    ]
    held = np.mean([fit.rate_low <= 16.5 <= fit.rate_high for fit in fits])
    assert held == pytest.approx(0.95, abs=0.021)


def test_the_window_counts_alone() -> None:
    strain = np.linspace(0.0, 0.4, 81)
    stress = np.where(strain < 0.2, 7.0, 7.0 * np.exp(9.0 * (strain - 0.2)))
    found = exponential_fit(strain, stress, 0.2, 0.4)
    assert found.rate == pytest.approx(9.0, rel=1e-9)
    assert (found.first, found.last, found.points) == (0.2, 0.4, 41)
    assert exponential_fit(strain, stress, 0.0, 0.4).r2 < 0.95


@pytest.mark.parametrize("kink", [0.05, 0.17, 0.33])
def test_a_known_kink_is_found(kink: float) -> None:
    x = np.linspace(0.0, 0.4, 120)
    found = kinked_fit(x, 3.0 + 10.0 * x + 90.0 * np.maximum(x - kink, 0.0))
    assert found.kink == pytest.approx(kink, abs=1e-5)
    assert (found.start, found.below, found.above) == pytest.approx((3.0, 10.0, 100.0), rel=1e-3)


def test_each_shape_is_told_from_the_other_through_noise() -> None:
    rng, strain = np.random.default_rng(7), np.linspace(0.0, 0.4, 150)
    curved = 1e3 * np.exp(16.5 * strain)
    kinked = 1e4 * strain + 2e6 * np.maximum(strain - 0.25, 0.0)
    for stress, weight in ((curved, 1.0), (kinked, 0.0)):
        found = exponential_or_kinked(strain, stress + rng.normal(0.0, 0.02 * stress.max(), 150), 0.0, 0.4)
        assert found.weight == pytest.approx(weight, abs=1e-3)
        assert max(found.exponential_r2, found.kinked_r2) > 0.98
    assert found.kink == pytest.approx(0.25, abs=0.02)
    assert found.above == pytest.approx(2.01e6, rel=0.05)


def test_too_few_points_are_not_compared() -> None:
    strain = np.array([0.0, 0.1, 0.1, 0.2])
    assert np.isnan(exponential_or_kinked(strain, strain, 0.0, 0.2).weight)

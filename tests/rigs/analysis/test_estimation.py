"""Estimates: intervals against the textbook's, and directions that the data do not see."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import linregress, t

from rigs.analysis.estimation import Bounded, effective_count, estimates, without_roughness

A = Bounded(name="a", low=-1.0, high=1.0, start=0.0, unit="mm")
B = Bounded(name="b", low=-1.0, high=3.0, start=0.0)
E = Bounded(name="E", low=0.5, high=2.0, start=1.0, unit="GPa")


def test_the_interval_of_a_slope_is_that_of_regression() -> None:
    x = np.linspace(0.0, 1.0, 400)
    y = 0.3 + 0.5 * x + np.random.default_rng(3).normal(0.0, 0.05, 400)
    line = linregress(x, y)
    misfit = line.intercept + line.slope * x - y
    z = np.array([A.coordinate(line.intercept), B.coordinate(line.slope)])
    # dy/dz is dy/da times the width of the bounds.
    found = estimates([A, B], z, np.stack([2.0 * np.ones(400), 4.0 * x], axis=1), [misfit])
    half = t.ppf(0.975, 398) * line.stderr
    slope = found.each[1]
    assert slope.value == pytest.approx(line.slope, rel=1e-6)
    independent = (400 / effective_count([misfit])) ** 0.5
    assert 0.5 * (slope.high - slope.low) == pytest.approx(half * independent, rel=1e-3)
    assert found.correlation[0, 1] == pytest.approx(-np.mean(x) / np.mean(x**2) ** 0.5, rel=1e-6)
    assert not found.unseen


def test_two_parameters_of_one_effect_are_named_together() -> None:
    effect = np.linspace(0.0, 0.5, 300)
    other = np.cos(np.linspace(0.0, 9.0, 300))
    misfit = np.random.default_rng(1).normal(0.0, 0.01, 300)
    jacobian = np.stack([effect, 2.0 * effect, other], axis=1)
    found = estimates([A, E, B], np.full(3, 0.5), jacobian, [misfit])
    assert [np.isfinite(one.value) for one in found.each] == [False, False, True]
    assert np.isfinite(found.each[2].low)
    (line,) = found.unseen
    assert line.startswith("a and E cannot be told apart: a +0.2 mm with E -6.7 %")


def test_an_effect_within_the_roughness_of_runs_is_no_direction_of_the_search() -> None:
    jacobian = np.stack([np.linspace(0.0, 1.0, 200), np.full(200, 1e-5)], axis=1)
    kept = without_roughness(jacobian)
    assert np.linalg.matrix_rank(kept, tol=1e-9) == 1
    assert np.allclose(kept[:, 0], jacobian[:, 0], atol=1e-4)


def test_an_estimate_at_a_bound_is_named_and_has_no_interval() -> None:
    # The misfit that a bound leaves is smooth and large.
    effect = np.linspace(0.0, 0.3, 50)
    found = estimates([E], np.array([1e-4]), effect[:, None], [0.5 * effect])
    (one,) = found.each
    assert one.at_bound == "lower"
    assert one.value == pytest.approx(0.5, rel=1e-3)
    assert np.isnan(one.low)
    assert not found.unseen


def test_correlated_residuals_count_for_fewer() -> None:
    rng = np.random.default_rng(5)
    white = rng.normal(size=4000)
    slow = np.zeros(4000)
    for k in range(1, 4000):
        slow[k] = 0.8 * slow[k - 1] + white[k]
    assert effective_count([white]) == pytest.approx(4000, rel=0.1)
    assert effective_count([slow]) == pytest.approx(4000 * 0.2 / 1.8, rel=0.15)


def test_a_value_comes_back_from_its_coordinate() -> None:
    for one, value in ((E, 0.9), (A, -0.25)):
        assert one.value(one.coordinate(value)) == pytest.approx(value, rel=1e-7)

from __future__ import annotations

import math

import numpy as np
import pytest

from rigs.analysis.onset import first_reached, half_rise, toe


def test_half_of_a_rise_is_read_between_rows() -> None:
    x = np.array([0.0, 1.0, 2.0, 4.0])
    assert half_rise(x, np.array([2.0, 2.0, 4.0, 12.0])) == pytest.approx(2.0 + 2.0 * 3.0 / 8.0)
    assert half_rise(x, x**2) == pytest.approx(2.0 + 2.0 * 4.0 / 12.0)


def test_a_square_rises_later_than_a_line() -> None:
    x = np.linspace(0.0, 1.0, 501)
    assert half_rise(x, x) == pytest.approx(0.5, abs=1e-6)
    assert half_rise(x, x**2) == pytest.approx(math.sqrt(0.5), abs=1e-5)


@pytest.mark.parametrize("y", [np.array([1.0, 2.0, 1.0]), np.array([1.0]), np.array([3.0, 2.0, 1.0])])
def test_what_does_not_rise_has_no_half(y: np.ndarray) -> None:
    assert math.isnan(half_rise(np.arange(len(y), dtype=float), y))


def test_a_level_above_all_is_not_reached_and_one_at_the_start_is_reached_there() -> None:
    x, y = np.array([0.1, 0.2]), np.array([1.0, 2.0])
    assert math.isnan(first_reached(x, y, 3.0))
    assert first_reached(x, y, 0.5) == 0.1


def test_the_toe_of_a_kinked_line_is_past_its_slack() -> None:
    strain = np.linspace(0.0, 0.4, 41)
    stress = 1e5 * np.maximum(strain - 0.2, 0.0)
    assert toe(strain, stress, float(stress[-1])) == pytest.approx(0.2 + 0.05 * 0.2)

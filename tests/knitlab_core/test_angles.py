from __future__ import annotations

import math

import numpy as np
import pytest

from knitlab_core.angle_kernels import power
from knitlab_core.angles import arc_tangents, cosines_sines, exponential

MANY = np.concatenate([np.linspace(-9.0, 9.0, 40001), np.linspace(-1e-3, 1e-3, 1001), [0.0, -1e6, 1e6, 1e-300]])


def test_cosine_and_sine_are_those_of_the_library_to_the_last_bit_or_two() -> None:
    cosines, sines = cosines_sines(MANY)
    assert np.abs(cosines - np.cos(MANY)).max() <= 2.3e-16
    assert np.abs(sines - np.sin(MANY)).max() <= 2.3e-16
    small = np.abs(MANY) < 0.5
    np.testing.assert_allclose(sines[small], np.sin(MANY[small]), rtol=3e-16)
    # Near multiples of half a turn, where almost nothing is left.
    turns = np.pi * np.arange(-300.0, 301.0)
    np.testing.assert_allclose(cosines_sines(turns)[1], np.sin(turns), rtol=1e-13, atol=1e-30)


def test_arc_tangent_in_all_quarters() -> None:
    for radius in (1e-12, 1.0, 1e12):
        y, x = radius * np.sin(MANY), radius * np.cos(MANY)
        np.testing.assert_allclose(arc_tangents(y, x), np.arctan2(y, x), rtol=4e-16, atol=1e-320)
    y, x = np.array([0.0, 0.0, 1.0, -1.0, 0.0, 2.0]), np.array([0.0, 1.0, 0.0, 0.0, -1.0, 1e-300])
    assert arc_tangents(y, x) == pytest.approx(np.arctan2(y, x), rel=1e-15)


def test_exponential() -> None:
    for x in np.linspace(-700.0, 50.0, 3001):
        assert exponential(float(x)) == pytest.approx(math.exp(x), rel=3e-16)
    assert exponential(0.0) == 1.0
    assert exponential(-1e4) == 0.0


@pytest.mark.parametrize("exponent", [2.4, 0.37, -1.4, 6.0])
def test_power(exponent: float) -> None:
    # Of logarithm and exponential each adds a rounding, that of the logarithm times its size.
    for x in np.concatenate([np.logspace(-12.0, 12.0, 301), 1.0 + np.linspace(-1e-3, 1e-3, 21)]):
        size = 1.0 + abs(exponent * math.log(x))
        assert power(float(x), exponent) == pytest.approx(float(x) ** exponent, rel=3e-16 * size)
    assert power(1.0, exponent) == 1.0

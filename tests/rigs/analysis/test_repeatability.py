from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.analysis.repeatability import band_of, common_range, curve_nrmse, nrmse, read_at

X = np.linspace(0.0, 1.0, 60)


@settings(deadline=None, max_examples=30)
@given(shift=st.floats(-2.0, 2.0), scale=st.floats(0.1, 10.0))
def test_a_shifted_curve_is_off_by_the_shift_over_the_range(shift: float, scale: float) -> None:
    assert nrmse(scale * X, scale * (X + shift)) == pytest.approx(abs(shift), abs=1e-12)
    assert nrmse(X, X) == 0.0


def test_curves_on_other_rows_are_compared_where_both_are() -> None:
    one = (X, X**2)
    x = np.linspace(0.2, 1.4, 333)
    assert curve_nrmse(one, (x, x**2)) == pytest.approx(0.0, abs=1e-3)
    # Over 0.2 to 1 the reference has a range of 0.96.
    assert curve_nrmse((X, X**2), (x, x**2 + 0.096)) == pytest.approx(0.1, abs=1e-3)
    assert np.isnan(curve_nrmse(one, (X + 2.0, X)))


def test_a_branch_with_noise_is_read_where_it_first_gets_there() -> None:
    x, y = np.array([0.0, 0.2, 0.1, 0.4]), np.array([0.0, 2.0, 9.0, 4.0])
    assert read_at(x, y, np.array([0.1, 0.3, 0.5])) == pytest.approx([1.0, 3.0, np.nan], nan_ok=True)


def test_a_band_holds_its_curves() -> None:
    curves = [(X, factor * X) for factor in (1.0, 2.0, 3.0)]
    band = band_of(curves)
    assert band is not None
    assert band.repeats == 3
    for found, factor in ((band.low, 1.0), (band.mean, 2.0), (band.high, 3.0), (band.deviation, 1.0)):
        assert found == pytest.approx(factor * band.x)
    assert band_of([(X, X), (X + 5.0, X)]) is None
    assert len(common_range([])) == 0

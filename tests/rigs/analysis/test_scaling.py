from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.analysis.master_curve import Design
from rigs.analysis.scaling import scaling_test

STRAIN = np.linspace(0.0, 0.4, 81)


def designs(levels: np.ndarray) -> list[Design]:
    """Return exponentials that differ by a factor alone."""
    return [
        Design(name=str(k), axis="C", values={}, strain=STRAIN, stress=level * np.exp(16.5 * STRAIN))
        for k, level in enumerate(levels)
    ]


def test_factors_that_undo_the_levels_leave_one_curve() -> None:
    levels = np.exp(np.linspace(0.0, 3.0, 12))
    found = scaling_test(designs(levels), list(1.0 / levels), (0.2, 0.4))
    assert found.before == pytest.approx(float(np.std(np.log(levels), ddof=1)))
    assert found.after == pytest.approx(0.0, abs=1e-9)
    assert found.r_squared == pytest.approx(1.0)
    assert found.left_out == pytest.approx(0.0, abs=1e-9)
    assert found.p_value < 0.01


def test_a_design_left_out_is_missed_by_what_the_others_do_not_know() -> None:
    levels = np.exp(np.array([0.0] * 9 + [1.0]))
    found = scaling_test(designs(levels), [1.0] * 10, (0.2, 0.4))
    errors = np.array([1.0 / 9.0] * 9 + [1.0])
    assert found.left_out == pytest.approx(float(np.sqrt(np.mean(errors**2))))
    assert found.r_squared == pytest.approx(0.0, abs=1e-12)
    assert found.p_value == 1.0


def test_factors_of_the_wrong_sign_spread_the_curves() -> None:
    levels = np.exp(np.linspace(0.0, 3.0, 12))
    found = scaling_test(designs(levels), list(levels), (0.2, 0.4))
    assert found.after == pytest.approx(2.0 * found.before)
    assert found.r_squared == pytest.approx(-3.0)


@pytest.mark.parametrize(("count", "between"), [(7, (0.2, 0.4)), (9, (0.5, 0.6))])
def test_too_few_curves_or_none_in_common_are_refused(count: int, between: tuple[float, float]) -> None:
    with pytest.raises(SpecificationError, match="designs"):
        scaling_test(designs(np.ones(count)), [1.0] * count, between)

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigs.analysis.work import cycle_work, hysteresis, loading_work_ratios, loop_area, summed_hysteresis

if TYPE_CHECKING:
    from rigs.axes import FloatArray

# A parallelogram: loads with slope 2 above an offset of 1, unloads with slope 2 from it.
STRAIN = np.array([0.0, 0.0, 0.5, 0.5, 0.0])
STRESS = np.array([0.0, 1.0, 2.0, 1.0, 0.0])


def test_loop_area_of_a_parallelogram() -> None:
    assert loop_area(STRAIN, STRESS) == pytest.approx(0.5)
    assert loop_area(STRAIN[::-1], STRESS[::-1]) == pytest.approx(-0.5)


def test_an_elastic_loop_dissipates_nothing() -> None:
    up = np.linspace(0, 1, 50)
    strain = np.concatenate([up, up[::-1]])
    assert loop_area(strain, strain**3) == pytest.approx(0.0, abs=1e-15)
    assert hysteresis(strain, strain**3) == pytest.approx(0.0, abs=1e-15)


def test_work_of_a_spring_is_half_k_x_squared() -> None:
    strain = np.linspace(0, 0.4, 5)
    assert cycle_work(strain, 30 * strain) == pytest.approx(0.5 * 30 * 0.4**2)


def test_hysteresis_is_the_lost_share() -> None:
    up = np.linspace(0, 1, 201)
    strain = np.concatenate([up, up[::-1]])
    stress = np.concatenate([up, 0.75 * up[::-1]])
    # Both ways are straight, but for the jump of the load at the peak.
    assert hysteresis(strain, stress) == pytest.approx(0.25, rel=1e-3)
    assert np.isnan(hysteresis(strain, 0 * stress))


def bent(rows: int) -> FloatArray:
    """Return strains from 0 to 1, of rows that crowd together in the middle of the way."""
    x = np.linspace(0.0, 1.0, rows)
    return x + 0.1 * np.sin(2.0 * np.pi * x)


def test_work_of_a_smooth_curve_is_of_third_order_or_better() -> None:
    exact = (np.exp(4.0) - 1.0) / 4.0
    error = [abs(cycle_work(bent(rows), np.exp(4.0 * bent(rows))) - exact) for rows in (11, 21, 41, 81)]
    order = np.log2(np.divide(error[:-1], error[1:]))
    assert np.all(order > 2.9)
    trapezium = np.trapezoid(np.exp(4.0 * bent(21)), bent(21)) - exact
    assert error[1] < 0.05 * trapezium


def test_loop_area_of_a_curve_that_stiffens_needs_few_rows() -> None:
    # Up along x³, back along x⁵, in rows that stand elsewhere on the way back.
    up, down = bent(15), bent(20)[::-1]
    strain, stress = np.concatenate([up, down]), np.concatenate([up**3, down**5])
    assert loop_area(strain, stress) == pytest.approx(1.0 / 4.0 - 1.0 / 6.0, rel=5e-3)
    assert loop_area(strain[::-1], stress[::-1]) == pytest.approx(-loop_area(strain, stress), rel=1e-12)


@pytest.mark.parametrize("start", [0.0, 0.3, np.pi / 2.0, 2.0])
def test_loop_area_of_an_ellipse_from_anywhere(start: float) -> None:
    angle = start + np.linspace(0.0, 2.0 * np.pi, 201)
    strain, stress = 0.2 + 0.1 * np.cos(angle), 50.0 + 20.0 * np.sin(angle)
    assert loop_area(strain, stress) == pytest.approx(-np.pi * 0.1 * 20.0, rel=2e-3)


def test_a_jump_on_the_way_does_no_work_and_bends_no_curve() -> None:
    # A hold at 0.5 in which stress falls by 1, and rows that stand still to within a rounding error.
    strain = np.array([0.0, 0.25, 0.5, 0.5 + 1e-13, 0.5, 0.75, 1.0, 1.0])
    stress = np.array([0.0, 0.5, 1.0, 0.5, 0.0, 0.5, 1.0, 0.0])
    assert cycle_work(strain, stress) == pytest.approx(0.5, rel=1e-10)
    assert cycle_work(strain[2:5], stress[2:5]) == pytest.approx(0.0, abs=1e-12)
    assert cycle_work(strain[:1], stress[:1]) == cycle_work(strain[:0], stress[:0]) == 0.0


def test_a_log_with_noise_is_integrated_by_the_trapezium_rule() -> None:
    rng = np.random.default_rng(1)
    up = np.linspace(0.0, 0.4, 2000)
    strain = np.concatenate([up, np.full(200, 0.4), up[::-1]])
    stress = np.concatenate([100.0 * up**2, np.full(200, 15.0), 80.0 * up[::-1] ** 2])
    smooth = loop_area(strain, stress)
    strain, stress = strain + 1e-3 * rng.standard_normal(4200), stress + 0.1 * rng.standard_normal(4200)
    by_rows = np.trapezoid(np.append(stress, stress[0]), np.append(strain, strain[0]))
    assert loop_area(strain, stress) == pytest.approx(by_rows, rel=1e-12)
    assert loop_area(strain, stress) == pytest.approx(smooth, rel=0.05)


def test_one_noisy_branch_leaves_the_other_its_curve() -> None:
    x = bent(21)
    up, down = x.copy(), x[::-1].copy()
    down[[9, 10]] = down[[10, 9]]
    strain, stress = np.concatenate([up, down]), np.concatenate([up**3, down**3])
    wanted = cycle_work(up, up**3) + np.trapezoid(down**3, down)
    assert cycle_work(strain, stress) == pytest.approx(wanted, rel=1e-12)
    assert cycle_work(up, up**3) == pytest.approx(0.25, rel=1e-3)


def test_axes_add_up_and_one_alone_may_give_back() -> None:
    assert summed_hysteresis([30.0, -10.0], [60.0, 40.0]) == pytest.approx(0.2)
    assert np.isnan(summed_hysteresis([0.0], [0.0]))


def test_later_loadings_are_measured_by_the_first() -> None:
    assert loading_work_ratios([4.0, 3.0, 3.0]) == pytest.approx([1.0, 0.75, 0.75])
    assert np.isnan(loading_work_ratios([0.0, 1.0])).all()
    assert len(loading_work_ratios([])) == 0

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.analysis import (
    branch,
    cycle_figures,
    cycle_work,
    effective_strain,
    effective_stress,
    hysteresis,
    loop_area,
    secant_modulus,
    stress_at,
    stress_strain,
)
from rigs.record import trace_of
from tests.synthetic_run import SIZE, rows

# A parallelogram: loads with slope 2 above an offset of 1, unloads with slope 2 from it.
STRAIN = np.array([0.0, 0.0, 0.5, 0.5, 0.0])
STRESS = np.array([0.0, 1.0, 2.0, 1.0, 0.0])


def test_effective_quantities_are_quotients() -> None:
    assert effective_strain(np.array([4e-3]), 40e-3) == pytest.approx([0.1])
    assert effective_stress(np.array([2.0]), 50e-6) == pytest.approx([40e3])


def test_each_axis_is_carried_by_the_width_across_it() -> None:
    travel, force = np.array([4.5e-3]), np.array([1.0])
    strain, stress = stress_strain(travel, force, "C", SIZE)
    assert (strain[0], stress[0]) == pytest.approx((0.1, 1.0 / (40e-3 * 1e-3)))
    strain, stress = stress_strain(travel, force, "W", SIZE)
    assert (strain[0], stress[0]) == pytest.approx((0.1125, 1.0 / (45e-3 * 1e-3)))


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


def test_stress_is_read_between_rows_and_only_where_the_branch_is() -> None:
    strain, stress = np.array([0.0, 0.2, 0.39999999]), np.array([0.0, 10.0, 50.0])
    assert stress_at(strain, stress, 0.1) == pytest.approx(5.0)
    assert stress_at(strain, stress, 0.4) == pytest.approx(50.0)
    assert np.isnan(stress_at(strain, stress, 0.41))
    assert np.isnan(stress_at(strain[:0], stress[:0], 0.1))


def test_secant_runs_between_two_strains() -> None:
    strain = np.linspace(0, 0.4, 401)
    assert secant_modulus(strain, 3.0 * strain**2, 0.4) == pytest.approx(3.0 * 0.4)
    assert secant_modulus(strain, 3.0 * strain**2, 0.4, start=0.2) == pytest.approx(3.0 * 0.6)
    with pytest.raises(SpecificationError):
        secant_modulus(strain, strain, 0.2, start=0.2)


def test_a_branch_begins_where_it_sets_out_from() -> None:
    trace = trace_of(rows(steps=3))
    cycle = trace.columns["cycle"].astype(np.int64)
    assert branch(trace.phase, cycle, 1, ["Stretch"]).tolist() == [0, 1, 2, 3]
    assert branch(trace.phase, cycle, 1, ["Recover"]).tolist() == [3, 4, 5, 6]
    assert branch(trace.phase, cycle, 2, ["Stretch", "Recover"]).tolist() == list(range(6, 13))
    assert branch(trace.phase, cycle, 9, ["Stretch"]).tolist() == []


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

from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.cycles import cycle_figures
from rigs.analysis.stress_strain import stress_strain
from rigs.trace import trace_of
from tests.synthetic_run import SIZE, rows


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


def to_and_fro(stiffness: float, friction: float) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Return strain, stress and phases of a cycle from -0.1 to 0.1 and back: a spring beside a slider of Coulomb's."""
    up = np.linspace(-0.1, 0.1, 201)
    strain = np.concatenate([up, up[-2::-1]])
    sign = np.where(np.arange(len(strain)) < len(up), 1.0, -1.0)
    sign[0] = -1.0  # the slider has not turned yet
    return strain, stiffness * strain + friction * sign, ("Zero", *("Stretch",) * 200, *("Recover",) * 200)


def test_of_a_shear_to_and_fro_the_work_is_all_that_it_takes_either_way() -> None:
    stiffness, friction = 1e4, 100.0
    strain, stress, phase = to_and_fro(stiffness, friction)
    cycle = np.ones(len(strain), dtype=np.int64)
    (shear,) = cycle_figures("WC", strain, stress, phase, cycle)  # type: ignore[arg-type]
    area = 4.0 * friction * 0.1
    assert shear.loop_area == pytest.approx(area, rel=0.02)
    # Each way, from where the stress passes zero: a triangle up to the largest stress.
    taken = (stiffness * 0.1 + friction) ** 2 / stiffness
    assert shear.loading_work == pytest.approx(taken, rel=0.02)
    assert shear.hysteresis == pytest.approx(area / taken, rel=0.03)
    assert shear.peak_secant == pytest.approx(stiffness + friction / 0.1, rel=1e-6)
    # A pull counts its way up alone, as ever: there the spring gives back what it takes.
    (pull,) = cycle_figures("W", strain, stress, phase, cycle)  # type: ignore[arg-type]
    assert pull.loading_work == pytest.approx(0.5 * area, rel=0.02)
    assert pull.loop_area == shear.loop_area

from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.stress_strain import effective_strain, effective_stress, stress_strain
from tests.synthetic_run import SIZE


def test_effective_quantities_are_quotients() -> None:
    assert effective_strain(np.array([4e-3]), 40e-3) == pytest.approx([0.1])
    assert effective_stress(np.array([2.0]), 50e-6) == pytest.approx([40e3])


def test_each_axis_is_carried_by_the_width_across_it() -> None:
    travel, force = np.array([4.5e-3]), np.array([1.0])
    strain, stress = stress_strain(travel, force, "C", SIZE)
    assert (strain[0], stress[0]) == pytest.approx((0.1, 1.0 / (40e-3 * 1e-3)))
    strain, stress = stress_strain(travel, force, "W", SIZE)
    assert (strain[0], stress[0]) == pytest.approx((0.1125, 1.0 / (45e-3 * 1e-3)))

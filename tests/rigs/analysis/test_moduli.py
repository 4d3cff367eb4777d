from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.analysis.moduli import secant_modulus, stress_at


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

"""The friction law: exact derivatives, a spring up to its limit, Coulomb's force beyond."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.contact.friction_law import friction_law

LIMIT = 0.02


@pytest.mark.parametrize("slip", [0.001, 0.015, 0.0199, 0.0201, 0.5])
def test_derivatives_against_differences(slip: float) -> None:
    _, over, along = friction_law(slip, LIMIT)
    step = 1e-6
    ahead, behind = friction_law(slip + step, LIMIT), friction_law(slip - step, LIMIT)
    assert (ahead[0] - behind[0]) / (2.0 * step) == pytest.approx(over * slip, rel=1e-8)
    forces = (slip + step) * ahead[1], (slip - step) * behind[1]
    assert (forces[0] - forces[1]) / (2.0 * step) == pytest.approx(along, rel=1e-6, abs=1e-9)


def test_force_rises_to_one_and_stays() -> None:
    slips = np.linspace(0.0, 5.0 * LIMIT, 101)
    force = np.array([slip * friction_law(float(slip), LIMIT)[1] for slip in slips])
    np.testing.assert_allclose(force, np.minimum(slips / LIMIT, 1.0), rtol=1e-14)
    # Energy and force meet at the limit.
    below, above = friction_law(LIMIT * (1.0 - 1e-12), LIMIT), friction_law(LIMIT, LIMIT)
    assert below[0] == pytest.approx(above[0], rel=1e-10)
    assert below[1] == pytest.approx(above[1], rel=1e-10)

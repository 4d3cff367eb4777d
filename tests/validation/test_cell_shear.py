"""Shear of a periodic cell: what its vectors are pulled with sideways, driven and free."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.validation.cells import CellTest, make_test

if TYPE_CHECKING:
    from collections.abc import Callable

SHEAR = 0.15
SMALL = 3e-5


@pytest.fixture(scope="module", name="sheared", params=["stockinette-default", "volumetric-default"])
def _sheared(request: pytest.FixtureRequest) -> CellTest:
    """Return a cell without friction that is stretched, and leans along the course, and the wale of its pile too."""
    planar = request.param == "stockinette-default"
    test = make_test((1, 1) if planar else (1, 1, 2), knit=request.param)
    strain = 0.36 if planar else 0.22
    vectors = (1.0 + strain) * test.printed
    test.go(vectors, steps=8)
    for vector in range(1, len(vectors)):
        vectors[vector, vector - 1] = SHEAR * vectors[vector, vector]
    test.go(vectors, steps=4)
    return test


def test_forces_on_a_sheared_cell_are_slopes_of_its_energy(sheared: CellTest, bar: Callable[..., None]) -> None:
    """Of every component of the vectors: those that turn the cell as a whole too."""
    begun, vectors, forces = sheared.state, sheared.vectors.copy(), sheared.forces.copy()
    errors = []
    for vector, along in np.ndindex(*vectors.shape):
        if along < len(vectors):
            energies = []
            for way in (-1.0, 1.0):
                sheared.state = begun
                moved = vectors.copy()
                moved[vector, along] += way * SMALL * vectors[vector, vector]
                sheared.go(moved)
                energies.append(sheared.energy)
            slope = (energies[1] - energies[0]) / (2.0 * SMALL * vectors[vector, vector])
            errors.append(slope - forces[vector, along])
    sheared.state = begun
    error = np.abs(errors).max() / np.abs(forces).max()
    bar(f"shear: forces against slopes, {len(vectors)}-D cell", error, 1e-6, "1", "virtual work")


def test_the_stress_of_a_sheared_cell_is_symmetric(sheared: CellTest, bar: Callable[..., None]) -> None:
    """Nothing turns it: the virial sum_d f_d c_d has no skew part, though forces and vectors are at angles."""
    virial = sheared.forces.T @ sheared.vectors
    error = max(abs(virial[a, b] - virial[b, a]) for a, b in combinations(range(3), 2)) / np.abs(virial).max()
    # Links against turning are weak, not nil: they hold strands that touch nothing.
    limit = 1e-6 if len(sheared.vectors) == 2 else 1e-5
    bar(f"shear: skew part of stress, {len(sheared.vectors)}-D cell", error, limit, "1", "balance of moments")
    assert abs(virial[0, 1]) > 0.01 * np.abs(virial).max()


def test_a_planar_cell_that_is_free_to_shear_comes_back_upright(bar: Callable[..., None]) -> None:
    """Stockinette is the same seen from the back of its course: stretched along its axes it does not shear."""
    test = make_test((1, 1))
    upright = 1.36 * test.printed
    test.go(upright, steps=8)
    force = np.abs(test.forces).max()
    leaning = upright.copy()
    leaning[1, 0] = SHEAR * upright[1, 1]
    test.go(leaning, steps=4)
    assert test.forces[1, 0] > 0.01 * force
    test.release({(1, 0)})
    # Lengths go to and fro for free unknowns to move.
    test.go(1.001 * upright)
    test.go(upright)
    bar("shear: angle of free stockinette", test.vectors[1, 0] / test.vectors[1, 1], 1e-4, "1", "symmetry")

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from knitlab_core.knits.near_points import pairs_within


@pytest.mark.parametrize("reach", [0.01, 0.1, 0.5, 4.0])
@pytest.mark.parametrize("flat", [False, True])
def test_pairs_are_those_of_a_tree(reach: float, *, flat: bool) -> None:
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (400, 3))
    if flat:
        points[:, 2] = 0.25
    found = {tuple(pair) for pair in pairs_within(points, reach).tolist()}
    assert found == cKDTree(points).query_pairs(reach)
    assert len(found) == len(pairs_within(points, reach))


def test_points_on_the_borders_of_cells_are_not_missed() -> None:
    line = 0.1 * np.arange(50.0)[:, None] * np.array([1.0, 0.0, 0.0])
    assert {tuple(pair) for pair in pairs_within(line, 0.1 * (1.0 + 1e-12)).tolist()} == {(k, k + 1) for k in range(49)}

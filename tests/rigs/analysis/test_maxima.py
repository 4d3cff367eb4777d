from __future__ import annotations

import numpy as np

from rigs.analysis.maxima import row_of_break, row_of_maximum


def test_the_largest_force_is_found_beside_gaps() -> None:
    assert row_of_maximum(np.array([0.0, np.nan, 3.0, 2.0])) == 2
    assert row_of_maximum(np.array([0.0, -1.0])) is None
    assert row_of_maximum(np.zeros(0)) is None


def test_break_is_the_last_row_before_the_fall() -> None:
    travel = np.arange(7.0)
    force = np.array([0.0, 1.0, 2.0, 5.0, 4.0, 2.9, 0.1])
    assert row_of_break(travel, force) == 4
    assert row_of_break(travel, force, drop=0.9) == 5
    assert row_of_break(travel[:5], force[:5]) is None


def test_unloading_is_no_break() -> None:
    travel = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0, 50)])
    assert row_of_break(travel, travel**3) is None
    # A specimen that breaks in its second loading does.
    again = np.concatenate([travel, np.linspace(0, 1.2, 60), [1.2]])
    force = np.append(again[:-1] ** 3, 0.0)
    assert row_of_break(again, force) == len(again) - 2

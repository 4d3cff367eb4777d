from __future__ import annotations

import numpy as np
import pytest

from rigs.control.root_finding import FloatArray, find_root


def box(low: float, high: float, size: int = 1) -> FloatArray:
    return np.array([[low] * size, [high] * size])


@pytest.mark.parametrize("slope", [1e-3, 1.0, 1e6, 0.0, -1.0])
def test_one_unknown_is_found_from_any_guess_of_the_slope(slope: float) -> None:
    root = find_root(lambda x: 1e4 * (np.exp(8.0 * x) - 5.0), np.zeros(1), np.array([[slope]]), box(-1.0, 1.0))
    assert root is not None
    assert root.met
    assert abs(1e4 * (np.exp(8.0 * root.at[0]) - 5.0)) <= 1.0


def test_a_slack_that_becomes_taut_is_found() -> None:
    root = find_root(lambda x: 1e5 * np.maximum(x - 0.3, 0.0) - 10.0, np.zeros(1), np.eye(1), box(-1.0, 1.0))
    assert root is not None
    assert root.at[0] == pytest.approx(0.3 + 1e-4, abs=2e-5)


def test_a_root_beyond_the_box_is_not_met_and_the_search_ends_at_its_edge() -> None:
    root = find_root(lambda x: 100.0 * (x - 3.0), np.zeros(1), np.eye(1), box(-1.0, 1.0))
    assert root is not None
    assert (root.met, root.at[0]) == (False, 1.0)


def test_a_jump_counts_as_a_root() -> None:
    root = find_root(lambda x: np.where(x < 0.2, -50.0, 50.0), np.zeros(1), np.eye(1), box(-1.0, 1.0))
    assert root is not None
    assert root.met
    assert root.at[0] == pytest.approx(0.2, abs=1e-8)


def test_several_unknowns_are_found_together() -> None:
    def function(x: FloatArray) -> FloatArray:
        return np.array([50.0 * (x[0] + x[1] ** 3 - 0.5), 80.0 * (np.sinh(x[1]) - 0.4 * x[0])])

    root = find_root(function, np.zeros(2), np.diag([50.0, 80.0]), box(-1.0, 1.0, 2))
    assert root is not None
    assert root.met
    assert np.abs(function(root.at)).max() <= 1.0


def test_a_place_without_values_is_stepped_back_from() -> None:
    def function(x: FloatArray) -> FloatArray | None:
        return None if x[0] > 0.5 else 1e3 * (x - 0.4)

    root = find_root(function, np.array([0.9]), np.eye(1), box(-1.0, 1.0))
    assert root is not None
    assert root.at[0] == pytest.approx(0.4, abs=1e-3)


def test_a_function_without_values_has_no_root() -> None:
    assert find_root(lambda _: None, np.zeros(1), np.eye(1), box(-1.0, 1.0)) is None


def test_the_last_place_tried_is_the_one_returned() -> None:
    tried: list[FloatArray] = []

    def function(x: FloatArray) -> FloatArray:
        tried.append(x.copy())
        return np.array([3.0 * x[0] ** 3 + 9.0 * x[0] + x[1] - 2.0, 5.0 * x[1] + x[0] - 20.0])

    root = find_root(function, np.zeros(2), np.eye(2), box(-9.0, 9.0, 2))
    assert root is not None
    assert tried[-1].tolist() == root.at.tolist()

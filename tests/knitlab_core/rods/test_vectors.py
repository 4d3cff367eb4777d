"""Three-vectors as tuples, against NumPy."""

from __future__ import annotations

import numpy as np

from knitlab_core.rods.vectors import add, combine, cross, dot, norm, row, scale, sub

A, B = (1.0, -2.0, 3.0), (0.5, 4.0, -1.0)
a, b = np.array(A), np.array(B)


def test_vectors_are_numpys() -> None:
    np.testing.assert_array_equal(add(A, B), a + b)
    np.testing.assert_array_equal(sub(A, B), a - b)
    np.testing.assert_array_equal(scale(2.0, A), 2.0 * a)
    np.testing.assert_array_equal(combine(2.0, A, -3.0, B), 2.0 * a - 3.0 * b)
    np.testing.assert_array_equal(cross(A, B), np.cross(a, b))
    assert dot(A, B) == a @ b
    assert norm(A) == np.sqrt(14.0)


def test_row_takes_the_position_of_a_node() -> None:
    assert row(np.arange(8.0).reshape(2, 4), 1) == (4.0, 5.0, 6.0)


def test_a_vector_crossed_with_itself_vanishes_exactly() -> None:
    assert cross(A, A) == (0.0, 0.0, 0.0)

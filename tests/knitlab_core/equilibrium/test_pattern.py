import numpy as np
import pytest

from knitlab_core.equilibrium.pattern import fix_unknowns, make_pattern, multiply, update_pattern
from tests.knitlab_core.sparse.blocks import dense, random_blocks, random_pattern, touching


def test_blocks_lie_in_the_lower_triangle_sorted_and_once() -> None:
    pattern = random_pattern(40, 30, seed=1)
    assert (pattern.rows >= pattern.columns).all()
    assert (np.diff(pattern.columns * 40 + pattern.rows) > 0).all()


def test_places_of_a_rod_and_of_a_contact() -> None:
    pattern = make_pattern(12, touching((2, 8)))
    for places, distance in ((pattern.diagonal, 0), (pattern.below, 1), (pattern.below2, 2)):
        i = np.arange(distance, 12)
        np.testing.assert_array_equal(pattern.rows[places[i]], i)
        np.testing.assert_array_equal(pattern.columns[places[i]], i - distance)
    np.testing.assert_array_equal(pattern.rows[pattern.across[0]], np.repeat([7, 8, 9], 3))
    np.testing.assert_array_equal(pattern.columns[pattern.across[0]], np.tile([1, 2, 3], 3))


def test_a_rod_alone_is_a_band() -> None:
    pattern = make_pattern(12, touching())
    assert pattern.rows.size == 12 + 11 + 10
    assert pattern.across.shape == (0, 9)


def test_fewer_contacts_fit_and_keep_the_blocks() -> None:
    pattern = make_pattern(20, touching((2, 8), (5, 15)))
    kept = update_pattern(pattern, 20, touching((5, 15)))
    assert kept is not None
    assert kept.rows is pattern.rows
    np.testing.assert_array_equal(kept.across, pattern.across[1:])


@pytest.mark.parametrize("span", [(2, 9), (1, 18), (17, 18)])
def test_a_new_contact_does_not_fit(span: tuple[int, int]) -> None:
    assert update_pattern(make_pattern(20, touching((2, 8))), 20, touching(span)) is None


def test_multiplies_as_the_dense_matrix() -> None:
    pattern = random_pattern(30, 20, seed=4)
    blocks = random_blocks(pattern, seed=4)
    v, out = np.random.default_rng(2).normal(size=(30, 4)), np.full((30, 4), np.nan)
    multiply(pattern, blocks, v, out)
    np.testing.assert_allclose(out.ravel(), dense(pattern, blocks) @ v.ravel(), rtol=1e-12, atol=1e-12)


def test_fixed_unknowns_become_those_of_the_unit_matrix() -> None:
    pattern = random_pattern(30, 20, seed=5)
    blocks = random_blocks(pattern, seed=5)
    fixed = np.random.default_rng(3).random((30, 4)) < 0.3
    expected = dense(pattern, blocks)
    held = fixed.ravel()
    expected[held] = 0.0
    expected[:, held] = 0.0
    expected[held, held] = 1.0
    fix_unknowns(pattern, fixed, blocks)
    np.testing.assert_array_equal(dense(pattern, blocks), expected)

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from knitlab_core.equilibrium.pattern import multiply
from knitlab_core.sparse.cholesky import BlockCholesky
from tests.knitlab_core.sparse.blocks import dense, lattice, random_blocks, random_pattern


@pytest.mark.parametrize(("n", "contacts"), [(3, 0), (4, 1), (20, 0), (20, 15), (60, 80)])
@pytest.mark.parametrize("shift", [0.0, 3.0])
def test_solves_as_a_dense_solver(n: int, contacts: int, shift: float) -> None:
    pattern = random_pattern(n, contacts, seed=n)
    blocks = random_blocks(pattern, seed=n + 1, diagonal=150.0)
    linear = BlockCholesky(pattern)
    assert linear.factor(blocks, shift)
    b = np.random.default_rng(0).normal(size=(n, 4))
    expected = np.linalg.solve(dense(pattern, blocks) + shift * np.eye(4 * n), b.ravel())
    np.testing.assert_allclose(linear.solve(b).ravel(), expected, rtol=1e-11, atol=1e-14)


def test_solves_as_a_sparse_solver_when_nearly_singular() -> None:
    n = 120
    pattern = random_pattern(n, 60, seed=7)
    blocks = random_blocks(pattern, seed=8)
    full = dense(pattern, blocks)
    lowest = float(np.linalg.eigvalsh(full)[0])
    shift = 1e-6 - lowest
    linear = BlockCholesky(pattern)
    assert linear.factor(blocks, shift)
    b = np.random.default_rng(1).normal(size=(n, 4))
    expected = spsolve(sparse.csc_matrix(full + shift * np.eye(4 * n)), b.ravel())
    # The condition number is about 1e8: half the digits are left.
    np.testing.assert_allclose(linear.solve(b).ravel(), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("margin", [1e-6, -1e-6])
def test_is_factored_exactly_where_positive_definite(seed: int, margin: float) -> None:
    pattern = random_pattern(30, 20, seed)
    blocks = random_blocks(pattern, seed)
    lowest = float(np.linalg.eigvalsh(dense(pattern, blocks))[0])
    assert BlockCholesky(pattern).factor(blocks, margin - lowest) is (margin > 0.0)


def test_a_matrix_with_nan_is_not_positive_definite() -> None:
    pattern = random_pattern(10, 3, seed=0)
    blocks = random_blocks(pattern, seed=0, diagonal=150.0)
    blocks[pattern.diagonal[4], 2, 2] = np.nan
    assert not BlockCholesky(pattern).factor(blocks)


def test_factors_anew_after_a_failure() -> None:
    pattern = random_pattern(30, 20, seed=3)
    blocks = random_blocks(pattern, seed=3, diagonal=150.0)
    linear = BlockCholesky(pattern)
    assert not linear.factor(-blocks)
    assert linear.factor(blocks)
    b = np.ones((30, 4))
    np.testing.assert_allclose(dense(pattern, blocks) @ linear.solve(b).ravel(), b.ravel(), rtol=1e-11)


def test_leaves_what_it_is_given_untouched() -> None:
    pattern = random_pattern(10, 3, seed=0)
    blocks, b = random_blocks(pattern, seed=0, diagonal=150.0), np.ones((10, 4))
    before = blocks.copy()
    linear = BlockCholesky(pattern)
    linear.factor(blocks, 2.0)
    linear.solve(b)
    np.testing.assert_array_equal(blocks, before)
    np.testing.assert_array_equal(b, np.ones((10, 4)))


@pytest.mark.parametrize("size", [(9, 9, 1), (7, 6, 5), (14, 13, 12)])
def test_solves_a_strand_that_touches_itself_everywhere(size: tuple[int, int, int]) -> None:
    pattern, places = lattice(size)
    n = pattern.diagonal.size
    blocks = random_blocks(pattern, seed=5, diagonal=150.0)
    linear = BlockCholesky(pattern, places)
    assert linear.factor(blocks)
    b = np.random.default_rng(2).normal(size=(n, 4))
    x, product = linear.solve(b), np.empty((n, 4))
    multiply(pattern, blocks, x, product)
    np.testing.assert_allclose(product, b, rtol=0.0, atol=1e-12 * np.abs(b).max())


@pytest.mark.parametrize("node", [0, 1000, 2183])
@pytest.mark.parametrize("unknown", [0, 3])
def test_a_single_negative_direction_is_found_wherever_it_is(node: int, unknown: int) -> None:
    pattern, places = lattice((14, 13, 12))
    blocks = random_blocks(pattern, seed=5, diagonal=150.0)
    linear = BlockCholesky(pattern, places)
    assert linear.factor(blocks)
    own = pattern.diagonal[node]
    # A pivot is what the diagonal has beyond the rest's pull, so less than nothing is enough.
    blocks[own, unknown, unknown] = -1e-9
    assert not linear.factor(blocks)


def test_gives_the_same_bits_every_time() -> None:
    pattern, places = lattice((14, 13, 12))
    blocks = random_blocks(pattern, seed=5, diagonal=150.0)
    b = np.random.default_rng(2).normal(size=(pattern.diagonal.size, 4))
    first, second = BlockCholesky(pattern, places), BlockCholesky(pattern, places)
    assert not second.factor(-blocks)
    assert first.factor(blocks)
    assert second.factor(blocks)
    np.testing.assert_array_equal(first.solve(b), second.solve(b))


def test_takes_no_more_room_than_the_panels() -> None:
    n = 40
    # A rod has a diagonal block and two below it in each column but the last two; pairs of columns store one zero.
    assert 3 * n - 3 <= BlockCholesky(random_pattern(n, 0, seed=0)).factor_blocks <= 4 * n

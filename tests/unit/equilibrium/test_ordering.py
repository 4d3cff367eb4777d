import numpy as np
import pytest

from knitlab_core.equilibrium.ordering import Factorisation, analyse, minimum_degree
from knitlab_core.equilibrium.pattern import make_pattern
from knitlab_core.rods.blocks import Pattern
from tests.unit.equilibrium.blocks import dense, random_blocks, random_pattern, touching


def structure(plan: Factorisation) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    n = plan.place.size
    has_block = np.eye(n, dtype=np.bool_)
    has_block[plan.row, np.repeat(np.arange(n), np.diff(plan.start))] = True
    return has_block


@pytest.mark.parametrize(("n", "contacts"), [(4, 0), (30, 0), (30, 12), (60, 40)])
def test_the_factor_has_a_block_where_a_dense_factor_is_not_zero(n: int, contacts: int) -> None:
    pattern = random_pattern(n, contacts, seed=n + contacts)
    plan = analyse(pattern)
    order = np.argsort(plan.place)
    # Node by node, the norm of a random heavy stiffness has the pattern's zeros.
    full = dense(pattern, random_blocks(pattern, seed=1, diagonal=200.0)).reshape(n, 4, n, 4)
    permuted = full[order][:, :, order].reshape(4 * n, 4 * n)
    factor = np.abs(np.linalg.cholesky(permuted)).reshape(n, 4, n, 4).sum(axis=(1, 3))
    np.testing.assert_array_equal(factor > 1e-30, structure(plan))


def test_rows_of_a_column_ascend() -> None:
    plan = analyse(random_pattern(60, 40, seed=5))
    for k in range(plan.place.size):
        rows = plan.row[plan.start[k] : plan.start[k + 1]]
        assert (np.diff(rows) > 0).all()
        assert (rows > k).all()


@pytest.mark.parametrize("seed", range(3))
def test_the_order_is_a_permutation(seed: int) -> None:
    np.testing.assert_array_equal(np.sort(minimum_degree(random_pattern(50, 30, seed))), np.arange(50))


def test_every_block_of_the_stiffness_is_used_once() -> None:
    pattern = random_pattern(50, 30, seed=2)
    plan = analyse(pattern)
    np.testing.assert_array_equal(np.sort(plan.source), np.arange(pattern.rows.size))


def natural_fill(pattern: Pattern) -> int:
    n = pattern.diagonal.size
    ones = dense(pattern, np.ones((pattern.rows.size, 4, 4)))[::4, ::4] + 2.0 * n * np.eye(n)
    return int((np.abs(np.linalg.cholesky(ones)) > 1e-30).sum())


def test_the_order_saves_fill_where_far_strands_touch() -> None:
    # Strands that run back beside themselves: the natural order fills the band between them.
    pattern = make_pattern(80, touching(*((i, 79 - i) for i in range(1, 35))))
    plan = analyse(pattern)
    assert plan.row.size + 80 < 0.5 * natural_fill(pattern)

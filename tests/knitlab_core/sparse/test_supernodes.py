import numpy as np
import pytest

from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.ordering import choose_order, node_graph
from knitlab_core.sparse.supernodes import Factorisation, analyse
from tests.knitlab_core.sparse.blocks import dense, lattice, random_blocks, random_pattern

BoolMatrix = np.ndarray[tuple[int, int], np.dtype[np.bool_]]


def stored(plan: Factorisation) -> BoolMatrix:
    """Return which blocks of the lower triangle the panels have room for."""
    n = plan.place.size
    room = np.zeros((n, n), dtype=np.bool_)
    for s in range(plan.first.size - 1):
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        for k in range(plan.first[s], plan.first[s + 1]):
            room[k : plan.first[s + 1], k] = True
            room[rows, k] = True
    return room


def filled(pattern: Pattern, plan: Factorisation) -> BoolMatrix:
    n = pattern.diagonal.size
    order = np.argsort(plan.place)
    full = dense(pattern, random_blocks(pattern, seed=1, diagonal=200.0)).reshape(n, 4, n, 4)
    permuted = full[order][:, :, order].reshape(4 * n, 4 * n)
    needed: BoolMatrix = np.abs(np.linalg.cholesky(permuted)).reshape(n, 4, n, 4).sum(axis=(1, 3)) > 1e-30
    return needed


PATTERNS = [random_pattern(4, 0, 0), random_pattern(30, 12, 1), random_pattern(60, 40, 2), lattice((6, 5, 4))[0]]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_panels_hold_every_block_of_the_factor_and_few_more(pattern: Pattern) -> None:
    plan = analyse(pattern)
    room, needed = stored(plan), filled(pattern, plan)
    assert not (needed & ~room).any()
    assert room.sum() <= 1.35 * needed.sum()


@pytest.mark.parametrize("pattern", PATTERNS)
def test_rows_ascend_below_their_columns(pattern: Pattern) -> None:
    plan = analyse(pattern)
    for s in range(plan.first.size - 1):
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        assert (np.diff(rows) > 0).all()
        assert (rows >= plan.first[s + 1]).all()


@pytest.mark.parametrize("pattern", PATTERNS)
def test_every_row_knows_whose_column_it_is(pattern: Pattern) -> None:
    plan = analyse(pattern)
    assert (plan.first[plan.owner] <= plan.row).all()
    assert (plan.row < plan.first[plan.owner + 1]).all()


@pytest.mark.parametrize("pattern", PATTERNS)
def test_every_block_of_the_stiffness_has_its_own_place_in_its_panel(pattern: Pattern) -> None:
    plan = analyse(pattern)
    np.testing.assert_array_equal(np.sort(plan.source), np.arange(pattern.rows.size))
    assert np.unique(plan.target).size == pattern.rows.size
    for s in range(plan.first.size - 1):
        here = plan.target[plan.source_start[s] : plan.source_start[s + 1]]
        assert ((plan.panel[s] <= here) & (here < plan.panel[s + 1])).all()


def test_a_dense_end_is_one_panel() -> None:
    pattern, _ = lattice((8, 8, 8))
    width = np.diff(analyse(pattern).first)
    below = choose_order(node_graph(pattern)).below
    dense_end = int((np.diff(below[::-1]) == 1).argmin()) + 1
    assert dense_end > 30
    assert width[-1] >= dense_end

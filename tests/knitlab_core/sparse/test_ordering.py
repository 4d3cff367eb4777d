import numpy as np
import pytest

from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.ordering import choose_order, eliminate, node_graph
from tests.knitlab_core.sparse.blocks import dense, lattice, random_blocks, random_pattern

BoolMatrix = np.ndarray[tuple[int, int], np.dtype[np.bool_]]

PATTERNS = [(4, 0), (30, 0), (30, 12), (60, 40)]


def dense_structure(pattern: Pattern, order: np.ndarray[tuple[int], np.dtype[np.int64]]) -> BoolMatrix:
    """Return where the dense factor of a random stiffness in some order has blocks that are not zero."""
    n = pattern.diagonal.size
    full = dense(pattern, random_blocks(pattern, seed=1, diagonal=200.0)).reshape(n, 4, n, 4)
    permuted = full[order][:, :, order].reshape(4 * n, 4 * n)
    filled: BoolMatrix = np.abs(np.linalg.cholesky(permuted)).reshape(n, 4, n, 4).sum(axis=(1, 3)) > 1e-30
    return filled


@pytest.mark.parametrize(("n", "contacts"), PATTERNS)
def test_columns_are_as_long_as_those_of_a_dense_factor(n: int, contacts: int) -> None:
    pattern = random_pattern(n, contacts, seed=n + contacts)
    tree = choose_order(node_graph(pattern))
    filled = dense_structure(pattern, tree.order)
    np.testing.assert_array_equal(tree.below, filled.sum(axis=0) - 1)


@pytest.mark.parametrize(("n", "contacts"), PATTERNS)
def test_the_parent_of_a_column_is_its_first_row_below(n: int, contacts: int) -> None:
    pattern = random_pattern(n, contacts, seed=n + contacts)
    tree = choose_order(node_graph(pattern))
    below = np.tril(dense_structure(pattern, tree.order), -1)
    expected = np.where(below.any(axis=0), below.argmax(axis=0), -1)
    np.testing.assert_array_equal(tree.parent, expected)


@pytest.mark.parametrize("seed", range(3))
def test_every_subtree_is_contiguous(seed: int) -> None:
    tree = choose_order(node_graph(random_pattern(90, 60, seed)))
    n = tree.order.size
    first = np.arange(n)
    size = np.ones(n, dtype=np.int64)
    for k in range(n):
        if tree.parent[k] >= 0:
            first[tree.parent[k]] = min(first[tree.parent[k]], first[k])
            size[tree.parent[k]] += size[k]
    np.testing.assert_array_equal(first, np.arange(n) - size + 1)


def test_place_undoes_order() -> None:
    tree = choose_order(node_graph(random_pattern(50, 30, seed=0)))
    np.testing.assert_array_equal(tree.order[tree.place], np.arange(50))


def test_the_graph_is_that_of_the_pattern() -> None:
    pattern = random_pattern(40, 25, seed=3)
    graph = node_graph(pattern)
    touching = np.zeros((40, 40), dtype=np.bool_)
    touching[np.repeat(np.arange(40), np.diff(graph.start)), graph.neighbour] = True
    expected = dense(pattern, np.ones((pattern.rows.size, 4, 4)))[::4, ::4] > 0.0
    np.fill_diagonal(expected, val=False)
    np.testing.assert_array_equal(touching, expected)


def test_operations_count_a_dense_matrix_as_it_is() -> None:
    graph = node_graph(lattice((3, 3, 1))[0])
    n = 9
    full = eliminate(graph, np.arange(n))._replace(below=np.arange(n - 1, -1, -1))
    # A multiplication and an addition for half the cube of its size, up to terms of lower order.
    assert full.operations == pytest.approx((4 * n) ** 3 / 3.0, rel=0.02)

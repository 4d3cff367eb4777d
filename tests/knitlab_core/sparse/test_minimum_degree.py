import numpy as np
import pytest

from knitlab_core.sparse.minimum_degree import minimum_degree
from knitlab_core.sparse.ordering import eliminate, node_graph
from knitlab_core.sparse.quotient import Graph
from tests.knitlab_core.sparse.blocks import lattice, random_pattern


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("contacts", [0, 30, 400])
def test_the_order_is_a_permutation(seed: int, contacts: int) -> None:
    order = minimum_degree(node_graph(random_pattern(80, contacts, seed)))
    np.testing.assert_array_equal(np.sort(order), np.arange(80))


def test_parts_come_one_after_the_other() -> None:
    part = np.random.default_rng(0).integers(0, 5, 80)
    order = minimum_degree(node_graph(random_pattern(80, 60, seed=1)), part)
    np.testing.assert_array_equal(np.sort(order), np.arange(80))
    assert (np.diff(part[order]) >= 0).all()


def test_a_chain_is_eliminated_without_fill() -> None:
    graph = node_graph(random_pattern(40, 0, seed=0))
    # Half bandwidth two: two blocks below the diagonal, but for the last two columns.
    assert eliminate(graph, minimum_degree(graph)).below.sum() == 2 * 40 - 3


def test_a_node_that_all_touch_comes_last() -> None:
    leaves = 9
    start = np.concatenate([[0, leaves], leaves + np.arange(1, leaves + 1)])
    star = Graph(start, np.concatenate([np.arange(1, leaves + 1), np.zeros(leaves, dtype=np.int64)]))
    assert 0 in minimum_degree(star)[-2:]
    assert eliminate(star, minimum_degree(star)).below.sum() == leaves


def test_far_less_fill_than_in_the_order_of_a_strand_that_touches_itself() -> None:
    graph = node_graph(lattice((12, 12, 3))[0])
    natural = eliminate(graph, np.arange(graph.start.size - 1))
    assert eliminate(graph, minimum_degree(graph)).operations < 0.5 * natural.operations


def test_no_worse_than_the_exact_degree_by_much() -> None:
    graph = node_graph(lattice((9, 8, 2))[0])
    n = graph.start.size - 1
    near = [set(graph.neighbour[graph.start[i] : graph.start[i + 1]].tolist()) for i in range(n)]
    operations, left = 0.0, set(range(n))
    while left:
        p = min(left, key=lambda i: len(near[i]))
        left.remove(p)
        operations += 64.0 * len(near[p]) * (len(near[p]) + 1)
        for i in near[p]:
            near[i] = (near[i] | near[p]) - {i, p}
    assert eliminate(graph, minimum_degree(graph)).operations < 1.5 * operations

import numpy as np
import pytest

from knitlab_core.sparse import dissection
from knitlab_core.sparse.dissection import dissect
from knitlab_core.sparse.minimum_degree import minimum_degree
from knitlab_core.sparse.ordering import choose_order, eliminate, node_graph
from knitlab_core.sparse.quotient import Graph
from tests.knitlab_core.sparse.blocks import lattice


def parts(graph: Graph, part: np.ndarray[tuple[int], np.dtype[np.int64]]) -> dict[int, set[int]]:
    """Return for each part the others that its nodes touch."""
    ends = np.repeat(part, np.diff(graph.start)), part[graph.neighbour]
    return {int(p): set(ends[1][ends[0] == p].tolist()) - {int(p)} for p in np.unique(part)}


def test_the_halves_touch_only_through_their_separator() -> None:
    pattern, places = lattice((12, 11, 10))  # halves fit into leaves
    graph = node_graph(pattern)
    touched = parts(graph, dissect(graph, places))
    first, second, separator = sorted(touched)
    assert touched[first] == touched[second] == {separator}


def test_leaves_touch_separators_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dissection, "LEAF", 60)
    pattern, places = lattice((10, 10, 10))
    graph = node_graph(pattern)
    part = dissect(graph, places)
    sizes = dict(zip(*np.unique(part, return_counts=True), strict=True))
    touched = parts(graph, part)
    assert len(sizes) > 20
    leaves = [p for p in touched if all(o > p for o in touched[p])]
    assert all(not touched[p] & set(leaves) for p in leaves)
    assert max(sizes[p] for p in leaves) <= 60


def test_a_small_graph_is_one_part() -> None:
    pattern, places = lattice((5, 5, 5))
    assert np.unique(dissect(node_graph(pattern), places)).size == 1


def test_a_block_of_strands_is_eliminated_with_less_work_than_by_degree() -> None:
    pattern, places = lattice((100, 12, 3))
    graph = node_graph(pattern)
    by_degree = eliminate(graph, minimum_degree(graph)).operations
    assert by_degree > 1e9
    assert eliminate(graph, minimum_degree(graph, dissect(graph, places))).operations < 0.5 * by_degree
    assert choose_order(graph, places).operations < 0.5 * by_degree
    assert choose_order(graph).operations == pytest.approx(by_degree)

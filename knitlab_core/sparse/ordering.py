"""Elimination order of the nodes, and the tree in which columns of the factor need each other."""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.dissection import dissect
from knitlab_core.sparse.minimum_degree import minimum_degree
from knitlab_core.sparse.quotient import Graph

DISSECT_ABOVE = 2e8
"""Operations of a factorisation from which a dissection is tried: below, trying takes longer than it may save."""


class Elimination(NamedTuple):
    """What each step of an elimination depends on.

    `order`: (N,) node eliminated at each step; `place`: (N,) step of each node;
    `parent`: (N,) next step that a step acts on, -1 for none; `below`: (N,)
    blocks of each column of the factor below its diagonal.
    """

    order: IndexArray
    place: IndexArray
    parent: IndexArray
    below: IndexArray

    @property
    def operations(self) -> float:
        """Additions and multiplications of a factorisation in 4 x 4 blocks."""
        rows = self.below.astype(np.float64)
        return float(64.0 * np.sum(rows * (rows + 1.0)))


def node_graph(pattern: Pattern) -> Graph:
    """Return which nodes act on each other, 4 unknowns to 1."""
    n = pattern.diagonal.size
    off = pattern.rows != pattern.columns
    i, j = pattern.rows[off], pattern.columns[off]
    # Row by row, each in the order of its columns.
    both = np.sort(np.concatenate([i * n + j, j * n + i]))
    return Graph(np.searchsorted(both, n * np.arange(n + 1)), both % n)


@kernel
def _count(graph: Graph, order: IndexArray, place: IndexArray, parent: IndexArray, below: IndexArray) -> None:
    """Fill the elimination tree and the size of each column, row by row of the factor (Liu 1990)."""
    n = order.size
    mark = np.full(n, -1)
    for k in range(n):
        mark[k] = k
        for p in range(graph.start[order[k]], graph.start[order[k] + 1]):
            j = place[graph.neighbour[p]]
            while j < k and mark[j] != k:
                if parent[j] == -1:
                    parent[j] = k
                below[j] += 1
                mark[j] = k
                j = parent[j]


def eliminate(graph: Graph, order: IndexArray) -> Elimination:
    """Find tree and columns of an elimination in the given order."""
    n = order.size
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    parent, below = np.full(n, -1), np.zeros(n, dtype=np.int64)
    _count(graph, order, place, parent, below)
    return Elimination(order, place, parent, below)


@kernel
def _postorder(parent: IndexArray, order: IndexArray) -> None:
    """Fill the order of a tree in which every subtree is contiguous and its root last."""
    n = parent.size
    child, sibling = np.full(n, -1), np.full(n, -1)
    for k in range(n - 1, -1, -1):
        if parent[k] >= 0:
            sibling[k] = child[parent[k]]
            child[parent[k]] = k
    done = 0
    for root in range(n):
        if parent[root] >= 0:
            continue
        k = root
        while k >= 0:
            while child[k] >= 0:
                k = child[k]
            order[done] = k
            done += 1
            # A node follows the last of its children.
            while k != root and sibling[k] < 0:
                k = parent[k]
                order[done] = k
                done += 1
            k = -1 if k == root else sibling[k]


def choose_order(graph: Graph, positions: FloatArray | None = None) -> Elimination:
    """Find an order with little fill: minimum degree, or nested dissection where that needs less work.

    Parameters
    ----------
    graph : Graph
        Which nodes act on each other.
    positions : (N, 3) array, optional
        Where the nodes are; without them there is no dissection.
    """
    best = eliminate(graph, minimum_degree(graph))
    if positions is not None and best.operations > DISSECT_ABOVE:
        other = eliminate(graph, minimum_degree(graph, dissect(graph, positions)))
        if other.operations < best.operations:
            best = other
    post = np.empty_like(best.order)
    _postorder(best.parent, post)
    return eliminate(graph, best.order[post])

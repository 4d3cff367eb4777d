"""Nested dissection of a graph whose nodes have places in space.

George, *Nested dissection of a regular finite element mesh*, SIAM J. Numer.
Anal. 10 (1973), 345-363: a few nodes that part the rest in two are eliminated
last, and each half is parted in the same way. Here a plane across an axis parts
the nodes, and those on one side that touch the other are the separator.
"""

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.quotient import Graph

LEAF = 1000
"""Nodes up to which a set is not parted: minimum degree does as well."""

BALANCE = 0.25
"""Least share of the nodes on either side of a plane."""

IMBALANCE_COST = 4.0
"""By how much a separator counts more per squared distance of its plane from the middle."""


@kernel
def _reach(graph: Graph, line: IndexArray, rank: IndexArray, nearest: IndexArray, farthest: IndexArray) -> None:
    """Fill the lowest and highest rank (M,) among each node of a line and its neighbours in it."""
    for s in range(line.size):
        nearest[s], farthest[s] = s, s
        for p in range(graph.start[line[s]], graph.start[line[s] + 1]):
            t = rank[graph.neighbour[p]]
            if t >= 0:
                nearest[s] = min(nearest[s], t)
                farthest[s] = max(farthest[s], t)


def _best_plane(nearest: IndexArray, farthest: IndexArray) -> tuple[float, int, bool]:
    """Return the cost of the best cut of a line, the nodes before it, and whether those lose the separator."""
    m = nearest.size
    s = np.arange(m)
    # A node is in the separator before (after) a cut for every cut that parts it from a later (earlier) node.
    before = np.cumsum(np.bincount(s + 1, minlength=m + 2) - np.bincount(farthest + 1, minlength=m + 2))
    after = np.cumsum(np.bincount(nearest + 1, minlength=m + 2) - np.bincount(s + 1, minlength=m + 2))
    least = max(1, int(BALANCE * m))
    cuts = np.arange(least, m - least + 1)
    size = np.minimum(before, after)[cuts]
    cost = size * (1.0 + IMBALANCE_COST * (cuts / m - 0.5) ** 2)
    best = int(np.argmin(cost))
    cut = int(cuts[best])
    return float(cost[best]), cut, bool(before[cut] <= after[cut])


def _part_in_two(
    graph: Graph, positions: FloatArray, nodes: IndexArray, rank: IndexArray
) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return the nodes before a plane, those after it and their separator."""
    m = nodes.size
    best: tuple[float, IndexArray, IndexArray, IndexArray] | None = None
    nearest, farthest = np.empty(m, np.int64), np.empty(m, np.int64)
    for axis in range(positions.shape[1]):
        line = nodes[np.argsort(positions[nodes, axis], kind="stable")]
        rank[line] = np.arange(m)
        _reach(graph, line, rank, nearest, farthest)
        cost, cut, first = _best_plane(nearest, farthest)
        if best is None or cost < best[0]:
            parted = farthest[:cut] >= cut if first else nearest[cut:] < cut
            side = line[:cut] if first else line[cut:]
            rest = side[~parted]
            best = cost, rest if first else line[:cut], line[cut:] if first else rest, side[parted]
    rank[nodes] = -1
    if best is None:
        msg = "nodes need positions"
        raise ValueError(msg)
    return best[1:]


def dissect(graph: Graph, positions: FloatArray) -> IndexArray:
    """Return the part (N,) of each node; parts in ascending order leave little fill.

    Parameters
    ----------
    graph : Graph
        Which nodes touch.
    positions : (N, 3) array
        Where they are, in any unit.
    """
    n = graph.start.size - 1
    part = np.zeros(n, dtype=np.int64)
    rank = np.full(n, -1)
    waiting = [np.arange(n)]
    # From the last part to the first: a separator before both of its halves.
    number = n
    while waiting:
        nodes = waiting.pop()
        number -= 1
        if nodes.size <= LEAF:
            part[nodes] = number
            continue
        before, after, separator = _part_in_two(graph, positions, nodes, rank)
        part[separator] = number
        waiting += [before, after]
    return part

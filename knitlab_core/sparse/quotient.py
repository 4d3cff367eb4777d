"""A graph, and what is left of it while its nodes are eliminated: the quotient graph.

George & Liu, *A fast implementation of the minimum degree algorithm using quotient graphs*, ACM Trans. Math. Softw. 6
(1980), 337-358. A node that is gone stays as an element: all it touched touch each other.
"""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import IndexArray
from knitlab_core.jit import inline_kernel

VARIABLE, ELEMENT, GONE = 0, 1, 2


class Graph(NamedTuple):
    """Neighbours of each node, without itself: `neighbour[start[i] : start[i + 1]]`."""

    start: IndexArray
    neighbour: IndexArray


class Quotient(NamedTuple):
    """The graph as it is eliminated; all (N,).

    A variable's list holds `elements[i]` elements, then variables; an element's
    holds variables. `weight`: nodes that a variable stands for, negative while it
    is in the new element; `next_alike`, `last_alike`: chain of those nodes.
    `head`, `after`, `before`: variables by degree; `bucket`, `same`, `key`: by hash.
    """

    first: IndexArray
    length: IndexArray
    elements: IndexArray
    kind: IndexArray
    weight: IndexArray
    degree: IndexArray
    mark: IndexArray
    next_alike: IndexArray
    last_alike: IndexArray
    head: IndexArray
    after: IndexArray
    before: IndexArray
    bucket: IndexArray
    same: IndexArray
    key: IndexArray


def quotient(graph: Graph) -> Quotient:
    """Return the graph before anything is eliminated."""
    n = graph.start.size - 1
    none = np.full(n, -1)
    length = np.diff(graph.start)
    return Quotient(
        first=graph.start[:-1].copy(),
        length=length,
        elements=np.zeros(n, np.int64),
        kind=np.full(n, VARIABLE),
        weight=np.ones(n, np.int64),
        degree=length.copy(),
        mark=np.zeros(n, np.int64),
        next_alike=none.copy(),
        last_alike=np.arange(n),
        head=none.copy(),
        after=none.copy(),
        before=none.copy(),
        bucket=none.copy(),
        same=none.copy(),
        key=np.zeros(n, np.int64),
    )


@inline_kernel
def enlist(g: Quotient, i: int) -> None:
    """Put variable i first among those of its degree."""
    d = g.degree[i]
    g.before[i] = -1
    g.after[i] = g.head[d]
    if g.head[d] >= 0:
        g.before[g.head[d]] = i
    g.head[d] = i


@inline_kernel
def unlist(g: Quotient, i: int) -> None:
    """Take variable i from those of its degree."""
    if g.before[i] >= 0:
        g.after[g.before[i]] = g.after[i]
    else:
        g.head[g.degree[i]] = g.after[i]
    if g.after[i] >= 0:
        g.before[g.after[i]] = g.before[i]


@inline_kernel
def append(g: Quotient, v: int, order: IndexArray, done: int) -> int:
    """Append the nodes that v stands for to the order; return its length."""
    while v >= 0:
        order[done] = v
        done += 1
        v = g.next_alike[v]
    return done

"""Block structure of the factor: columns with the same rows form one dense panel."""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.ordering import Elimination, choose_order, node_graph
from knitlab_core.sparse.quotient import Graph

NARROW = 2
NARROW_ZEROS, WIDE_ZEROS = 0.25, 0.05
"""Largest share of zeros in a panel of up to `NARROW` nodes, and in a wider one, that is put together."""


class Factorisation(NamedTuple):
    """Panels of the factor L of the permuted stiffness, by S supernodes.

    `place`: (N,) place of a node in the elimination; `first`: (S + 1,) first
    place of each supernode; `row_start`: (S + 1,), `row`: (R,) places of the
    rows below its own columns, ascending; `owner`: (R,) supernodes they are
    columns of; `panel`: (S + 1,) where its panel of a strip per node begins in
    the factor, blocks of its own columns first. `source_start`: (S + 1,),
    `source`, `target`, `flipped`: the stiffness blocks that go into each panel,
    the block of the factor they go to, and whether transposed.
    """

    place: IndexArray
    first: IndexArray
    row_start: IndexArray
    row: IndexArray
    owner: IndexArray
    panel: IndexArray
    source_start: IndexArray
    source: IndexArray
    target: IndexArray
    flipped: BoolArray
    operations: float


@kernel
def _join(parent: IndexArray, below: IndexArray, first: IndexArray, zeros: FloatArray) -> int:
    """Fill the first column of each supernode; return their number.

    A column, then a supernode, joins the last child before it when the panel of both has few zeros.
    """
    n = parent.size
    top = 0
    for k in range(n):
        first[top], zeros[top] = k, 0.0
        top += 1
        while top > 1:
            begin, middle = first[top - 2], first[top - 1]
            up = parent[middle - 1]
            if up < middle or up > k:
                break
            left, width = middle - begin, k + 1 - begin
            # Rows of the child that the parent has and the child lacks.
            added = left * (k + 1 - middle + below[k] - below[middle - 1])
            none = zeros[top - 2] + zeros[top - 1] + added
            size = width * (0.5 * (width + 1) + below[k])
            share = NARROW_ZEROS if width <= NARROW else WIDE_ZEROS
            if none > share * size:
                break
            top -= 1
            zeros[top - 1] = none
    first[top] = n
    return top


@kernel
def _fill_rows(
    graph: Graph, tree: Elimination, first: IndexArray, super_of: IndexArray, row_start: IndexArray, row: IndexArray
) -> None:
    """Fill the rows of every supernode, ascending."""
    supers = first.size - 1
    mark = np.full(supers, -1)
    used = row_start.copy()
    for k in range(tree.order.size):
        mark[super_of[k]] = k
        for p in range(graph.start[tree.order[k]], graph.start[tree.order[k] + 1]):
            j = tree.place[graph.neighbour[p]]
            if j > k:
                continue
            s = super_of[j]
            while mark[s] != k:
                mark[s] = k
                row[used[s]] = k
                used[s] += 1
                s = super_of[tree.parent[first[s + 1] - 1]]


@kernel
def _fill_targets(
    first: IndexArray,
    row_start: IndexArray,
    row: IndexArray,
    panel: IndexArray,
    source_start: IndexArray,
    low: IndexArray,
    high: IndexArray,
    target: IndexArray,
) -> None:
    """Fill the block of the factor that the stiffness block of column `low` and row `high` goes to."""
    at = np.empty(first[-1], np.int64)
    for s in range(first.size - 1):
        width = first[s + 1] - first[s]
        height = width + row_start[s + 1] - row_start[s]
        for k in range(first[s], first[s + 1]):
            at[k] = k - first[s]
        for p in range(row_start[s], row_start[s + 1]):
            at[row[p]] = width + p - row_start[s]
        for p in range(source_start[s], source_start[s + 1]):
            target[p] = panel[s] + (low[p] - first[s]) * height + at[high[p]]


def analyse(pattern: Pattern, positions: FloatArray | None = None) -> Factorisation:
    """Find the elimination order and the panels of the factor.

    Parameters
    ----------
    pattern : Pattern
        Blocks of the stiffness.
    positions : (N, 3) array, optional
        Where the nodes are, for a nested dissection where that saves work.
    """
    graph = node_graph(pattern)
    tree = choose_order(graph, positions)
    n = tree.order.size
    first = np.empty(n + 1, np.int64)
    supers = _join(tree.parent, tree.below, first, np.empty(n))
    first = first[: supers + 1].copy()
    width, below = np.diff(first), tree.below[first[1:] - 1]
    super_of = np.repeat(np.arange(supers), width)
    row_start = np.concatenate([[0], np.cumsum(below)])
    panel = np.concatenate([[0], np.cumsum(width * (width + below))])
    row = np.empty(row_start[-1], np.int64)
    _fill_rows(graph, tree, first, super_of, row_start, row)
    i, j = tree.place[pattern.rows], tree.place[pattern.columns]
    low, high = np.minimum(i, j), np.maximum(i, j)
    source = np.argsort(super_of[low], kind="stable")
    source_start = np.searchsorted(super_of[low][source], np.arange(supers + 1))
    target = np.empty(source.size, np.int64)
    _fill_targets(first, row_start, row, panel, source_start, low[source], high[source], target)
    return Factorisation(
        place=tree.place,
        first=first,
        row_start=row_start,
        row=row,
        owner=super_of[row],
        panel=panel,
        source_start=source_start,
        source=source,
        target=target,
        flipped=(i < j)[source],
        operations=tree.operations,
    )

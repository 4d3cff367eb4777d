"""Elimination order of the nodes and the blocks of the factor it leads to."""

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from knitlab_core.arrays import BoolArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.rods.blocks import Pattern


class Factorisation(NamedTuple):
    """Block structure of the factor L of the permuted stiffness.

    `place`: (N,) position of a node in the elimination order; `start`: (N + 1,)
    first block of each column of L below its diagonal; `row`: (Z,) row of each
    block; `source_start`: (N + 1,), `source`, `source_row`, `flipped`: the
    stiffness blocks of each column, their rows, and whether they are transposed.
    """

    place: IndexArray
    start: IndexArray
    row: IndexArray
    source_start: IndexArray
    source: IndexArray
    source_row: IndexArray
    flipped: BoolArray


def minimum_degree(pattern: Pattern) -> IndexArray:
    """Order the node graph (4 unknowns to 1) by multiple minimum degree.

    SuperLU computes the order on its way; the numbers it factors are a
    stand-in that is diagonally dominant, so that it never has to pivot.
    """
    n = pattern.diagonal.size
    off = pattern.rows != pattern.columns
    i, j = pattern.rows[off], pattern.columns[off]
    ones = np.ones(i.size)
    graph = sparse.coo_matrix((ones, (i, j)), shape=(n, n))
    graph = (graph + graph.T + sparse.diags(np.full(n, 2.0 * n))).tocsc()
    factor = splu(
        graph,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factor.perm_c, dtype=np.int64)


@kernel
def _fill(
    n: int, first: IndexArray, rows: IndexArray, parent: IndexArray, start: IndexArray, row: IndexArray, write: bool
) -> int:
    """Count or write the row structure of every column of L (row subtrees); return its size.

    `first`, `rows`: columns of the permuted lower triangle by *row*: for row k,
    the columns j < k in which it has a block.
    """
    mark = np.full(n, -1)
    if not write:
        parent[:] = -1
        start[:] = 0
    used = start.copy()
    for k in range(n):
        mark[k] = k
        for p in range(first[k], first[k + 1]):
            j = rows[p]
            while mark[j] != k:
                if write:
                    row[used[j]] = k
                    used[j] += 1
                else:
                    if parent[j] == -1:
                        parent[j] = k
                    start[j + 1] += 1
                mark[j] = k
                j = parent[j]
    if not write:
        for k in range(n):
            start[k + 1] += start[k]
    return int(start[n])


def _grouped(keys: IndexArray, n: int) -> tuple[IndexArray, IndexArray]:
    """Return an order that sorts `keys` and where each of n groups starts in it."""
    order = np.argsort(keys, kind="stable")
    return order, np.searchsorted(keys[order], np.arange(n + 1))


def analyse(pattern: Pattern) -> Factorisation:
    """Find the elimination order and the blocks of the factor.

    Parameters
    ----------
    pattern : Pattern
        Blocks of the stiffness.
    """
    n = pattern.diagonal.size
    place = minimum_degree(pattern)
    i, j = place[pattern.rows], place[pattern.columns]
    low, high = np.minimum(i, j), np.maximum(i, j)
    by_column, source_start = _grouped(low, n)
    off = np.flatnonzero(low != high)
    by_row, first = _grouped(high[off], n)
    rows = low[off][by_row]
    parent, start = np.empty(n, np.int64), np.zeros(n + 1, np.int64)
    size = _fill(n, first, rows, parent, start, np.empty(0, np.int64), False)
    row = np.empty(size, np.int64)
    _fill(n, first, rows, parent, start, row, True)
    return Factorisation(
        place=place,
        start=start,
        row=row,
        source_start=source_start,
        source=by_column,
        source_row=high[by_column],
        flipped=(i < j)[by_column],
    )

"""Nodes that follow others: the images of a periodic cell, and what they do to forces and stiffness.

An image is a copy of a node, moved by whole multiples of the cell's vectors: x_i = x_m + sum_d k_d c_d, with the angle
of its edge that of the node m it copies. The cell's vectors c_d are the positions of nodes of their own, free or
prescribed like any other. So all unknowns q = T u follow from those u that are not images. Terms of the energy know
nothing of this: their gradient and stiffness are those of all nodes, and are brought back by T^T g and T^T K T.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.blocks import Pattern


class Ties(NamedTuple):
    """Which nodes are images.

    `images`: (G,) nodes that are images; `masters`: (G,) what each copies; `shifts`: (G, D) multiples of the cell's
    vectors; `cell`: (D,) nodes whose positions are these vectors; `kept`: (M,) nodes that are no images, in order.
    """

    images: IndexArray
    masters: IndexArray
    shifts: FloatArray
    cell: IndexArray
    kept: IndexArray

    @classmethod
    def of(cls, n: int, images: IndexArray, masters: IndexArray, shifts: IndexArray, cell: IndexArray) -> Self:
        """Tie images among n nodes."""
        kept = np.ones(n, dtype=np.bool_)
        kept[images] = False
        return cls(images, masters, np.ascontiguousarray(shifts, dtype=np.float64), cell, np.flatnonzero(kept))


@kernel
def spread(ties: Ties, v: FloatArray) -> None:
    """Set the images in a vector (N, 4) of unknowns or of a motion to what the others say: v = T u."""
    for g in range(ties.images.size):
        i, m = ties.images[g], ties.masters[g]
        for c in range(3):
            at = v[m, c]
            for d in range(ties.cell.size):
                at += ties.shifts[g, d] * v[ties.cell[d], c]
            v[i, c] = at
        v[i, 3] = v[m, 3]


@kernel
def gather(ties: Ties, gradient: FloatArray) -> None:
    """Bring the forces (N, 4) on images back to what they follow, and leave none on them: T^T g."""
    for g in range(ties.images.size):
        i, m = ties.images[g], ties.masters[g]
        for c in range(4):
            gradient[m, c] += gradient[i, c]
        for c in range(3):
            for d in range(ties.cell.size):
                gradient[ties.cell[d], c] += ties.shifts[g, d] * gradient[i, c]
        for c in range(4):
            gradient[i, c] = 0.0


class Folding(NamedTuple):
    """How T^T K T is summed from the blocks of K.

    `pattern`: that of T^T K T, of the nodes that are no images; its `below`, `below2` and `across` are not used.
    One term each: `source`, `goal`: (F,) blocks of K and of T^T K T; `weight`: (F,) factor; `turned`: (F,) whether
    the block is transposed; `both`: (F,) whether its transpose is added too; `no_row`, `no_column`: (F,) whether the
    angle's row and column of the source have no part in it, which is so in a cell's vectors.
    """

    pattern: Pattern
    source: IndexArray
    goal: IndexArray
    weight: FloatArray
    turned: BoolArray
    both: BoolArray
    no_row: BoolArray
    no_column: BoolArray


def make_folding(ties: Ties, pattern: Pattern) -> Folding:
    """Plan how the blocks of a pattern of all nodes are summed."""
    n, depth = pattern.diagonal.size, 1 + ties.cell.size
    number = np.full(n, -1)
    number[ties.kept] = np.arange(ties.kept.size)
    goals = np.full((n, depth), -1)
    weights = np.zeros((n, depth))
    goals[ties.kept, 0], weights[:, 0] = number[ties.kept], 1.0
    goals[ties.images, 0] = number[ties.masters]
    for d, node in enumerate(ties.cell):
        moved = ties.shifts[:, d] != 0.0
        goals[ties.images[moved], 1 + d] = number[node]
        weights[ties.images[moved], 1 + d] = ties.shifts[moved, d]
    every = np.arange(pattern.rows.size)
    terms = []
    for x in range(depth):
        for y in range(depth):
            p, q = goals[pattern.rows, x], goals[pattern.columns, y]
            own = pattern.rows == pattern.columns
            # Of a node's own block, which is symmetric, the lower half of all products is enough.
            used = (p >= 0) & (q >= 0) & (~own | (p >= q))
            b = every[used]
            p, q, own = p[used], q[used], own[used]
            terms.append(
                (
                    b,
                    np.minimum(p, q) * ties.kept.size + np.maximum(p, q),
                    weights[pattern.rows[b], x] * weights[pattern.columns[b], y],
                    p < q,
                    (p == q) & ~own,
                    np.full(b.size, x > 0),
                    np.full(b.size, y > 0),
                )
            )
    source, key, weight, turned, both, no_row, no_column = (np.concatenate(part) for part in zip(*terms, strict=True))
    keys, goal = np.unique(key, return_inverse=True)
    rows, columns = keys % ties.kept.size, keys // ties.kept.size
    none = np.full(ties.kept.size, -1)
    folded = Pattern(
        rows=rows,
        columns=columns,
        diagonal=np.flatnonzero(rows == columns),
        below=none,
        below2=none,
        across=np.empty((0, 9), np.int64),
    )
    order = np.argsort(goal, kind="stable")
    return Folding(
        folded,
        source[order],
        goal.ravel()[order],
        weight[order],
        turned[order],
        both[order],
        no_row[order],
        no_column[order],
    )


@kernel
def fold(folding: Folding, blocks: FloatArray, out: FloatArray) -> None:
    """Fill the blocks of T^T K T from those of K. Most images touch nothing, and their blocks are empty."""
    out[:] = 0.0
    filled = np.zeros(blocks.shape[0], dtype=np.bool_)
    for b in range(blocks.shape[0]):
        for r in range(4):
            for c in range(4):
                if blocks[b, r, c] != 0.0:
                    filled[b] = True
    for f in range(folding.source.size):
        b, g, w = folding.source[f], folding.goal[f], folding.weight[f]
        if not filled[b]:
            continue
        rows = 3 if folding.no_row[f] else 4
        columns = 3 if folding.no_column[f] else 4
        for r in range(rows):
            for c in range(columns):
                value = w * blocks[b, r, c]
                if folding.turned[f]:
                    out[g, c, r] += value
                else:
                    out[g, r, c] += value
                    if folding.both[f]:
                        out[g, c, r] += value

"""Supernodal Cholesky factorisation in 4 x 4 node blocks: the linear solver of the equilibrium.

Left-looking by panels, after Ng & Peyton, SIAM J. Sci. Comput. 14 (1993), 1034-1056. A stiffness that is not
positive definite is found at the first pivot that is not positive, and the work stops there.
"""

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.panels import factor_panel, solve_down, solve_up, subtract_product
from knitlab_core.sparse.subtrees import split
from knitlab_core.sparse.supernodes import Factorisation, analyse
from knitlab_core.threads import both


@inline_kernel
def _load(plan: Factorisation, s: int, blocks: FloatArray, shift: float, factor: FloatArray) -> None:
    """Fill panel s with its part of the stiffness."""
    factor[plan.panel[s] : plan.panel[s + 1]] = 0.0
    for p in range(plan.source_start[s], plan.source_start[s + 1]):
        block, goal = blocks[plan.source[p]], factor[plan.target[p]]
        if plan.flipped[p]:
            for r in range(4):
                for c in range(4):
                    goal[r, c] = block[c, r]
        else:
            for r in range(4):
                for c in range(4):
                    goal[r, c] = block[r, c]
    width = plan.first[s + 1] - plan.first[s]
    height = width + plan.row_start[s + 1] - plan.row_start[s]
    for k in range(width):
        own = factor[plan.panel[s] + k * (height + 1)]
        for r in range(4):
            own[r, r] += shift


@kernel
def _factor(
    plan: Factorisation,
    blocks: FloatArray,
    shift: float,
    members: IndexArray,
    head: IndexArray,
    link: IndexArray,
    next_row: IndexArray,
    factor: FloatArray,
) -> int:
    """Fill the panels of `members`, ascending supernodes; return the one with a pivot that is not positive, or -1.

    A panel waits in the list (`head`, `link`) of the supernode that holds the next row it has to act on, `next_row`.
    """
    # Rows of the panel at work: of each node, of the panel that acts on it, and one after the other.
    at, rows = np.empty(plan.place.size, np.int64), np.empty(plan.place.size, np.int64)
    ascending = np.arange(plan.place.size)
    for s in members:
        width = plan.first[s + 1] - plan.first[s]
        height = width + plan.row_start[s + 1] - plan.row_start[s]
        panel = factor[plan.panel[s] : plan.panel[s + 1]]
        _load(plan, s, blocks, shift, factor)
        for k in range(width):
            at[plan.first[s] + k] = k
        for p in range(plan.row_start[s], plan.row_start[s + 1]):
            at[plan.row[p]] = width + p - plan.row_start[s]
        next_row[s] = plan.row_start[s]
        d = head[s]
        while d >= 0:
            following = link[d]
            begin, end = next_row[d], plan.row_start[d + 1]
            m, n = end - begin, 0
            for i in range(m):
                rows[i] = at[plan.row[begin + i]]
                if rows[i] < width:
                    n = i + 1
            depth = plan.first[d + 1] - plan.first[d]
            d_height = depth + end - plan.row_start[d]
            source = plan.panel[d] + d_height - m
            subtract_product(panel, height, rows[:m], n, factor, source, d_height, depth)
            next_row[d] = begin + n
            if n < m:
                t = plan.owner[begin + n]
                link[d] = head[t]
                head[t] = d
            d = following
        if not factor_panel(panel, height, width, ascending[:height]):
            return int(s)
        if width < height:
            t = plan.owner[plan.row_start[s]]
            link[s] = head[t]
            head[t] = s
    return -1


@kernel
def _join_lists(members: IndexArray, head: IndexArray, other: IndexArray, link: IndexArray) -> None:
    """Put the panels that wait in the lists `other` of supernodes before those that wait in `head`."""
    for s in members:
        d = other[s]
        while d >= 0:
            following = link[d]
            link[d] = head[s]
            head[s] = d
            d = following


@kernel
def _solve_down(plan: Factorisation, factor: FloatArray, members: IndexArray, y: FloatArray) -> None:
    """Solve L y = x in place for the columns of `members`."""
    for s in members:
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        p, end = plan.panel[s], plan.first[s + 1]
        height = end - plan.first[s] + rows.size
        for k in range(plan.first[s], end):
            solve_down(factor[p : p + end - k + rows.size], rows, k, y)
            p += height + 1


@kernel
def _solve_up(plan: Factorisation, factor: FloatArray, members: IndexArray, y: FloatArray) -> None:
    """Solve L^T y = x in place for the columns of `members`, last first."""
    for q in range(members.size - 1, -1, -1):
        s = members[q]
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        end = plan.first[s + 1]
        height = end - plan.first[s] + rows.size
        for k in range(end - 1, plan.first[s] - 1, -1):
            p = plan.panel[s] + (k - plan.first[s]) * (height + 1)
            solve_up(factor[p : p + end - k + rows.size], rows, k, y)


@kernel
def _spread(place: IndexArray, b: FloatArray, y: FloatArray) -> None:
    """Fill y (N, 4), which is in the order of elimination, with b."""
    for i in range(place.size):
        for r in range(4):
            y[place[i], r] = b[i, r]


@kernel
def _collect(place: IndexArray, y: FloatArray, x: FloatArray) -> None:
    """Fill x (N, 4) with y, which is in the order of elimination."""
    for i in range(place.size):
        for r in range(4):
            x[i, r] = y[place[i], r]


@kernel
def _take(places: IndexArray, source: FloatArray, target: FloatArray, add: bool) -> None:
    """Copy rows of `source` to `target`, or add them."""
    for i in places:
        for r in range(4):
            target[i, r] = target[i, r] + source[i, r] if add else source[i, r]


class BlockCholesky:
    """Solve K x = b for symmetric positive definite K in 4 x 4 node blocks.

    The seam for any other solver is these three calls: analyse a pattern (the
    constructor), `factor` blocks, `solve` for a right-hand side.

    Parameters
    ----------
    pattern : Pattern
        Blocks of the stiffness.
    positions : (N, 3) array, optional
        Where the nodes are: large volumetric knits are dissected by them.
    """

    def __init__(self, pattern: Pattern, positions: FloatArray | None = None) -> None:
        self._plan: Factorisation = analyse(pattern, positions)
        self._split = split(self._plan, self._plan.operations)
        n, supers = pattern.diagonal.size, self._plan.first.size - 1
        self._factor = np.empty((self._plan.panel[-1], 4, 4))
        # Lists of panels that wait, of one half and the other; a panel is in one of them only.
        self._head, self._other = np.empty(supers, np.int64), np.empty(supers, np.int64)
        self._link, self._next = np.empty(supers, np.int64), np.empty(supers, np.int64)
        self._y = np.empty((n, 4))
        # What the second half takes from common rows is summed by itself.
        self._taken = np.zeros((n, 4))

    def factor(self, blocks: FloatArray, shift: float = 0.0) -> bool:
        """Factor K + shift I; return False where it is not positive definite.

        Parameters
        ----------
        blocks : (B, 4, 4) array
            Blocks of the lower triangle in the pattern's order.
        shift : float
            Added to the diagonal.
        """
        parts = self._split
        self._head[:] = -1
        if parts.is_whole:
            return self._eliminate(blocks, shift, parts.first, self._head) < 0
        self._other[:] = -1
        bad = both(
            lambda: self._eliminate(blocks, shift, parts.first, self._head),
            lambda: self._eliminate(blocks, shift, parts.second, self._other),
        )
        if max(bad) >= 0:
            return False
        _join_lists(parts.rest, self._head, self._other, self._link)
        return self._eliminate(blocks, shift, parts.rest, self._head) < 0

    def _eliminate(self, blocks: FloatArray, shift: float, members: IndexArray, head: IndexArray) -> int:
        """Fill the panels of some supernodes, as `_factor`."""
        return int(_factor(self._plan, blocks, shift, members, head, self._link, self._next, self._factor))

    def solve(self, b: FloatArray) -> FloatArray:
        """Return x (N, 4) with (K + shift I) x = b, for the last factored K."""
        plan, factor, parts, y = self._plan, self._factor, self._split, self._y
        x = np.empty_like(b)
        _spread(plan.place, b, y)
        if parts.is_whole:
            _solve_down(plan, factor, parts.first, y)
            _solve_up(plan, factor, parts.first, y)
        else:
            self._solve_halves(y)
        _collect(plan.place, y, x)
        return x

    def _solve_halves(self, y: FloatArray) -> None:
        """Solve in place, each half by itself."""
        plan, factor, parts, taken = self._plan, self._factor, self._split, self._taken
        _take(parts.own, y, taken, False)
        taken[parts.common] = 0.0
        both(
            lambda: _solve_down(plan, factor, parts.first, y),
            lambda: _solve_down(plan, factor, parts.second, taken),
        )
        _take(parts.common, taken, y, True)
        _solve_down(plan, factor, parts.rest, y)
        _solve_up(plan, factor, parts.rest, y)
        _take(parts.common, y, taken, False)
        both(
            lambda: _solve_up(plan, factor, parts.first, y),
            lambda: _solve_up(plan, factor, parts.second, taken),
        )
        _take(parts.own, taken, y, False)

    @property
    def factor_blocks(self) -> int:
        """Number of 4 x 4 blocks of the factor that are stored, diagonal included."""
        return int(self._plan.panel[-1])

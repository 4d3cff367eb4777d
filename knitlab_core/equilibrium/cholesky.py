"""Supernodal Cholesky factorisation in 4 x 4 node blocks: the linear solver of the equilibrium.

Left-looking by panels, after Ng & Peyton, SIAM J. Sci. Comput. 14 (1993), 1034-1056. A stiffness that is not
positive definite is found at the first pivot that is not positive, and the work stops there.
"""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.panels import factor_panel, solve_down, solve_up, subtract_product
from knitlab_core.equilibrium.supernodes import Factorisation, analyse
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.blocks import Pattern


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
def _factor(plan: Factorisation, blocks: FloatArray, shift: float, factor: FloatArray) -> int:
    """Fill the factor; return the supernode with a pivot that is not positive, or -1."""
    supers = plan.first.size - 1
    # A panel waits in the list of the supernode that holds the next row it has to act on.
    head, link = np.full(supers, -1), np.full(supers, -1)
    next_row = plan.row_start[:-1].copy()
    # Rows of the panel at work: of each node, of the panel that acts on it, and one after the other.
    at, rows = np.empty(plan.place.size, np.int64), np.empty(plan.place.size, np.int64)
    ascending = np.arange(plan.place.size)
    for s in range(supers):
        width = plan.first[s + 1] - plan.first[s]
        height = width + plan.row_start[s + 1] - plan.row_start[s]
        panel = factor[plan.panel[s] : plan.panel[s + 1]]
        _load(plan, s, blocks, shift, factor)
        for k in range(width):
            at[plan.first[s] + k] = k
        for p in range(plan.row_start[s], plan.row_start[s + 1]):
            at[plan.row[p]] = width + p - plan.row_start[s]
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
            return s
        if width < height:
            t = plan.owner[plan.row_start[s]]
            link[s] = head[t]
            head[t] = s
    return -1


@kernel
def _solve(plan: Factorisation, factor: FloatArray, b: FloatArray, y: FloatArray, x: FloatArray) -> None:
    """Fill x (N, 4) so that K x = b; `y` (N, 4) is for work."""
    supers = plan.first.size - 1
    for i in range(plan.place.size):
        for r in range(4):
            y[plan.place[i], r] = b[i, r]
    for s in range(supers):
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        p, end = plan.panel[s], plan.first[s + 1]
        height = end - plan.first[s] + rows.size
        for k in range(plan.first[s], end):
            solve_down(factor[p : p + end - k + rows.size], rows, k, y)
            p += height + 1
    for s in range(supers - 1, -1, -1):
        rows = plan.row[plan.row_start[s] : plan.row_start[s + 1]]
        end = plan.first[s + 1]
        height = end - plan.first[s] + rows.size
        for k in range(end - 1, plan.first[s] - 1, -1):
            p = plan.panel[s] + (k - plan.first[s]) * (height + 1)
            solve_up(factor[p : p + end - k + rows.size], rows, k, y)
    for i in range(plan.place.size):
        for r in range(4):
            x[i, r] = y[plan.place[i], r]


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
        n = pattern.diagonal.size
        self._factor = np.empty((self._plan.panel[-1], 4, 4))
        self._y = np.empty((n, 4))

    def factor(self, blocks: FloatArray, shift: float = 0.0) -> bool:
        """Factor K + shift I; return False where it is not positive definite.

        Parameters
        ----------
        blocks : (B, 4, 4) array
            Blocks of the lower triangle in the pattern's order.
        shift : float
            Added to the diagonal.
        """
        return bool(_factor(self._plan, blocks, shift, self._factor) < 0)

    def solve(self, b: FloatArray) -> FloatArray:
        """Return x (N, 4) with (K + shift I) x = b, for the last factored K."""
        x = np.empty_like(b)
        _solve(self._plan, self._factor, b, self._y, x)
        return x

    @property
    def factor_blocks(self) -> int:
        """Number of 4 x 4 blocks of the factor that are stored, diagonal included."""
        return int(self._plan.panel[-1])

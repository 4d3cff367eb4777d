"""Cholesky factorisation in 4 x 4 node blocks: the linear solver of the equilibrium.

Left-looking by block columns. A stiffness that is not positive definite is
found at the first pivot that is not positive, and the work stops there.
"""

from math import sqrt

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.ordering import Factorisation, analyse
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.blocks import Pattern

Block = tuple[
    float, float, float, float, float, float, float, float,
    float, float, float, float, float, float, float, float,
]  # fmt: skip


@inline_kernel
def _subtract_product(work: FloatArray, i: int, factor: FloatArray, b: int, m: Block) -> None:
    """Subtract block b of the factor times the 4 x 4 matrix `m` (16 floats) from work[i]."""
    for r in range(4):
        x, y, z, w = factor[b, r, 0], factor[b, r, 1], factor[b, r, 2], factor[b, r, 3]
        work[i, r, 0] -= x * m[0] + y * m[4] + z * m[8] + w * m[12]
        work[i, r, 1] -= x * m[1] + y * m[5] + z * m[9] + w * m[13]
        work[i, r, 2] -= x * m[2] + y * m[6] + z * m[10] + w * m[14]
        work[i, r, 3] -= x * m[3] + y * m[7] + z * m[11] + w * m[15]


@inline_kernel
def _transposed(a: FloatArray, b: int) -> Block:
    """Return block b of an array of blocks, transposed, as 16 floats."""
    return (
        a[b, 0, 0], a[b, 1, 0], a[b, 2, 0], a[b, 3, 0],
        a[b, 0, 1], a[b, 1, 1], a[b, 2, 1], a[b, 3, 1],
        a[b, 0, 2], a[b, 1, 2], a[b, 2, 2], a[b, 3, 2],
        a[b, 0, 3], a[b, 1, 3], a[b, 2, 3], a[b, 3, 3],
    )  # fmt: skip


@inline_kernel
def _factor_diagonal(work: FloatArray, k: int, diagonal: FloatArray) -> float:
    """Factor work[k] into the lower triangle of diagonal[k]; return the smallest pivot ratio."""
    worst = 1.0
    for r in range(4):
        for c in range(r + 1):
            s = work[k, r, c]
            for t in range(c):
                s -= diagonal[k, r, t] * diagonal[k, c, t]
            if r == c:
                if not s > 0.0:
                    return -1.0
                worst = min(worst, s)
                diagonal[k, r, r] = sqrt(s)
            else:
                diagonal[k, r, c] = s / diagonal[k, c, c]
    return worst


@kernel
def _factor(
    plan: Factorisation, blocks: FloatArray, shift: float, work: FloatArray, diagonal: FloatArray, factor: FloatArray
) -> int:
    """Fill the factor; return the column whose pivot is not positive, or -1."""
    n = plan.place.size
    # Column j waits in the list of the next row it has to update.
    head = np.full(n, -1)
    link = np.full(n, -1)
    at = plan.start[:-1].copy()
    for k in range(n):
        for r in range(4):
            for c in range(4):
                work[k, r, c] = 0.0
        for p in range(plan.start[k], plan.start[k + 1]):
            i = plan.row[p]
            for r in range(4):
                for c in range(4):
                    work[i, r, c] = 0.0
        for p in range(plan.source_start[k], plan.source_start[k + 1]):
            i, b = plan.source_row[p], plan.source[p]
            for r in range(4):
                for c in range(4):
                    if plan.flipped[p]:
                        work[i, r, c] += blocks[b, c, r]
                    else:
                        work[i, r, c] += blocks[b, r, c]
        for r in range(4):
            work[k, r, r] += shift
        j = head[k]
        while j >= 0:
            following = link[j]
            first, last = at[j], plan.start[j + 1]
            m = _transposed(factor, first)
            for p in range(first, last):
                i = k if p == first else plan.row[p]
                _subtract_product(work, i, factor, p, m)
            at[j] = first + 1
            if first + 1 < last:
                i = plan.row[first + 1]
                link[j] = head[i]
                head[i] = j
            j = following
        if _factor_diagonal(work, k, diagonal) <= 0.0:
            return k
        d = diagonal[k]
        i0, i1, i2, i3 = 1.0 / d[0, 0], 1.0 / d[1, 1], 1.0 / d[2, 2], 1.0 / d[3, 3]
        for p in range(plan.start[k], plan.start[k + 1]):
            i = plan.row[p]
            for r in range(4):
                x = work[i, r, 0] * i0
                y = (work[i, r, 1] - x * d[1, 0]) * i1
                z = (work[i, r, 2] - x * d[2, 0] - y * d[2, 1]) * i2
                w = (work[i, r, 3] - x * d[3, 0] - y * d[3, 1] - z * d[3, 2]) * i3
                factor[p, r, 0], factor[p, r, 1], factor[p, r, 2], factor[p, r, 3] = x, y, z, w
        if plan.start[k] < plan.start[k + 1]:
            i = plan.row[plan.start[k]]
            link[k] = head[i]
            head[i] = k
    return -1


@kernel
def _solve(
    plan: Factorisation, diagonal: FloatArray, factor: FloatArray, b: FloatArray, y: FloatArray, x: FloatArray
) -> None:
    """Fill x (N, 4) so that K x = b."""
    n = plan.place.size
    for i in range(n):
        for r in range(4):
            y[plan.place[i], r] = b[i, r]
    for k in range(n):
        d = diagonal[k]
        y0 = y[k, 0] / d[0, 0]
        y1 = (y[k, 1] - d[1, 0] * y0) / d[1, 1]
        y2 = (y[k, 2] - d[2, 0] * y0 - d[2, 1] * y1) / d[2, 2]
        y3 = (y[k, 3] - d[3, 0] * y0 - d[3, 1] * y1 - d[3, 2] * y2) / d[3, 3]
        y[k, 0], y[k, 1], y[k, 2], y[k, 3] = y0, y1, y2, y3
        for p in range(plan.start[k], plan.start[k + 1]):
            f, t = factor[p], y[plan.row[p]]
            t[0] -= f[0, 0] * y0 + f[0, 1] * y1 + f[0, 2] * y2 + f[0, 3] * y3
            t[1] -= f[1, 0] * y0 + f[1, 1] * y1 + f[1, 2] * y2 + f[1, 3] * y3
            t[2] -= f[2, 0] * y0 + f[2, 1] * y1 + f[2, 2] * y2 + f[2, 3] * y3
            t[3] -= f[3, 0] * y0 + f[3, 1] * y1 + f[3, 2] * y2 + f[3, 3] * y3
    for k in range(n - 1, -1, -1):
        y0, y1, y2, y3 = y[k, 0], y[k, 1], y[k, 2], y[k, 3]
        for p in range(plan.start[k], plan.start[k + 1]):
            f, t = factor[p], y[plan.row[p]]
            t0, t1, t2, t3 = t[0], t[1], t[2], t[3]
            y0 -= f[0, 0] * t0 + f[1, 0] * t1 + f[2, 0] * t2 + f[3, 0] * t3
            y1 -= f[0, 1] * t0 + f[1, 1] * t1 + f[2, 1] * t2 + f[3, 1] * t3
            y2 -= f[0, 2] * t0 + f[1, 2] * t1 + f[2, 2] * t2 + f[3, 2] * t3
            y3 -= f[0, 3] * t0 + f[1, 3] * t1 + f[2, 3] * t2 + f[3, 3] * t3
        d = diagonal[k]
        y3 = y3 / d[3, 3]
        y2 = (y2 - d[3, 2] * y3) / d[2, 2]
        y1 = (y1 - d[2, 1] * y2 - d[3, 1] * y3) / d[1, 1]
        y0 = (y0 - d[1, 0] * y1 - d[2, 0] * y2 - d[3, 0] * y3) / d[0, 0]
        y[k, 0], y[k, 1], y[k, 2], y[k, 3] = y0, y1, y2, y3
    for i in range(n):
        for r in range(4):
            x[i, r] = y[plan.place[i], r]


class BlockCholesky:
    """Solve K x = b for symmetric positive definite K in 4 x 4 node blocks.

    The seam for any other solver is these three calls: analyse a pattern (the
    constructor), `factor` blocks, `solve` for a right-hand side.
    """

    def __init__(self, pattern: Pattern) -> None:
        self._plan: Factorisation = analyse(pattern)
        n = pattern.diagonal.size
        self._work = np.empty((n, 4, 4))
        self._diagonal = np.empty((n, 4, 4))
        self._factor = np.empty((self._plan.row.size, 4, 4))
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
        return bool(_factor(self._plan, blocks, shift, self._work, self._diagonal, self._factor) < 0)

    def solve(self, b: FloatArray) -> FloatArray:
        """Return x (N, 4) with (K + shift I) x = b, for the last factored K."""
        x = np.empty_like(b)
        _solve(self._plan, self._diagonal, self._factor, b, self._y, x)
        return x

    @property
    def factor_blocks(self) -> int:
        """Number of 4 x 4 blocks of the factor, diagonal included."""
        return self._plan.row.size + self._plan.place.size

"""Dense algebra of the factor's panels.

A panel is a matrix of 4 x 4 blocks, a strip of blocks per block column; all strips of the factor are in one
array (Z, 4, 4). A row of a block is one vector of the processor: LLVM makes vector code of the straight lines
below. Slices, not offsets, tell it that no index is negative.
"""

from math import sqrt

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import inline_kernel, inner_kernel


@inline_kernel
def _subtract_one(c: FloatArray, rows: IndexArray, a: FloatArray) -> None:
    """Subtract from the blocks of c in `rows` (h,) strip a (h, 4, 4) times its first block transposed."""
    a00, a10, a20, a30 = a[0, 0, 0], a[0, 0, 1], a[0, 0, 2], a[0, 0, 3]
    a01, a11, a21, a31 = a[0, 1, 0], a[0, 1, 1], a[0, 1, 2], a[0, 1, 3]
    a02, a12, a22, a32 = a[0, 2, 0], a[0, 2, 1], a[0, 2, 2], a[0, 2, 3]
    a03, a13, a23, a33 = a[0, 3, 0], a[0, 3, 1], a[0, 3, 2], a[0, 3, 3]
    for i in range(rows.size):
        t = c[rows[i]]
        for r in range(4):
            x, y, z, w = a[i, r, 0], a[i, r, 1], a[i, r, 2], a[i, r, 3]
            t[r, 0] -= x * a00 + y * a10 + z * a20 + w * a30
            t[r, 1] -= x * a01 + y * a11 + z * a21 + w * a31
            t[r, 2] -= x * a02 + y * a12 + z * a22 + w * a32
            t[r, 3] -= x * a03 + y * a13 + z * a23 + w * a33


@inline_kernel
def _subtract_two(c: FloatArray, rows: IndexArray, a: FloatArray, b: FloatArray) -> None:
    """Do the same with strips a and b in one pass over c, in less time than two."""
    a00, a10, a20, a30 = a[0, 0, 0], a[0, 0, 1], a[0, 0, 2], a[0, 0, 3]
    a01, a11, a21, a31 = a[0, 1, 0], a[0, 1, 1], a[0, 1, 2], a[0, 1, 3]
    a02, a12, a22, a32 = a[0, 2, 0], a[0, 2, 1], a[0, 2, 2], a[0, 2, 3]
    a03, a13, a23, a33 = a[0, 3, 0], a[0, 3, 1], a[0, 3, 2], a[0, 3, 3]
    b00, b10, b20, b30 = b[0, 0, 0], b[0, 0, 1], b[0, 0, 2], b[0, 0, 3]
    b01, b11, b21, b31 = b[0, 1, 0], b[0, 1, 1], b[0, 1, 2], b[0, 1, 3]
    b02, b12, b22, b32 = b[0, 2, 0], b[0, 2, 1], b[0, 2, 2], b[0, 2, 3]
    b03, b13, b23, b33 = b[0, 3, 0], b[0, 3, 1], b[0, 3, 2], b[0, 3, 3]
    for i in range(rows.size):
        g = c[rows[i]]
        for r in range(4):
            x, y, z, w = a[i, r, 0], a[i, r, 1], a[i, r, 2], a[i, r, 3]
            s, t, u, v = b[i, r, 0], b[i, r, 1], b[i, r, 2], b[i, r, 3]
            g[r, 0] -= (x * a00 + y * a10 + z * a20 + w * a30) + (s * b00 + t * b10 + u * b20 + v * b30)
            g[r, 1] -= (x * a01 + y * a11 + z * a21 + w * a31) + (s * b01 + t * b11 + u * b21 + v * b31)
            g[r, 2] -= (x * a02 + y * a12 + z * a22 + w * a32) + (s * b02 + t * b12 + u * b22 + v * b32)
            g[r, 3] -= (x * a03 + y * a13 + z * a23 + w * a33) + (s * b03 + t * b13 + u * b23 + v * b33)


@inner_kernel
def subtract_product(
    panel: FloatArray, height: int, rows: IndexArray, n: int, a: FloatArray, at: int, a_height: int, depth: int
) -> None:
    """Subtract A B^T, B being the first n rows of A, from a panel at `rows` and at the first n of them as columns.

    The panel has strips of `height` blocks. A (rows.size, depth) begins at a[at], its next strip `a_height` further on.
    """
    for j in range(n):
        below = rows[j:]
        strip = panel[rows[j] * height : (rows[j] + 1) * height]
        h, p = below.size, at + j
        for _ in range(depth // 2):
            _subtract_two(strip, below, a[p : p + h], a[p + a_height : p + a_height + h])
            p += 2 * a_height
        if depth % 2 == 1:
            _subtract_one(strip, below, a[p : p + h])


@inline_kernel
def _factor_strip(c: FloatArray) -> bool:
    """Factor strip c (h, 4, 4) in place, its first block being the diagonal's; return False if it cannot be.

    Of the diagonal itself the reciprocals are kept.
    """
    s0 = c[0, 0, 0]
    i0 = 1.0 / sqrt(s0)
    d10, d20, d30 = c[0, 1, 0] * i0, c[0, 2, 0] * i0, c[0, 3, 0] * i0
    s1 = c[0, 1, 1] - d10 * d10
    i1 = 1.0 / sqrt(s1)
    d21, d31 = (c[0, 2, 1] - d20 * d10) * i1, (c[0, 3, 1] - d30 * d10) * i1
    s2 = c[0, 2, 2] - d20 * d20 - d21 * d21
    i2 = 1.0 / sqrt(s2)
    d32 = (c[0, 3, 2] - d30 * d20 - d31 * d21) * i2
    s3 = c[0, 3, 3] - d30 * d30 - d31 * d31 - d32 * d32
    if not (s0 > 0.0 and s1 > 0.0 and s2 > 0.0 and s3 > 0.0):
        return False
    i3 = 1.0 / sqrt(s3)
    c[0, 0, 0], c[0, 1, 0], c[0, 2, 0], c[0, 3, 0] = i0, d10, d20, d30
    c[0, 1, 1], c[0, 2, 1], c[0, 3, 1] = i1, d21, d31
    c[0, 2, 2], c[0, 3, 2], c[0, 3, 3] = i2, d32, i3
    for i in range(1, c.shape[0]):
        for r in range(4):
            x = c[i, r, 0] * i0
            y = (c[i, r, 1] - x * d10) * i1
            z = (c[i, r, 2] - x * d20 - y * d21) * i2
            w = (c[i, r, 3] - x * d30 - y * d31 - z * d32) * i3
            c[i, r, 0], c[i, r, 1], c[i, r, 2], c[i, r, 3] = x, y, z, w
    return True


@inner_kernel
def factor_panel(panel: FloatArray, height: int, width: int, rows: IndexArray) -> bool:
    """Factor a panel of `width` strips in place, left-looking; return whether it is positive definite.

    `rows` counts from 0 to `height` - 1.
    """
    for j in range(width):
        if j > 0:
            subtract_product(panel, height, rows[j:], 1, panel, j, height, j)
        if not _factor_strip(panel[j * (height + 1) : (j + 1) * height]):
            return False
    return True


@inline_kernel
def solve_down(c: FloatArray, rows: IndexArray, k: int, y: FloatArray) -> None:
    """Solve L y = x for the block column k in strip c, in place; take its part from the x in `rows` below."""
    t0, t1, t2, t3 = y[k, 0], y[k, 1], y[k, 2], y[k, 3]
    t0 = t0 * c[0, 0, 0]
    t1 = (t1 - c[0, 1, 0] * t0) * c[0, 1, 1]
    t2 = (t2 - c[0, 2, 0] * t0 - c[0, 2, 1] * t1) * c[0, 2, 2]
    t3 = (t3 - c[0, 3, 0] * t0 - c[0, 3, 1] * t1 - c[0, 3, 2] * t2) * c[0, 3, 3]
    y[k, 0], y[k, 1], y[k, 2], y[k, 3] = t0, t1, t2, t3
    own = c.shape[0] - rows.size
    for i in range(1, c.shape[0]):
        f, t = c[i], y[k + i if i < own else rows[i - own]]
        t[0] -= f[0, 0] * t0 + f[0, 1] * t1 + f[0, 2] * t2 + f[0, 3] * t3
        t[1] -= f[1, 0] * t0 + f[1, 1] * t1 + f[1, 2] * t2 + f[1, 3] * t3
        t[2] -= f[2, 0] * t0 + f[2, 1] * t1 + f[2, 2] * t2 + f[2, 3] * t3
        t[3] -= f[3, 0] * t0 + f[3, 1] * t1 + f[3, 2] * t2 + f[3, 3] * t3


@inline_kernel
def solve_up(c: FloatArray, rows: IndexArray, k: int, y: FloatArray) -> None:
    """Solve L^T y = x for the block column k in strip c, in place, y being known in `rows` below."""
    y0, y1, y2, y3 = y[k, 0], y[k, 1], y[k, 2], y[k, 3]
    own = c.shape[0] - rows.size
    for i in range(1, c.shape[0]):
        f, t = c[i], y[k + i if i < own else rows[i - own]]
        t0, t1, t2, t3 = t[0], t[1], t[2], t[3]
        y0 -= f[0, 0] * t0 + f[1, 0] * t1 + f[2, 0] * t2 + f[3, 0] * t3
        y1 -= f[0, 1] * t0 + f[1, 1] * t1 + f[2, 1] * t2 + f[3, 1] * t3
        y2 -= f[0, 2] * t0 + f[1, 2] * t1 + f[2, 2] * t2 + f[3, 2] * t3
        y3 -= f[0, 3] * t0 + f[1, 3] * t1 + f[2, 3] * t2 + f[3, 3] * t3
    y3 = y3 * c[0, 3, 3]
    y2 = (y2 - c[0, 3, 2] * y3) * c[0, 2, 2]
    y1 = (y1 - c[0, 2, 1] * y2 - c[0, 3, 1] * y3) * c[0, 1, 1]
    y0 = (y0 - c[0, 1, 0] * y1 - c[0, 2, 0] * y2 - c[0, 3, 0] * y3) * c[0, 0, 0]
    y[k, 0], y[k, 1], y[k, 2], y[k, 3] = y0, y1, y2, y3

"""Solve with the part of the stiffness that is not symmetric: friction that grows with load.

The symmetric part is factored; a few steps of GMRES, preconditioned by it, add
the rest. Without it Newton's iteration on friction only creeps.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.sums import inner_rows, length

MAX_KRYLOV = 30

BREAKDOWN = 1e-14
"""A new direction shorter than this, relative to the right-hand side, is rounding."""


@kernel
def _extend(basis: FloatArray, k: int, v: FloatArray, triangle: FloatArray, turns: FloatArray, size: float) -> float:
    """Add direction k + 1 to the basis, of v = (1 + C) basis[k]; return the residual left.

    `triangle` (., n) holds the small system in its first rows and the right-hand side in its last; `turns` (., 2)
    the Givens rotations that keep it triangular, so that its residual is known as it grows.
    """
    last = triangle.shape[0] - 1
    for c in range(v.size):
        v[c] += basis[k, c]
    for i in range(k + 1):
        triangle[i, k] = inner_rows(basis[i], v)
    for i in range(k + 1):
        h, b = triangle[i, k], basis[i]
        for c in range(v.size):
            v[c] -= h * b[c]
    rest = sqrt(inner_rows(v, v))
    for i in range(k):
        x, y = triangle[i, k], triangle[i + 1, k]
        triangle[i, k] = turns[i, 0] * x + turns[i, 1] * y
        triangle[i + 1, k] = turns[i, 0] * y - turns[i, 1] * x
    end = triangle[k, k]
    whole = sqrt(end * end + rest * rest)
    turns[k, 0], turns[k, 1] = end / whole, rest / whole
    triangle[k, k] = whole
    right = triangle[last, k]
    triangle[last, k], triangle[last, k + 1] = turns[k, 0] * right, -turns[k, 1] * right
    if rest <= BREAKDOWN * size:
        return 0.0
    inverse = 1.0 / rest
    for c in range(v.size):
        basis[k + 1, c] = inverse * v[c]
    return float(abs(triangle[last, k + 1]))


@kernel
def _combine(basis: FloatArray, n: int, triangle: FloatArray, x: FloatArray) -> None:
    """Solve the small system of n directions from its last row up; fill x with the sum of the directions."""
    last = triangle.shape[0] - 1
    for i in range(n - 1, -1, -1):
        y = triangle[last, i]
        for c in range(i + 1, n):
            y -= triangle[i, c] * triangle[last, c]
        triangle[last, i] = y / triangle[i, i]
    x[:] = 0.0
    for i in range(n):
        y, b = triangle[last, i], basis[i]
        for c in range(x.size):
            x[c] += y * b[c]


def make_basis(size: int) -> FloatArray:
    """Allocate the directions of `solve_coupled` for so many unknowns."""
    return np.empty((MAX_KRYLOV + 1, size))


def solve_coupled(
    apply: Callable[[FloatArray], FloatArray], start: FloatArray, tolerance: float, basis: FloatArray | None = None
) -> FloatArray:
    """Solve x + C x = b by GMRES without restart (Saad & Schultz 1986).

    Parameters
    ----------
    apply : callable
        Returns C x for an array of the shape of b; what it returns is overwritten.
    start : array
        The right-hand side b, which is also the solution where C vanishes.
    tolerance : float
        Residual to reach, relative to b.
    basis : array, optional
        Room for the directions, from `make_basis`.
    """
    size = length(start)
    if size == 0.0:
        return start
    basis = make_basis(start.size) if basis is None else basis
    basis[0] = start.ravel() / size
    triangle, turns = np.zeros((MAX_KRYLOV + 1, MAX_KRYLOV + 1)), np.zeros((MAX_KRYLOV, 2))
    triangle[-1, 0] = size
    n = 0
    while n < MAX_KRYLOV:
        v = apply(basis[n].reshape(start.shape)).ravel()
        left = _extend(basis, n, v, triangle, turns, size)
        n += 1
        if left <= tolerance * size:
            break
    x = np.empty_like(start)
    _combine(basis, n, triangle, x.ravel())
    return x

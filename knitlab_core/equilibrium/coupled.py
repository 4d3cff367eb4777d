"""Solve with the part of the stiffness that is not symmetric: friction that grows with load.

The symmetric part is factored; a few steps of GMRES, preconditioned by it, add
the rest. Without it Newton's iteration on friction only creeps.
"""

from collections.abc import Callable
from math import hypot

import numpy as np

from knitlab_core.arrays import FloatArray

MAX_KRYLOV = 30


def solve_coupled(apply: Callable[[FloatArray], FloatArray], start: FloatArray, tolerance: float) -> FloatArray:
    """Solve x + C x = b by GMRES without restart (Saad & Schultz 1986).

    Parameters
    ----------
    apply : callable
        Returns C x for an array of the shape of b.
    start : array
        The right-hand side b, which is also the solution where C vanishes.
    tolerance : float
        Residual to reach, relative to b.
    """
    size = float(np.linalg.norm(start))
    if size == 0.0:
        return start
    basis = np.empty((MAX_KRYLOV + 1, start.size))
    basis[0] = start.ravel() / size
    # Givens rotations keep the small system triangular, so that its residual is known as it grows.
    triangle = np.zeros((MAX_KRYLOV, MAX_KRYLOV))
    turns: list[tuple[float, float]] = []
    right = [size]
    for k in range(MAX_KRYLOV):
        v = basis[k] + apply(basis[k].reshape(start.shape)).ravel()
        column = basis[: k + 1] @ v
        v -= column @ basis[: k + 1]
        rest = float(np.linalg.norm(v))
        for i, (c, s) in enumerate(turns):
            column[i], column[i + 1] = c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]
        length = hypot(column[k], rest)
        c, s = column[k] / length, rest / length
        turns.append((c, s))
        column[k] = length
        triangle[: k + 1, k] = column
        right[k:] = [c * right[k], -s * right[k]]
        if abs(right[k + 1]) <= tolerance * size or rest <= 1e-14 * size:
            break
        basis[k + 1] = v / rest
    n = len(turns)
    y = np.linalg.solve(triangle[:n, :n], np.array(right[:n]))
    x: FloatArray = (y @ basis[:n]).reshape(start.shape)
    return x

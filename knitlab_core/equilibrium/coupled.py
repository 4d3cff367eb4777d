"""Solve with the part of the stiffness that is not symmetric: friction that grows with load.

The symmetric part is factored; a few steps of GMRES, preconditioned by it, add
the rest. Without it Newton's iteration on friction only creeps.
"""

from collections.abc import Callable

import numpy as np

from knitlab_core.arrays import FloatArray

MAX_KRYLOV = 30


def solve_coupled(apply: Callable[[FloatArray], FloatArray], start: FloatArray, tolerance: float) -> FloatArray:
    """Solve x + C x = b by GMRES without restart.

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
    basis = [start / size]
    h = np.zeros((MAX_KRYLOV + 1, MAX_KRYLOV))
    y: FloatArray = np.zeros(0)
    for k in range(MAX_KRYLOV):
        v: FloatArray = basis[k] + apply(basis[k])
        for i in range(k + 1):
            h[i, k] = np.vdot(basis[i], v)
            v = v - h[i, k] * basis[i]
        h[k + 1, k] = np.linalg.norm(v)
        b = np.zeros(k + 2)
        b[0] = size
        y = np.asarray(np.linalg.lstsq(h[: k + 2, : k + 1], b, rcond=None)[0], dtype=np.float64)
        rest = np.linalg.norm(h[: k + 2, : k + 1] @ y - b)
        if rest <= tolerance * size or h[k + 1, k] <= 1e-14 * size:
            break
        basis.append(v / h[k + 1, k])
    x = np.zeros_like(start)
    for factor, direction in zip(y, basis, strict=False):
        x += factor * direction
    return x

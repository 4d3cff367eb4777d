"""Sums over vectors in a fixed order: the same bits on every processor, which BLAS does not promise."""

from math import sqrt

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel, kernel


@inline_kernel
def inner_rows(a: FloatArray, b: FloatArray) -> float:
    """Return the scalar product of two vectors (n,), for use inside kernels; four sums run side by side."""
    n = a.size
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    for i in range(n // 4):
        s0 += a[4 * i] * b[4 * i]
        s1 += a[4 * i + 1] * b[4 * i + 1]
        s2 += a[4 * i + 2] * b[4 * i + 2]
        s3 += a[4 * i + 3] * b[4 * i + 3]
    for i in range(4 * (n // 4), n):
        s0 += a[i] * b[i]
    return (s0 + s1) + (s2 + s3)


@kernel
def _inner(a: FloatArray, b: FloatArray) -> float:
    return inner_rows(a, b)


def inner(a: FloatArray, b: FloatArray) -> float:
    """Return the scalar product of two arrays of one shape."""
    return float(_inner(a.ravel(), b.ravel()))


def length(a: FloatArray) -> float:
    """Return the Euclidean length of an array."""
    return sqrt(inner(a, a))

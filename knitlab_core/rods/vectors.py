"""Three-vectors as tuples of floats, for use inside kernels.

Small arrays in kernels cost a hundred times what tuples do: a tuple is kept in
registers, an array is an allocation.
"""

from math import sqrt

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel

Vector = tuple[float, float, float]


@inline_kernel
def row(a: FloatArray, i: int) -> Vector:
    """Return the first three entries of row `i` of an array as a vector."""
    return (a[i, 0], a[i, 1], a[i, 2])


@inline_kernel
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inline_kernel
def sub(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inline_kernel
def scale(s: float, a: Vector) -> Vector:
    """Return s a."""
    return (s * a[0], s * a[1], s * a[2])


@inline_kernel
def combine(s: float, a: Vector, t: float, b: Vector) -> Vector:
    """Return s a + t b."""
    return (s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2])


@inline_kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline_kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of a and b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@inline_kernel
def norm(a: Vector) -> float:
    """Return the length of a."""
    return sqrt(dot(a, a))

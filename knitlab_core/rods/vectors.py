"""Three-vectors as tuples of floats, for use inside kernels.

Small arrays in kernels cost a hundred times what tuples do: a tuple lives in
registers, an array is an allocation.
"""

from math import sqrt

from knitlab_core.jit import inline_kernel


@inline_kernel
def row(a, i):
    """Return the first three entries of row `i` of an array as a vector."""
    return (a[i, 0], a[i, 1], a[i, 2])


@inline_kernel
def add(a, b):
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@inline_kernel
def sub(a, b):
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@inline_kernel
def scale(s, a):
    """Return s a."""
    return (s * a[0], s * a[1], s * a[2])


@inline_kernel
def combine(s, a, t, b):
    """Return s a + t b."""
    return (s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2])


@inline_kernel
def dot(a, b):
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline_kernel
def cross(a, b):
    """Return the vector product of a and b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@inline_kernel
def norm(a):
    """Return the length of a."""
    return sqrt(dot(a, a))

"""Reference frames that follow the edges in time without twisting about them.

Each edge carries a reference director, carried from one configuration to the
next by parallel transport (time-parallel frames, Bergou et al. 2010, section 3).
The reference twist at a node is the angle left between the directors of its two
edges; it is a property of the configuration, not an unknown.
"""

from math import pi
from typing import NamedTuple, Self

import numpy as np

from knitlab_core.angle_kernels import arc_tangent, cosine_sine
from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, norm, row, scale, sub


class Frames(NamedTuple):
    """Tangents, reference directors and reference twists of one configuration.

    `tangent`, `director`: (N, 3); `length`: (N,) edge lengths; `reference_twist`:
    (N,) [rad]. Entries without an edge or without two edges are zero.
    """

    tangent: FloatArray
    director: FloatArray
    length: FloatArray
    reference_twist: FloatArray

    @classmethod
    def zeros(cls, n: int) -> Self:
        """Allocate frames for n nodes."""
        return cls(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n))

    def copy(self) -> Self:
        """Copy every array."""
        return type(self)(*(a.copy() for a in self))


@inline_kernel
def transport(v: Vector, a: Vector, b: Vector) -> Vector:
    """Carry `v` from tangent `a` to tangent `b` by the smallest rotation.

    Parameters
    ----------
    v, a, b : tuple of 3 floats
        Vector, old and new unit tangent.

    Returns
    -------
    tuple of 3 floats
        v + k x v + k (k . v) / (1 + a . b) with k = a x b.
    """
    k = cross(a, b)
    c = dot(a, b)
    kv = cross(k, v)
    s = dot(k, v) / (1.0 + c)
    return (
        c * v[0] + kv[0] + s * k[0],
        c * v[1] + kv[1] + s * k[1],
        c * v[2] + kv[2] + s * k[2],
    )


@kernel
def follow(q: FloatArray, has_edge: BoolArray, source: Frames, target: Frames) -> None:
    """Carry the frames of `source` to configuration `q` and write them to `target`.

    Parameters
    ----------
    q : (N, 4) array
        Positions and edge angles.
    has_edge : (N,) bool array
        True where an edge runs from node i to node i + 1.
    source, target : Frames
        Frames to start from and to fill.

    Notes
    -----
    Edges must turn by less than 180 degrees between the two configurations.
    """
    n = q.shape[0]
    for i in range(n):
        if not has_edge[i]:
            continue
        e = sub(row(q, i + 1), row(q, i))
        length = norm(e)
        t = scale(1.0 / length, e)
        d = transport(row(source.director, i), row(source.tangent, i), t)
        # Rounding is removed here, so that it cannot add up over thousands of steps.
        d = combine(1.0, d, -dot(d, t), t)
        d = scale(1.0 / norm(d), d)
        target.length[i] = length
        for c in range(3):
            target.tangent[i, c] = t[c]
            target.director[i, c] = d[c]
    for i in range(1, n):
        if not (has_edge[i - 1] and has_edge[i]):
            continue
        t = row(target.tangent, i)
        d = row(target.director, i)
        p = transport(row(target.director, i - 1), row(target.tangent, i - 1), t)
        angle = arc_tangent(dot(cross(p, d), t), dot(p, d))
        old = source.reference_twist[i]
        # The branch nearest the old value keeps whole turns of twist.
        target.reference_twist[i] = angle + 2.0 * pi * np.rint((old - angle) / (2.0 * pi))


@kernel
def initial_directors(
    x: FloatArray, has_edge: BoolArray, tangent: FloatArray, director: FloatArray, length: FloatArray
) -> None:
    """Fill tangents, lengths and space-parallel (Bishop) directors of a configuration.

    Parameters
    ----------
    x : (N, 3+) array
        Node positions.
    has_edge : (N,) bool array
        True where an edge runs from node i to node i + 1.
    tangent, director : (N, 3) arrays
        Filled.
    length : (N,) array
        Filled.
    """
    for i in range(x.shape[0]):
        if not has_edge[i]:
            continue
        e = sub(row(x, i + 1), row(x, i))
        length[i] = norm(e)
        t = scale(1.0 / length[i], e)
        if i > 0 and has_edge[i - 1]:
            d = transport(row(director, i - 1), row(tangent, i - 1), t)
        else:
            # Any direction across the first tangent will do; the axis least along it is safest.
            a = (1.0, 0.0, 0.0)
            if abs(t[0]) > 0.9:
                a = (0.0, 1.0, 0.0)
            d = cross(t, a)
        d = combine(1.0, d, -dot(d, t), t)
        d = scale(1.0 / norm(d), d)
        for c in range(3):
            tangent[i, c] = t[c]
            director[i, c] = d[c]


@inline_kernel
def material_directors(t: Vector, d: Vector, angle: float) -> tuple[Vector, Vector]:
    """Turn the reference director by the edge angle: m1 and m2."""
    b = cross(t, d)
    cos_angle, sin_angle = cosine_sine(angle)
    return combine(cos_angle, d, sin_angle, b), combine(-sin_angle, d, cos_angle, b)


@inline_kernel
def curvature_binormal(a: Vector, b: Vector) -> Vector:
    """Return 3 a x b / (2 + a . b) for unit tangents a, b: the angle through which the smooth centreline turns.

    Its size is 3 sin(phi) / (2 + cos(phi)), the angle phi between the edges up to phi^5 / 180;
    2 tan(phi / 2) of Bergou et al. 2008 (eq. 1), for the polygon, errs by phi^3 / 12.
    """
    return scale(3.0 / (2.0 + dot(a, b)), cross(a, b))


@inline_kernel
def material_curvature(kb: Vector, m1a: Vector, m2a: Vector, m1b: Vector, m2b: Vector) -> tuple[float, float]:
    """Resolve the curvature binormal on the mean material frame of a node's two edges."""
    return 0.5 * dot(kb, add(m2a, m2b)), -0.5 * dot(kb, add(m1a, m1b))

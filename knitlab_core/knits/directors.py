"""Directors along a yarn, carried without turning about it, so that they never flip.

Frenet's frame turns over wherever a yarn has no curvature (straight stretches, inflections), and spins
near there. The rotation-minimising frame has no such places, and along a loop of Eq. 1 it comes back to
where it began: the loop is its own mirror image, so what it turns on the way up it turns back on the way down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.angles import arc_tangents, cosine, sine

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.centreline import Centreline

FRAME_STEP: Final = 0.01
"""Longest step by which directors are carried [loop widths]; the error of a step is of fifth order in it."""

_NO_STEP: Final = 1e-9


def directors(centreline: Centreline, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the directors e2 and e3 of the rotation-minimising frame at arc lengths s.

    At the yarn's start e2 is the axis out of the plane, z, made perpendicular to the yarn (x where the yarn
    itself starts along z); e3 = tangent x e2. What is found at an arc length does not depend on the others
    asked for, up to the error of `FRAME_STEP`.

    Parameters
    ----------
    centreline : Centreline
        The yarn.
    s : FloatArray
        (n,) arc lengths, in any order [loop widths].

    Returns
    -------
    tuple of FloatArray
        e2 and e3, each (n, 3), unit vectors.

    References
    ----------
    Wang, Jüttler, Zheng and Liu, "Computation of rotation minimizing frames", ACM Transactions on Graphics 27
    (2008), section 4 (double reflection). Each step's angle is taken against an arbitrary director of its
    own, so that the steps add up instead of following one another.
    """
    steps = int(np.ceil(centreline.length / FRAME_STEP))
    grid, place = np.unique(np.concatenate([np.linspace(0.0, centreline.length, steps + 1), s]), return_inverse=True)
    at, tangent = centreline.position(grid), centreline.tangent(grid)
    any_e2 = _across(tangent)
    any_e3 = np.cross(tangent, any_e2)
    step = np.diff(grid)[:, None]
    # Between spots that differ by rounding there is no chord to speak of.
    chord = np.where(step > _NO_STEP, np.diff(at, axis=0), tangent[1:])
    carried = _double_reflection(chord, tangent, any_e2)
    turns = arc_tangents(_dot(carried, any_e3[1:]), _dot(carried, any_e2[1:]))
    angle = np.concatenate([[0.0], np.cumsum(turns)])[:, None]
    e2 = cosine(angle) * any_e2 + sine(angle) * any_e3
    e3 = np.cross(tangent, e2)
    asked = place[steps + 1 :]
    return e2[asked], e3[asked]


def _across(tangent: FloatArray) -> FloatArray:
    """Return a unit vector (n, 3) perpendicular to each tangent: z, or x where the tangent is nearer to z."""
    axis = np.where(np.abs(tangent[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    across = axis - _dot(axis, tangent)[:, None] * tangent
    unit: FloatArray = across / np.linalg.norm(across, axis=-1, keepdims=True)
    return unit


def _double_reflection(chord: FloatArray, tangent: FloatArray, director: FloatArray) -> FloatArray:
    """Carry each director (n, 3) to the next point: mirror across the chord (n - 1, 3), then between tangents."""
    once, its_tangent = (_mirror(v[:-1], chord) for v in (director, tangent))
    return _mirror(once, tangent[1:] - its_tangent)


def _mirror(v: FloatArray, normal: FloatArray) -> FloatArray:
    mirrored: FloatArray = v - (2.0 * _dot(v, normal) / _dot(normal, normal))[:, None] * normal
    return mirrored


def _dot(left: FloatArray, right: FloatArray) -> FloatArray:
    product: FloatArray = np.sum(left * right, axis=-1)
    return product

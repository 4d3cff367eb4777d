"""Count how often one closed curve winds around another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray


def linking_number(first: FloatArray, second: FloatArray) -> float:
    """Return the Gauss linking number of two closed polygons, to rounding.

    ``Lk = 1/4pi sum_ij Omega_ij``, Omega_ij the solid angle of the parallelogram that the differences of edge
    i and edge j span, in two triangles by Van Oosterom and Strackee's formula.

    Parameters
    ----------
    first, second : FloatArray
        Corners (n, 3) and (m, 3), any unit; the last joins the first. The polygons must not touch.

    Returns
    -------
    float
        A whole number but for rounding [1].

    References
    ----------
    Klenin and Langowski, "Computation of writhe in modeling of supercoiled DNA", Biopolymers 54 (2000);
    Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
    """
    p, q = first[:, None], second[None, :]
    p_next, q_next = np.roll(first, -1, axis=0)[:, None], np.roll(second, -1, axis=0)[None, :]
    a, b, c, d = q - p, q - p_next, q_next - p_next, q_next - p
    solid_angles = half_solid_angle(a, b, c) + half_solid_angle(a, c, d)
    return float(np.sum(solid_angles)) / (2.0 * np.pi)


def half_solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return half the solid angle of triangles with corners a, b, c (..., 3), seen from the origin [sr]."""
    size_a, size_b, size_c = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    triple = np.sum(a * np.cross(b, c), axis=-1)
    projections = np.sum(a * b, axis=-1) * size_c + np.sum(b * c, axis=-1) * size_a + np.sum(c * a, axis=-1) * size_b
    angle: FloatArray = np.arctan2(triple, size_a * size_b * size_c + projections)
    return angle

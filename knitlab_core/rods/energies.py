"""Stretching, bending and twisting of discrete elastic rods: energy and gradient.

Bergou et al. 2008 (energies) and 2010 (twist and derivatives). Bending is
quadratic in the material curvature measured from the rest curvature, so that a
knit printed in its knitted shape is free of stress.

The gradient is that of the energy as a function of q with the frames of the
current configuration as the source of transport; `stiffness.py` has the Hessian.
"""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.frames import Frames, curvature_binormal, material_curvature, material_directors
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, row, scale


@kernel
def rod_energy(q: FloatArray, rods: Rods, frames: Frames) -> tuple[float, float, float]:
    """Return stretching, bending and twisting energy.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and edge angles [rad].
    rods : Rods
        Rest state and stiffness.
    frames : Frames
        Frames of `q`.

    Returns
    -------
    tuple of 3 floats
        Energies [E r^3].
    """
    stretch = 0.0
    bend = 0.0
    twist = 0.0
    for i in range(q.shape[0]):
        if rods.has_edge[i]:
            rest = rods.rest_length[i]
            strain = frames.length[i] / rest - 1.0
            stretch += 0.5 * rods.stretch_stiffness[i] * strain * strain * rest
        if rods.is_inner[i]:
            te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
            m1e, m2e = material_directors(te, row(frames.director, i - 1), np.cos(q[i - 1, 3]), np.sin(q[i - 1, 3]))
            m1f, m2f = material_directors(tf, row(frames.director, i), np.cos(q[i, 3]), np.sin(q[i, 3]))
            k1, k2 = material_curvature(curvature_binormal(te, tf), m1e, m2e, m1f, m2f)
            k1 -= rods.rest_curvature[i, 0]
            k2 -= rods.rest_curvature[i, 1]
            m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
            bend += 0.5 * rods.bend_stiffness[i] * (k1 * k1 + k2 * k2) / rods.span[i]
            twist += 0.5 * rods.twist_stiffness[i] * m * m / rods.span[i]
    return stretch, bend, twist


@inline_kernel
def _add(gradient: FloatArray, i: int, s: float, v: Vector) -> None:
    for c in range(3):
        gradient[i, c] += s * v[c]


@inline_kernel
def curvature_slopes(
    k: float, s: Vector, te: Vector, tf: Vector, tt: Vector, chi: float, le: float, lf: float
) -> tuple[Vector, Vector]:
    """Return dk/de and dk/df of k = kb . g, where s is the sum of the edges' directors."""
    gt = scale(1.0 / chi, s)
    de = scale(1.0 / le, combine(-k, tt, 1.0, cross(tf, gt)))
    df = scale(1.0 / lf, combine(-k, tt, -1.0, cross(te, gt)))
    return de, df


@kernel
def rod_gradient(q: FloatArray, rods: Rods, frames: Frames, gradient: FloatArray) -> None:
    """Add the gradient of the rods' energy to `gradient` (N, 4) [E r^2, E r^3]."""
    for i in range(q.shape[0]):
        if rods.has_edge[i]:
            t = row(frames.tangent, i)
            f = rods.stretch_stiffness[i] * (frames.length[i] / rods.rest_length[i] - 1.0)
            _add(gradient, i, -f, t)
            _add(gradient, i + 1, f, t)
        if rods.is_inner[i]:
            te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
            le, lf = frames.length[i - 1], frames.length[i]
            m1e, m2e = material_directors(te, row(frames.director, i - 1), np.cos(q[i - 1, 3]), np.sin(q[i - 1, 3]))
            m1f, m2f = material_directors(tf, row(frames.director, i), np.cos(q[i, 3]), np.sin(q[i, 3]))
            kb = curvature_binormal(te, tf)
            k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
            eb = rods.bend_stiffness[i] / rods.span[i]
            c1 = eb * (k1 - rods.rest_curvature[i, 0])
            c2 = eb * (k2 - rods.rest_curvature[i, 1])
            m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
            c3 = rods.twist_stiffness[i] / rods.span[i] * m
            # One director stands for both curvatures: c1 k1 + c2 k2 = kb . (ge + gf) / 2.
            ge = combine(c1, m2e, -c2, m1e)
            gf = combine(c1, m2f, -c2, m1f)
            chi = 1.0 + dot(te, tf)
            tt = scale(1.0 / chi, add(te, tf))
            s = add(ge, gf)
            k = 0.5 * dot(kb, s)
            de, df = curvature_slopes(k, s, te, tf, tt, chi, le, lf)
            de = combine(1.0, de, 0.5 * c3 / le, kb)
            df = combine(1.0, df, 0.5 * c3 / lf, kb)
            _add(gradient, i - 1, -1.0, de)
            _add(gradient, i, 1.0, de)
            _add(gradient, i, -1.0, df)
            _add(gradient, i + 1, 1.0, df)
            # d(m1)/dtheta = m2 and d(m2)/dtheta = -m1.
            gradient[i - 1, 3] += -0.5 * dot(kb, combine(c1, m1e, c2, m2e)) - c3
            gradient[i, 3] += -0.5 * dot(kb, combine(c1, m1f, c2, m2f)) + c3

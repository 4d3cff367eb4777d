"""Stretching, bending and twisting of discrete elastic rods: energy and gradient.

The rod is the smooth yarn, the quadratic B-spline of which the nodes are the control
points. A span stretches by its length on that spline and bends by the angle through which
the spline turns, 3 sin(phi) / (2 + cos(phi)) in place of Bergou's 2 tan(phi / 2); twist and
frames are those of the edges (Bergou et al. 2008 and 2010). A stiffness against edges of
unequal strain keeps nodes where they are along the yarn; with it a straight rod has the
energy of its edges. Bending is quadratic in the material curvature measured from the rest
curvature, so that a knit printed in its knitted shape is free of stress.

The gradient is that of the energy as a function of q with the frames of the
current configuration as the source of transport; `stiffness.py` has the Hessian.
"""

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.frames import Frames, curvature_binormal, material_curvature, material_directors
from knitlab_core.rods.rod import Rods, eased, span_chord, span_length
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, row, scale

NOTHING = (0.0, 0.0, 0.0)
"""Vectors of the edge before the first."""


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
    te, m1e, m2e, le = NOTHING, NOTHING, NOTHING, 0.0
    for i in range(q.shape[0]):
        if not rods.has_edge[i]:
            continue
        tf, lf = row(frames.tangent, i), frames.length[i]
        m1f, m2f = material_directors(tf, row(frames.director, i), q[i, 3])
        if rods.is_inner[i]:
            _, chord = span_chord(te, le, tf, lf)
            axial = span_length(chord, le, lf) / rods.span[i] - 1.0 - rods.rest_stretch[i, 0]
            root, _ = eased(i, dot(te, tf), rods)
            uneven = root * (le / rods.rest_length[i - 1] - lf / rods.rest_length[i]) - rods.rest_stretch[i, 1]
            square = rods.span[i] * axial * axial + rods.evenness[i] * uneven * uneven
            stretch += 0.5 * rods.stretch_stiffness[i] * square
            kb = curvature_binormal(te, tf)
            k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
            k1 -= rods.rest_curvature[i, 0]
            k2 -= rods.rest_curvature[i, 1]
            m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
            bend += 0.5 * rods.bend_stiffness[i] * (k1 * k1 + k2 * k2) / rods.span[i]
            twist += 0.5 * rods.twist_stiffness[i] * m * m / rods.span[i]
        for end in (i, i + 1):
            if not rods.is_inner[end]:
                axial = lf / rods.rest_length[i] - 1.0 - rods.rest_stretch[end, 0]
                stretch += 0.5 * rods.stretch_stiffness[end] * rods.stretched[end] * axial * axial
        te, m1e, m2e, le = tf, m1f, m2f, lf
    return stretch, bend, twist


@inline_kernel
def _add(gradient: FloatArray, i: int, s: float, v: Vector) -> None:
    for c in range(3):
        gradient[i, c] += s * v[c]


@inline_kernel
def curvature_slopes(
    k: float, s: Vector, te: Vector, tf: Vector, chi: float, le: float, lf: float
) -> tuple[Vector, Vector]:
    """Return dk/de and dk/df of k = kb . s / 2, where s is the sum of the edges' directors and chi is 2 + te . tf."""
    gt = scale(1.5 / chi, s)
    kc = k / chi
    de = scale(1.0 / le, combine(-kc, combine(2.0, te, 1.0, tf), 1.0, cross(tf, gt)))
    df = scale(1.0 / lf, combine(-kc, combine(1.0, te, 2.0, tf), -1.0, cross(te, gt)))
    return de, df


@inline_kernel
def end_tension(edge: int, end: int, length: float, rods: Rods) -> tuple[float, float]:
    """Return tension and stiffness of the half of an edge that belongs to a rod's end."""
    rest = rods.rest_length[edge]
    share = rods.stretch_stiffness[end] * rods.stretched[end] / rest
    return share * (length / rest - 1.0 - rods.rest_stretch[end, 0]), share / rest


@kernel
def rod_gradient(q: FloatArray, rods: Rods, frames: Frames, gradient: FloatArray) -> None:
    """Add the gradient of the rods' energy to `gradient` (N, 4) [E r^2, E r^3]."""
    te, m1e, m2e, le = NOTHING, NOTHING, NOTHING, 0.0
    for i in range(q.shape[0]):
        if not rods.has_edge[i]:
            continue
        tf, lf = row(frames.tangent, i), frames.length[i]
        m1f, m2f = material_directors(tf, row(frames.director, i), q[i, 3])
        if rods.is_inner[i]:
            ts, chord = span_chord(te, le, tf, lf)
            ea = rods.stretch_stiffness[i]
            rest_e, rest_f = rods.rest_length[i - 1], rods.rest_length[i]
            axial = ea * (span_length(chord, le, lf) / rods.span[i] - 1.0 - rods.rest_stretch[i, 0])
            w = cross(te, tf)
            cosine = dot(te, tf)
            root, slope = eased(i, cosine, rods)
            difference = le / rest_e - lf / rest_f
            uneven = root * ea * rods.evenness[i] * (root * difference - rods.rest_stretch[i, 1])
            opening = 0.5 * slope * difference * uneven

            chi = 2.0 + cosine
            kb = scale(3.0 / chi, w)
            k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
            eb = rods.bend_stiffness[i] / rods.span[i]
            c1 = eb * (k1 - rods.rest_curvature[i, 0])
            c2 = eb * (k2 - rods.rest_curvature[i, 1])
            m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
            c3 = rods.twist_stiffness[i] / rods.span[i] * m
            # One director stands for both curvatures: c1 k1 + c2 k2 = kb . (ge + gf) / 2.
            s = add(combine(c1, m2e, -c2, m1e), combine(c1, m2f, -c2, m1f))
            de, df = curvature_slopes(0.5 * dot(kb, s), s, te, tf, chi, le, lf)
            ct = c3 / (1.0 + cosine)
            de = add(combine(1.0, de, ct / le, w), combine(axial / 6.0 + uneven / rest_e, te, axial / 3.0, ts))
            df = add(combine(1.0, df, ct / lf, w), combine(axial / 6.0 - uneven / rest_f, tf, axial / 3.0, ts))
            de = combine(1.0, de, opening / le, combine(1.0, tf, -cosine, te))
            df = combine(1.0, df, opening / lf, combine(1.0, te, -cosine, tf))
            _add(gradient, i - 1, -1.0, de)
            _add(gradient, i, 1.0, combine(1.0, de, -1.0, df))
            _add(gradient, i + 1, 1.0, df)
            # d(m1)/dtheta = m2 and d(m2)/dtheta = -m1.
            gradient[i - 1, 3] += -0.5 * dot(kb, combine(c1, m1e, c2, m2e)) - c3
            gradient[i, 3] += -0.5 * dot(kb, combine(c1, m1f, c2, m2f)) + c3
        for end in (i, i + 1):
            if not rods.is_inner[end]:
                tension, _ = end_tension(i, end, lf, rods)
                _add(gradient, i, -tension, tf)
                _add(gradient, i + 1, tension, tf)
        te, m1e, m2e, le = tf, m1f, m2f, lf

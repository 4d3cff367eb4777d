"""Hessian of what yielding takes from the energy of rods, as 4 x 4 node blocks.

The rest strains of the elastic rods beside it are moved so that forces are right (`yielding.relieve`); their Hessian
then lacks only the second derivatives of the section by its strains, which are here.
"""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.energies import NOTHING, curvature_slopes
from knitlab_core.rods.frames import Frames, curvature_binormal, material_curvature, material_directors
from knitlab_core.rods.rod import Rods, span_chord
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, row, scale
from knitlab_core.rods.yielding import Yielding, section_softening, torsion_relief
from knitlab_core.sparse.blocks import Pattern

Triad = tuple[Vector, Vector, Vector]
"""Tangent and material directors of an edge."""


@kernel
def add_yield_hessian(
    q: FloatArray,
    rods: Rods,
    frames: Frames,
    strain: FloatArray,
    law: Yielding,
    plastic: FloatArray,
    new: BoolArray,
    pattern: Pattern,
    blocks: FloatArray,
) -> None:
    """Subtract from the node blocks what sections that yield lack of stiffness.

    Parameters
    ----------
    q : (N, 4) array
        Positions and edge angles.
    rods, frames : Rods, Frames
        Rods as made, and frames of `q`.
    strain : (N, 5) array
        Strains from rest.
    law, plastic, new
        How sections yield, their plastic strains, and which elements have none; as in `yielding.relieve`.
    pattern, blocks
        As in `stiffness.rod_hessian`.
    """
    slopes, taken = np.zeros((4, 12)), np.zeros((4, 12))
    e = (NOTHING, NOTHING, NOTHING)
    for i in range(q.shape[0]):
        if not rods.has_edge[i]:
            continue
        t = row(frames.tangent, i)
        m1, m2 = material_directors(t, row(frames.director, i), q[i, 3])
        if rods.is_inner[i] and rods.stretch_stiffness[i] != 0.0:
            softening = _softening_of(i, rods, strain, law, plastic, new)
            if softening[0] != 0.0 or softening[6] != 0.0:
                _fill_slopes(i, frames, e, (t, m1, m2), slopes)
                _weigh(softening, 1.0 / rods.span[i], slopes, taken)
                _subtract(slopes, taken, 0, 0, pattern.diagonal[i - 1], blocks)
                _subtract(slopes, taken, 4, 4, pattern.diagonal[i], blocks)
                _subtract(slopes, taken, 8, 8, pattern.diagonal[i + 1], blocks)
                _subtract(slopes, taken, 4, 0, pattern.below[i], blocks)
                _subtract(slopes, taken, 8, 4, pattern.below[i + 1], blocks)
                _subtract(slopes, taken, 8, 0, pattern.below2[i + 1], blocks)
        for end in (i, i + 1):
            if not rods.is_inner[end]:
                along = (
                    section_softening(end, strain[end, 0], 0.0, 0.0, law, plastic, new)[0]
                    * rods.stretched[end]
                    / rods.rest_length[i] ** 2
                )
                for r in range(3):
                    for c in range(3):
                        h = along * t[r] * t[c]
                        blocks[pattern.diagonal[i], r, c] -= h
                        blocks[pattern.diagonal[i + 1], r, c] -= h
                        blocks[pattern.below[i + 1], r, c] += h
        e = (t, m1, m2)


@inline_kernel
def _put(slopes: FloatArray, s: int, de: Vector, df: Vector, at_e: float, at_f: float) -> None:
    """Write the slopes of a strain by two edges and their angles as those by three nodes."""
    for c in range(3):
        slopes[s, c] = -de[c]
        slopes[s, 4 + c] = de[c] - df[c]
        slopes[s, 8 + c] = df[c]
    slopes[s, 3], slopes[s, 7], slopes[s, 11] = at_e, at_f, 0.0


@inline_kernel
def _softening_of(
    i: int, rods: Rods, strain: FloatArray, law: Yielding, plastic: FloatArray, new: BoolArray
) -> tuple[float, float, float, float, float, float, float]:
    """Return what the section of an inner node lacks of stiffness: the six of `section_softening`, and twist's."""
    length = rods.span[i]
    axial, k1, k2, twist = strain[i, 0], strain[i, 1] / length, strain[i, 2] / length, strain[i, 3] / length
    aa, a1, a2, r11, r12, r22 = section_softening(i, axial, k1, k2, law, plastic, new)
    tt = torsion_relief(i, twist, law, plastic, new)[2]
    return aa, a1, a2, r11, r12, r22, tt


@inline_kernel
def _fill_slopes(i: int, frames: Frames, edge_e: Triad, edge_f: Triad, slopes: FloatArray) -> None:
    """Fill the slopes (4, 12) of axial strain, both curvatures and twist of a span, times its length."""
    te, m1e, m2e = edge_e
    tf, m1f, m2f = edge_f
    le, lf = frames.length[i - 1], frames.length[i]
    ts, _ = span_chord(te, le, tf, lf)
    sixth, third = 1.0 / 6.0, 1.0 / 3.0
    _put(slopes, 0, combine(sixth, te, third, ts), combine(sixth, tf, third, ts), 0.0, 0.0)
    chi, w = 2.0 + dot(te, tf), cross(te, tf)
    kb = curvature_binormal(te, tf)
    c1, c2 = material_curvature(kb, m1e, m2e, m1f, m2f)
    de, df = curvature_slopes(c1, add(m2e, m2f), te, tf, chi, le, lf)
    _put(slopes, 1, de, df, -0.5 * dot(kb, m1e), -0.5 * dot(kb, m1f))
    de, df = curvature_slopes(c2, scale(-1.0, add(m1e, m1f)), te, tf, chi, le, lf)
    _put(slopes, 2, de, df, -0.5 * dot(kb, m2e), -0.5 * dot(kb, m2f))
    turn = 1.0 / (chi - 1.0)
    _put(slopes, 3, scale(turn / le, w), scale(turn / lf, w), -1.0, 1.0)


@inline_kernel
def _weigh(
    softening: tuple[float, float, float, float, float, float, float],
    per: float,
    slopes: FloatArray,
    taken: FloatArray,
) -> None:
    """Fill `taken` with the softening times the slopes, times `per`."""
    aa, a1, a2, r11, r12, r22, tt = softening
    for c in range(12):
        ga, g1, g2 = slopes[0, c], slopes[1, c], slopes[2, c]
        taken[0, c] = per * (aa * ga + a1 * g1 + a2 * g2)
        taken[1, c] = per * (a1 * ga + r11 * g1 + r12 * g2)
        taken[2, c] = per * (a2 * ga + r12 * g1 + r22 * g2)
        taken[3, c] = per * tt * slopes[3, c]


@inline_kernel
def _subtract(
    slopes: FloatArray, taken: FloatArray, row_at: int, column_at: int, block: int, blocks: FloatArray
) -> None:
    for r in range(4):
        for c in range(4):
            h = 0.0
            for s in range(4):
                h += slopes[s, row_at + r] * taken[s, column_at + c]
            blocks[block, r, c] -= h

"""Hessian of the rods' energy, as 4 x 4 node blocks.

Second derivatives of curvature and twist after Bergou et al. 2010 (appendix),
written for one director that stands for both curvature components: with
c = dE/dkappa, c1 kappa1 + c2 kappa2 = kb . (ge + gf) / 2 with g = c1 m2 - c2 m1.
"""

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.blocks import Pattern
from knitlab_core.rods.energies import curvature_slopes
from knitlab_core.rods.frames import Frames, curvature_binormal, material_curvature, material_directors
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.vectors import add, combine, cross, dot, row, scale


@inline_kernel
def _add_stretch(
    i: int, rods: Rods, frames: Frames, exact: float, blocks: FloatArray, diagonal: IndexArray, below: IndexArray
) -> None:
    t = row(frames.tangent, i)
    length, rest = frames.length[i], rods.rest_length[i]
    axial = rods.stretch_stiffness[i] / rest
    force = rods.stretch_stiffness[i] * (length / rest - 1.0)
    # The geometric part is positive under tension only.
    across = (max(force, 0.0) + exact * min(force, 0.0)) / length
    for r in range(3):
        for c in range(3):
            h = (axial - across) * t[r] * t[c]
            if r == c:
                h += across
            blocks[diagonal[i], r, c] += h
            blocks[diagonal[i + 1], r, c] += h
            blocks[below[i + 1], r, c] -= h


@kernel
def rod_hessian(q: FloatArray, rods: Rods, frames: Frames, exact: float, pattern: Pattern, blocks: FloatArray) -> None:
    """Add the Hessian of the rods' energy to the node blocks.

    Parameters
    ----------
    q : (N, 4) array
        Positions and edge angles.
    rods : Rods
        Rest state and stiffness.
    frames : Frames
        Frames of `q`.
    exact : float
        Weight of the second derivatives of the strains: 0 is Gauss-Newton
        (positive semi-definite), 1 the exact Hessian.
    pattern : Pattern
        Where the blocks of nodes (i, i), (i, i - 1) and (i, i - 2) are stored.
    blocks : (B, 4, 4) array
        Block (i, j), i >= j, has rows of node i and columns of node j.
    """
    diagonal, below, below2 = pattern.diagonal, pattern.below, pattern.below2
    for i in range(q.shape[0]):
        if rods.has_edge[i]:
            _add_stretch(i, rods, frames, exact, blocks, diagonal, below)
        if rods.is_inner[i]:
            _add_bend_twist(i, q, rods, frames, exact, blocks, diagonal, below, below2)


@inline_kernel
def _add_bend_twist(
    i: int,
    q: FloatArray,
    rods: Rods,
    frames: Frames,
    exact: float,
    blocks: FloatArray,
    diagonal: IndexArray,
    below: IndexArray,
    below2: IndexArray,
) -> None:
    te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
    le, lf = frames.length[i - 1], frames.length[i]
    m1e, m2e = material_directors(te, row(frames.director, i - 1), np.cos(q[i - 1, 3]), np.sin(q[i - 1, 3]))
    m1f, m2f = material_directors(tf, row(frames.director, i), np.cos(q[i, 3]), np.sin(q[i, 3]))
    kb = curvature_binormal(te, tf)
    k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
    chi = 1.0 + dot(te, tf)
    tt = scale(1.0 / chi, add(te, tf))
    eb = rods.bend_stiffness[i] / rods.span[i]
    gj = rods.twist_stiffness[i] / rods.span[i]
    c1 = exact * eb * (k1 - rods.rest_curvature[i, 0])
    c2 = exact * eb * (k2 - rods.rest_curvature[i, 1])
    m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
    c3 = exact * gj * m

    # Gauss-Newton part: slopes of kappa1, kappa2 and twist in e, f and the two angles.
    s2 = add(m2e, m2f)
    s1 = scale(-1.0, add(m1e, m1f))
    ae, af = curvature_slopes(k1, s2, te, tf, tt, chi, le, lf)
    be, bf = curvature_slopes(k2, s1, te, tf, tt, chi, le, lf)
    ate, atf = -0.5 * dot(kb, m1e), -0.5 * dot(kb, m1f)
    bte, btf = -0.5 * dot(kb, m2e), -0.5 * dot(kb, m2f)
    he, hf = 0.5 / le, 0.5 / lf

    # Exact part: one director g for both curvatures; p is its derivative in its angle.
    ge = combine(c1, m2e, -c2, m1e)
    gf = combine(c1, m2f, -c2, m1f)
    pe = combine(-c1, m1e, -c2, m2e)
    pf = combine(-c1, m1f, -c2, m2f)
    gs = add(ge, gf)
    k = 0.5 * dot(kb, gs)
    gt = scale(1.0 / chi, gs)
    a = cross(tf, gt)
    b = cross(te, gt)
    ie, jf, ef = 1.0 / (le * le), 1.0 / (lf * lf), 1.0 / (le * lf)
    kc = k / chi
    # Twist's own second derivatives have the form of the curvature's and join them here.
    we = combine(0.25, ge, -0.25 * c3, add(te, tt))
    wf = combine(0.25, gf, -0.25 * c3, add(tf, tt))
    ve, vf = combine(k, tt, -1.0, a), combine(k, tt, 1.0, b)
    turn = combine(1.0, gt, -c3 / chi, te)
    hkb = scale(0.5 * c3, kb)

    se, sf = -0.5 * dot(kb, pe), -0.5 * dot(kb, pf)
    xe = combine(se / le, tt, 1.0 / (chi * le), cross(tf, pe))
    xf = combine(sf / le, tt, 1.0 / (chi * le), cross(tf, pf))
    ye = combine(se / lf, tt, -1.0 / (chi * lf), cross(te, pe))
    yf = combine(sf / lf, tt, -1.0 / (chi * lf), cross(te, pf))

    dp, di, dn = diagonal[i - 1], diagonal[i], diagonal[i + 1]
    bi, bn, b2 = below[i], below[i + 1], below2[i + 1]
    for r in range(3):
        x, y = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            one = 1.0 if r == c else 0.0
            # The cross matrix of `turn`, transposed.
            skew = turn[y] if c == x else (-turn[x] if c == y else 0.0)
            kk = kb[r] * kb[c]
            hee = eb * (ae[r] * ae[c] + be[r] * be[c]) + gj * he * he * kk
            hee += ie * (ve[r] * tt[c] + tt[r] * ve[c] - kc * (one - te[r] * te[c]) + (kb[r] * we[c] + we[r] * kb[c]))
            hff = eb * (af[r] * af[c] + bf[r] * bf[c]) + gj * hf * hf * kk
            hff += jf * (vf[r] * tt[c] + tt[r] * vf[c] - kc * (one - tf[r] * tf[c]) + (kb[r] * wf[c] + wf[r] * kb[c]))
            # Rows of f and columns of e; its transpose is the other.
            hfe = eb * (af[r] * ae[c] + bf[r] * be[c]) + gj * he * hf * kk
            hfe += ef * (tt[r] * (ve[c] - hkb[c]) + vf[r] * tt[c] - kc * (one + tf[r] * te[c]) - skew)
            blocks[dp, r, c] += hee
            blocks[di, r, c] += hee + hff - hfe
            blocks[di, c, r] -= hfe
            blocks[dn, r, c] += hff
            blocks[bi, r, c] += hfe - hee
            blocks[bn, r, c] += hfe - hff
            blocks[b2, r, c] -= hfe
        # Position-angle terms: rows are x, the column is the angle of e or of f.
        xee = eb * (ae[r] * ate + be[r] * bte) - gj * he * kb[r]
        xef = eb * (ae[r] * atf + be[r] * btf) + gj * he * kb[r]
        xfe = eb * (af[r] * ate + bf[r] * bte) - gj * hf * kb[r]
        xff = eb * (af[r] * atf + bf[r] * btf) + gj * hf * kb[r]
        xee += xe[r]
        xef += xf[r]
        xfe += ye[r]
        xff += yf[r]
        blocks[dp, r, 3] -= xee
        blocks[dp, 3, r] -= xee
        blocks[di, r, 3] += xef - xff
        blocks[di, 3, r] += xef - xff
        blocks[bi, r, 3] += xee - xfe
        blocks[bi, 3, r] -= xef
        blocks[b2, r, 3] += xfe
        blocks[bn, r, 3] += xff
    blocks[dp, 3, 3] += eb * (ate * ate + bte * bte) + gj - 0.5 * dot(kb, ge)
    blocks[di, 3, 3] += eb * (atf * atf + btf * btf) + gj - 0.5 * dot(kb, gf)
    blocks[bi, 3, 3] += eb * (ate * atf + bte * btf) - gj

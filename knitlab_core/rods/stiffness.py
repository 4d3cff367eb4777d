"""Hessian of the rods' energy, as 4 x 4 node blocks.

Second derivatives of curvature and twist after Bergou et al. 2010 (appendix),
written for one director that stands for both curvature components: with
c = dE/dkappa, c1 kappa1 + c2 kappa2 = kb . (ge + gf) / 2 with g = c1 m2 - c2 m1.
"""

import numpy as np

from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.energies import curvature_slopes
from knitlab_core.rods.frames import curvature_binormal, material_curvature, material_directors
from knitlab_core.rods.vectors import add, combine, cross, dot, row, scale


@inline_kernel
def _cross_matrix(v):
    return (0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0)


@inline_kernel
def _add_stretch(i, rods, frames, exact, blocks, diagonal, below):
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
def rod_hessian(q, rods, frames, exact, pattern, blocks):
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
def _add_bend_twist(i, q, rods, frames, exact, blocks, diagonal, below, below2):
    te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
    le, lf = frames.length[i - 1], frames.length[i]
    m1e, m2e = material_directors(
        te, row(frames.director, i - 1), np.cos(q[i - 1, 3]), np.sin(q[i - 1, 3])
    )
    m1f, m2f = material_directors(
        tf, row(frames.director, i), np.cos(q[i, 3]), np.sin(q[i, 3])
    )
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
    gx = _cross_matrix(gt)
    tx = _cross_matrix(te)
    ue, uf = add(te, tt), add(tf, tt)
    ie, jf, ef = 1.0 / (le * le), 1.0 / (lf * lf), 1.0 / (le * lf)

    dp, di, dn = diagonal[i - 1], diagonal[i], diagonal[i + 1]
    bi, bn, b2 = below[i], below[i + 1], below2[i + 1]
    for r in range(3):
        for c in range(3):
            one = 1.0 if r == c else 0.0
            kk = kb[r] * kb[c]
            ktt = 2.0 * k * tt[r] * tt[c]
            hee = eb * (ae[r] * ae[c] + be[r] * be[c]) + gj * he * he * kk
            hff = eb * (af[r] * af[c] + bf[r] * bf[c]) + gj * hf * hf * kk
            # hfe has rows of f and columns of e.
            hfe = eb * (af[r] * ae[c] + bf[r] * be[c]) + gj * he * hf * kk
            hee += ie * (
                ktt
                - a[r] * tt[c]
                - tt[r] * a[c]
                - k / chi * (one - te[r] * te[c])
                + 0.25 * (kb[r] * ge[c] + ge[r] * kb[c])
                - 0.25 * c3 * (kb[r] * ue[c] + ue[r] * kb[c])
            )
            hff += jf * (
                ktt
                + b[r] * tt[c]
                + tt[r] * b[c]
                - k / chi * (one - tf[r] * tf[c])
                + 0.25 * (kb[r] * gf[c] + gf[r] * kb[c])
                - 0.25 * c3 * (kb[r] * uf[c] + uf[r] * kb[c])
            )
            hfe += ef * (
                ktt
                - tt[r] * a[c]
                + b[r] * tt[c]
                - k / chi * (one + tf[r] * te[c])
                - gx[3 * c + r]
                + 0.5 * c3 * (2.0 / chi * tx[3 * c + r] - tt[r] * kb[c])
            )
            hef = eb * (ae[r] * af[c] + be[r] * bf[c]) + gj * he * hf * kk
            hef += ef * (
                ktt
                - a[r] * tt[c]
                + tt[r] * b[c]
                - k / chi * (one + te[r] * tf[c])
                - gx[3 * r + c]
                + 0.5 * c3 * (2.0 / chi * tx[3 * r + c] - kb[r] * tt[c])
            )
            blocks[dp, r, c] += hee
            blocks[di, r, c] += hee - hef - hfe + hff
            blocks[dn, r, c] += hff
            blocks[bi, r, c] += hfe - hee
            blocks[bn, r, c] += hfe - hff
            blocks[b2, r, c] -= hfe
        # Position-angle terms: rows are x, the column is the angle of e or of f.
        xee = eb * (ae[r] * ate + be[r] * bte) - gj * he * kb[r]
        xef = eb * (ae[r] * atf + be[r] * btf) + gj * he * kb[r]
        xfe = eb * (af[r] * ate + bf[r] * bte) - gj * hf * kb[r]
        xff = eb * (af[r] * atf + bf[r] * btf) + gj * hf * kb[r]
        pee, pff = cross(tf, pe), cross(tf, pf)
        qee, qff = cross(te, pe), cross(te, pf)
        xee += (-0.5 * dot(kb, pe) * tt[r] + pee[r] / chi) / le
        xef += (-0.5 * dot(kb, pf) * tt[r] + pff[r] / chi) / le
        xfe += (-0.5 * dot(kb, pe) * tt[r] - qee[r] / chi) / lf
        xff += (-0.5 * dot(kb, pf) * tt[r] - qff[r] / chi) / lf
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

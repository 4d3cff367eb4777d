"""Hessian of the rods' energy, as 4 x 4 node blocks.

Second derivatives of curvature and twist after Bergou et al. 2010 (appendix), for the
smooth curvature kb = 3 te x tf / (2 + te . tf) and written for one director that stands for
both of its components: with c = dE/dkappa, c1 kappa1 + c2 kappa2 = kb . (ge + gf) / 2 with
g = c1 m2 - c2 m1. All is written in the two edges e and f of a span; products of like
vectors are collected, so that every block of two edges is a few outer products.
"""

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.energies import NOTHING, curvature_slopes, end_tension
from knitlab_core.rods.frames import Frames, material_curvature, material_directors
from knitlab_core.rods.rod import Rods, eased, span_chord, span_length
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, row, scale
from knitlab_core.sparse.blocks import Pattern

Triad = tuple[Vector, Vector, Vector]
"""Tangent and material directors of an edge."""


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
    add_rod_hessian(q, rods, frames, exact, pattern, blocks, 0, q.shape[0])


@kernel
def add_rod_hessian(
    q: FloatArray,
    rods: Rods,
    frames: Frames,
    exact: float,
    pattern: Pattern,
    blocks: FloatArray,
    first: int,
    last: int,
) -> None:
    """Do so for the spans of nodes `first` to `last` - 1 and the edges that leave them: these act on one node more."""
    e = (NOTHING, NOTHING, NOTHING)
    if first > 0 and rods.has_edge[first - 1]:
        e = _triad(first - 1, q, frames)
    for i in range(first, last):
        if not rods.has_edge[i]:
            continue
        f = _triad(i, q, frames)
        t = f[0]
        if rods.is_inner[i]:
            _add_span(i, q, rods, frames, exact, e, f, pattern, blocks)
        for end in (i, i + 1):
            if not rods.is_inner[end]:
                _add_end(i, end, t, rods, frames, exact, pattern, blocks)
        e = f


@inline_kernel
def _triad(i: int, q: FloatArray, frames: Frames) -> Triad:
    t = row(frames.tangent, i)
    m1, m2 = material_directors(t, row(frames.director, i), q[i, 3])
    return t, m1, m2


@inline_kernel
def _geometric(force: float, exact: float) -> float:
    """Return the weight of a tension's geometric part, which is positive under tension only."""
    return max(force, 0.0) + exact * min(force, 0.0)


@inline_kernel
def _add_end(
    i: int, end: int, t: Vector, rods: Rods, frames: Frames, exact: float, pattern: Pattern, blocks: FloatArray
) -> None:
    length = frames.length[i]
    tension, axial = end_tension(i, end, length, rods)
    across = _geometric(tension, exact) / length
    for r in range(3):
        for c in range(3):
            h = (axial - across) * t[r] * t[c]
            if r == c:
                h += across
            blocks[pattern.diagonal[i], r, c] += h
            blocks[pattern.diagonal[i + 1], r, c] += h
            blocks[pattern.below[i + 1], r, c] -= h


@inline_kernel
def _add_span(
    i: int,
    q: FloatArray,
    rods: Rods,
    frames: Frames,
    exact: float,
    edge_e: Triad,
    edge_f: Triad,
    pattern: Pattern,
    blocks: FloatArray,
) -> None:
    te, m1e, m2e = edge_e
    tf, m1f, m2f = edge_f
    le, lf = frames.length[i - 1], frames.length[i]
    ie, jf = 1.0 / le, 1.0 / lf

    # Stretching: slopes of the span's length in e and f, and what its tensions add across the edges and the chord.
    ts, chord = span_chord(te, le, tf, lf)
    ea, rest = rods.stretch_stiffness[i], rods.span[i]
    re, rf = 1.0 / rods.rest_length[i - 1], 1.0 / rods.rest_length[i]
    axial = ea * (span_length(chord, le, lf) / rest - 1.0 - rods.rest_stretch[i, 0])
    w = cross(te, tf)
    cosine = dot(te, tf)
    root, slope = eased(i, cosine, rods)
    difference = le * re - lf * rf
    uneven = root * ea * rods.evenness[i] * (root * difference - rods.rest_stretch[i, 1])
    across_e = _geometric(axial / 6.0 + uneven * re, exact) * ie
    across_f = _geometric(axial / 6.0 - uneven * rf, exact) * jf
    across_s = _geometric(axial / 3.0, exact) / chord
    ue = combine(1.0 / 6.0, te, 1.0 / 3.0, ts)
    uf = combine(1.0 / 6.0, tf, 1.0 / 3.0, ts)

    # The unevenness changes with the edges' lengths and with the cosine between them, whose slopes are oe and of.
    slide = root * root * ea * rods.evenness[i]
    turned = 0.5 * slope * difference
    opening = exact * uneven * turned
    oe, of = scale(ie, combine(1.0, tf, -cosine, te)), scale(jf, combine(1.0, te, -cosine, tf))
    mixed = slide * turned + 0.5 * exact * uneven * slope
    square = slide * turned * turned + 1.5 * opening * slope
    oxe, oxf = mixed * re - opening * ie, -mixed * rf - opening * jf
    oye, oyf = combine(oxe, te, square, oe), combine(oxf, tf, square, of)

    chi = 2.0 + cosine
    kb = scale(3.0 / chi, w)
    k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
    eb = rods.bend_stiffness[i] / rods.span[i]
    gj = rods.twist_stiffness[i] / rods.span[i]
    c1 = exact * eb * (k1 - rods.rest_curvature[i, 0])
    c2 = exact * eb * (k2 - rods.rest_curvature[i, 1])
    m = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i] - rods.rest_twist[i]
    c3 = exact * gj * m

    # Gauss-Newton part: slopes of kappa1, kappa2 and twist in e, f and the two angles.
    ae, af = curvature_slopes(k1, add(m2e, m2f), te, tf, chi, le, lf)
    be, bf = curvature_slopes(k2, scale(-1.0, add(m1e, m1f)), te, tf, chi, le, lf)
    ate, atf = -0.5 * dot(kb, m1e), -0.5 * dot(kb, m1f)
    bte, btf = -0.5 * dot(kb, m2e), -0.5 * dot(kb, m2f)
    # The twist's slopes are w / (1 + te . tf) over the length of e or f.
    tw = 1.0 / (1.0 + cosine)
    gw = gj * tw
    gww = gw * tw

    # Exact part: one director g for both curvatures; p is its derivative in its angle.
    ge = combine(c1, m2e, -c2, m1e)
    gf = combine(c1, m2f, -c2, m1f)
    pe = combine(-c1, m1e, -c2, m2e)
    pf = combine(-c1, m1f, -c2, m2f)
    gs = add(ge, gf)
    k = 0.5 * dot(kb, gs)
    kc = k / chi
    de, df = curvature_slopes(k, gs, te, tf, chi, le, lf)
    # Directions of the curvature's own change, for e and for f.
    ce = scale(ie / chi, combine(2.0, te, 1.0, tf))
    cf = scale(jf / chi, combine(1.0, te, 2.0, tf))
    # Twist's second derivatives have the form of the curvature's; both are products with w.
    ct = c3 * tw
    tt = combine(tw, te, tw, tf)
    third, quarter = 0.75 / chi, 0.5 * ct
    we = scale(ie * ie, add(combine(third, ge, -quarter, add(te, tt)), scale(0.5 * gww, w)))
    wf = scale(jf * jf, add(combine(third, gf, -quarter, add(tf, tt)), scale(0.5 * gww, w)))
    ef = ie * jf
    wm = combine(ef * gww, w, -ef * ct, tt)
    turn = scale(ef, combine(1.5 / chi, gs, -ct, te))

    oc = opening * cosine
    ce2, cf2 = (2.0 * kc + oc) * ie * ie, (2.0 * kc + oc) * jf * jf
    iso_e, iso_f, iso_m = across_e + across_s - ce2, across_f + across_s - cf2, across_s + (opening - kc) * ef
    ka = ea / rest
    xe = add(combine(ka / 6.0, ue, slide * re * re - across_e + ce2, te), scale(oxe, oe))
    xf = add(combine(ka / 6.0, uf, slide * rf * rf - across_f + cf2, tf), scale(oxf, of))
    xm = add(combine(ka / 6.0, ue, -slide * re * rf - (2.0 * kc + oc) * ef, te), scale(oxf, oe))
    ye = combine(ka / 3.0, ue, -across_s, ts)
    yf = combine(ka / 3.0, uf, -across_s, ts)
    sae, sbe = scale(eb, ae), scale(eb, be)
    saf, sbf = scale(eb, af), scale(eb, bf)

    # Position-angle terms: rows are e or f, the column is the angle of e or of f.
    se, sf = 0.5 * dot(kb, pe), 0.5 * dot(kb, pf)
    pc = 1.5 / chi
    xee = add(combine(ate, sae, bte, sbe), combine(-se, ce, pc * ie, cross(tf, pe)))
    xef = add(combine(atf, sae, btf, sbe), combine(-sf, ce, pc * ie, cross(tf, pf)))
    xfe = add(combine(ate, saf, bte, sbf), combine(-se, cf, -pc * jf, cross(te, pe)))
    xff = add(combine(atf, saf, btf, sbf), combine(-sf, cf, -pc * jf, cross(te, pf)))
    xee, xef = combine(1.0, xee, -gw * ie, w), combine(1.0, xef, gw * ie, w)
    xfe, xff = combine(1.0, xfe, -gw * jf, w), combine(1.0, xff, gw * jf, w)

    dp, di, dn = pattern.diagonal[i - 1], pattern.diagonal[i], pattern.diagonal[i + 1]
    bi, bn, b2 = pattern.below[i], pattern.below[i + 1], pattern.below2[i + 1]
    for r in range(3):
        x, y = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            # Rows of f and columns of e; its transpose is the other.
            hfe = saf[r] * ae[c] + sbf[r] * be[c] + tf[r] * xm[c] + of[r] * oye[c] + ts[r] * ye[c]
            hfe += wm[r] * w[c] - cf[r] * de[c] - df[r] * ce[c]
            if r == c:
                hfe += iso_m
            # The cross matrix of `turn`.
            elif c == x:
                hfe -= turn[y]
            else:
                hfe += turn[x]
            blocks[di, r, c] -= hfe
            blocks[di, c, r] -= hfe
            blocks[bi, r, c] += hfe
            blocks[bn, r, c] += hfe
            blocks[b2, r, c] -= hfe
        for c in range(r + 1):
            hee = sae[r] * ae[c] + sbe[r] * be[c] + te[r] * xe[c] + oe[r] * oye[c] + ts[r] * ye[c]
            hee += w[r] * we[c] + we[r] * w[c] - ce[r] * de[c] - de[r] * ce[c]
            hff = saf[r] * af[c] + sbf[r] * bf[c] + tf[r] * xf[c] + of[r] * oyf[c] + ts[r] * yf[c]
            hff += w[r] * wf[c] + wf[r] * w[c] - cf[r] * df[c] - df[r] * cf[c]
            if r == c:
                hee += iso_e
                hff += iso_f
            else:
                blocks[dp, c, r] += hee
                blocks[di, c, r] += hee + hff
                blocks[dn, c, r] += hff
                blocks[bi, c, r] -= hee
                blocks[bn, c, r] -= hff
            blocks[dp, r, c] += hee
            blocks[di, r, c] += hee + hff
            blocks[dn, r, c] += hff
            blocks[bi, r, c] -= hee
            blocks[bn, r, c] -= hff
        blocks[dp, r, 3] -= xee[r]
        blocks[dp, 3, r] -= xee[r]
        blocks[di, r, 3] += xef[r] - xff[r]
        blocks[di, 3, r] += xef[r] - xff[r]
        blocks[bi, r, 3] += xee[r] - xfe[r]
        blocks[bi, 3, r] -= xef[r]
        blocks[b2, r, 3] += xfe[r]
        blocks[bn, r, 3] += xff[r]
    blocks[dp, 3, 3] += eb * (ate * ate + bte * bte) + gj - 0.5 * dot(kb, ge)
    blocks[di, 3, 3] += eb * (atf * atf + btf * btf) + gj - 0.5 * dot(kb, gf)
    blocks[bi, 3, 3] += eb * (ate * atf + bte * btf) - gj

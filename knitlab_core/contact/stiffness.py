"""Hessian of contact and friction, as 4 x 4 node blocks.

Pairs of one span pair share six nodes: what they add is summed first and scattered once.
"""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.forces import PairState
from knitlab_core.contact.friction_law import friction_law
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.pairs import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.contact.slip import Placed, add_edge_curvatures, add_pull, fill_slope, turned_anchor
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, norm, row, scale, sub
from knitlab_core.sparse.blocks import Pattern


@inline_kernel
def _add_normal(
    r: Vector, d2: float, weight: float, law: ContactLaw, exact: float, w: FloatArray, ka: int, kb: int, acc: FloatArray
) -> None:
    """Add a pair's normal stiffness to the 21 node pairs of its span pair, six entries each."""
    d = np.sqrt(d2)
    _, f, k = pair_potential(law.distance - d, law)
    across = -exact * weight * f / d
    n = scale(1.0 / d, r)
    along = weight * k - across
    h = (
        along * n[0] * n[0] + across,
        along * n[1] * n[1] + across,
        along * n[2] * n[2] + across,
        along * n[1] * n[2],
        along * n[0] * n[2],
        along * n[0] * n[1],
    )
    at = 0
    for x in range(3):
        for y in range(x + 1):
            wa, wb = w[ka, x] * w[ka, y], w[kb, x] * w[kb, y]
            for e in range(6):
                acc[at, e] += wa * h[e]
                acc[at + 6, e] += wb * h[e]
            at += 1
    at = 12
    for x in range(3):
        for y in range(3):
            wab = w[kb, x] * w[ka, y]
            for e in range(6):
                acc[at, e] -= wab * h[e]
            at += 1


@inline_kernel
def _scatter(blocks: FloatArray, b: int, acc: FloatArray, k: int) -> None:
    blocks[b, 0, 0] += acc[k, 0]
    blocks[b, 1, 1] += acc[k, 1]
    blocks[b, 2, 2] += acc[k, 2]
    blocks[b, 1, 2] += acc[k, 3]
    blocks[b, 2, 1] += acc[k, 3]
    blocks[b, 0, 2] += acc[k, 4]
    blocks[b, 2, 0] += acc[k, 4]
    blocks[b, 0, 1] += acc[k, 5]
    blocks[b, 1, 0] += acc[k, 5]


@inline_kernel
def _own_block(i: int, x: int, y: int, pattern: Pattern) -> int:
    """Return the block of nodes i - 1 + x and i - 1 + y of span i, x >= y."""
    if x == y:
        return int(pattern.diagonal[i - 1 + x])
    if x == y + 1:
        return int(pattern.below[i - 1 + x])
    return int(pattern.below2[i - 1 + x])


@inline_kernel
def _scatter_normal(i: int, j: int, s: int, acc: FloatArray, pattern: Pattern, blocks: FloatArray) -> None:
    at = 0
    for x in range(3):
        for y in range(x + 1):
            _scatter(blocks, _own_block(i, x, y, pattern), acc, at)
            _scatter(blocks, _own_block(j, x, y, pattern), acc, at + 6)
            at += 1
    for n in range(9):
        _scatter(blocks, pattern.across[s, n], acc, 12 + n)


@inline_kernel
def add_square(factor: float, slope: FloatArray, square: FloatArray) -> None:
    """Add factor v v^T of the 24 numbers v in `slope` to the lower blocks of `square` (24, 24)."""
    for n in range(6):
        for r in range(4):
            f = factor * slope[4 * n + r]
            # Four columns at a time: vectors of the processor.
            for c in range(0, 4 * n + 4, 4):
                square[4 * n + r, c] += f * slope[c]
                square[4 * n + r, c + 1] += f * slope[c + 1]
                square[4 * n + r, c + 2] += f * slope[c + 2]
                square[4 * n + r, c + 3] += f * slope[c + 3]


@inline_kernel
def scatter_square(i: int, j: int, s: int, square: FloatArray, pattern: Pattern, blocks: FloatArray) -> None:
    """Add the lower blocks of `square` (24, 24) to those of spans i and j, which are pair s of the pattern."""
    for x in range(3):
        for y in range(3):
            b = pattern.across[s, 3 * x + y]
            for r in range(4):
                for c in range(4):
                    blocks[b, r, c] += square[12 + 4 * x + r, 4 * y + c]
            if y > x:
                continue
            on_a, on_b = _own_block(i, x, y, pattern), _own_block(j, x, y, pattern)
            for r in range(4):
                for c in range(4):
                    blocks[on_a, r, c] += square[4 * x + r, 4 * y + c]
                    blocks[on_b, r, c] += square[12 + 4 * x + r, 12 + 4 * y + c]


@kernel
def contact_hessian(
    points: FloatArray,
    candidates: Candidates,
    samples: Samples,
    law: ContactLaw,
    exact: float,
    pattern: Pattern,
    blocks: FloatArray,
) -> None:
    """Add the Hessian of normal contact to the node blocks.

    Parameters
    ----------
    points : (N m, 3) array
        Samples in the present configuration.
    candidates, samples, law
        The pairs, the samples, and the contact law.
    exact : float
        Weight of the geometric part: 0 is Gauss-Newton.
    pattern : Pattern
        Where the blocks of a span's own nodes and of span pairs are stored.
    blocks : (B, 4, 4) array
        Block (i, j), i >= j.
    """
    w = samples.weights
    m = w.shape[0]
    acc = np.zeros((21, 6))
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        pressed = False
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d2 = dot(r, r)
            if d2 >= law.reach * law.reach:
                continue
            if not pressed:
                acc[:] = 0.0
                pressed = True
            _add_normal(r, d2, weight, law, exact, w, a - i * m, b - j * m, acc)
        if pressed:
            _scatter_normal(i, j, s, acc, pattern, blocks)


@kernel
def friction_hessian(
    placed: Placed,
    candidates: Candidates,
    samples: Samples,
    law: ContactLaw,
    exact: float,
    state: PairState,
    pattern: Pattern,
    blocks: FloatArray,
) -> None:
    """Add the Hessian of friction at lagged loads to the node blocks.

    Parameters
    ----------
    placed : Placed
        Samples and edges in the present configuration.
    candidates, samples, law, state
        The pairs, the samples, the contact law and the pairs' friction state.
    exact : float
        Weight of the second derivatives of slip: 0 is Gauss-Newton.
    pattern : Pattern
        Where the blocks of a span's own nodes and of span pairs are stored.
    blocks : (B, 4, 4) array
        Block (i, j), i >= j.
    """
    w, points = samples.weights, placed.points
    m = w.shape[0]
    square, sums, moments = np.zeros((24, 24)), np.zeros((6, 4)), np.zeros((4, 3, 3))
    across, along = np.zeros(24), np.zeros(24)
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        rubbed = False
        for p in range(candidates.start[s], candidates.start[s + 1]):
            if state.load[p] == 0.0:
                continue
            if not rubbed:
                square[:] = 0.0
                moments[:] = 0.0
                rubbed = True
            a, b = candidates.a[p], candidates.b[p]
            ka, kb = a - i * m, b - j * m
            anchor, n = row(state.anchor, p), row(state.normal, p)
            on_a, on_b = turned_anchor(i, ka, m, placed, anchor), turned_anchor(j, kb, m, placed, anchor)
            u = sub(sub(row(points, a), row(points, b)), add(add(on_a[0], on_a[1]), add(on_b[0], on_b[1])))
            u = combine(1.0, u, -dot(u, n), n)
            size = norm(u)
            _, over, along_it = friction_law(size, law.slip)
            factor = law.friction * state.load[p] * over
            # A pair that slides resists only across its way; one that sticks resists both ways.
            e = scale(1.0 / size, u) if size > 1e-12 else _any_across(n)
            fill_slope(cross(n, e), 1.0, i, ka, w, placed, on_a, across, 0)
            fill_slope(cross(n, e), -1.0, j, kb, w, placed, on_b, across, 12)
            if along_it > 0.0:
                fill_slope(e, 1.0, i, ka, w, placed, on_a, along, 0)
                fill_slope(e, -1.0, j, kb, w, placed, on_b, along, 12)
                add_square(law.friction * state.load[p] * along_it, along, square)
            add_square(factor, across, square)
            if exact > 0.0:
                add_pull(scale(exact * factor, u), ka, kb, w, anchor, sums, moments)
        if rubbed:
            if exact > 0.0:
                add_edge_curvatures(i, j, placed, moments, square)
            scatter_square(i, j, s, square, pattern, blocks)


@inline_kernel
def _any_across(n: Vector) -> Vector:
    """Return a unit vector across n."""
    a = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    return scale(1.0 / norm(a), a)

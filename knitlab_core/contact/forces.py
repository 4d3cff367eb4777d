"""Contact and friction between samples: energy, forces, Hessian.

Friction is Coulomb's with memory: a pair carries the elastic slip it had at the
last equilibrium; with the normal load and direction lagged, its potential is
mu load Huber(|carried + slip|; eps), a spring up to eps and mu load beyond it.
"""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.neighbours import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.blocks import Pattern
from knitlab_core.rods.vectors import Vector, add, combine, dot, norm, row, scale, sub


class PairState(NamedTuple):
    """What friction knows of every candidate pair.

    `carried`: (P, 3) elastic slip at the last equilibrium; `start_load`: (P,)
    normal force there; `load`: (P,) lagged normal force; `normal`: (P, 3)
    lagged direction from b to a.
    """

    carried: FloatArray
    start_load: FloatArray
    load: FloatArray
    normal: FloatArray

    @classmethod
    def zeros(cls, pairs: int) -> "PairState":
        """Allocate the state of pairs that have never touched."""
        return cls(np.zeros((pairs, 3)), np.zeros(pairs), np.zeros(pairs), np.zeros((pairs, 3)))


@inline_kernel
def _tangential(v: Vector, n: Vector) -> Vector:
    return combine(1.0, v, -dot(v, n), n)


@inline_kernel
def elastic_slip(p: int, a: int, b: int, points: FloatArray, base: FloatArray, state: PairState) -> Vector:
    """Carried slip plus the slip since the last equilibrium, across the lagged normal."""
    moved = sub(sub(row(points, a), row(points, b)), sub(row(base, a), row(base, b)))
    return _tangential(add(row(state.carried, p), moved), row(state.normal, p))


@kernel
def lag(points: FloatArray, candidates: Candidates, lengths: FloatArray, law: ContactLaw, state: PairState) -> int:
    """Take normal loads and directions of the present configuration into `state`; count contacts."""
    m = points.shape[0] // lengths.size
    contacts = 0
    for p in range(candidates.a.size):
        a, b = candidates.a[p], candidates.b[p]
        r = sub(row(points, a), row(points, b))
        d2 = dot(r, r)
        state.load[p] = 0.0
        if d2 >= law.reach * law.reach:
            continue
        d = np.sqrt(d2)
        _, force, _ = pair_potential(law.distance - d, law)
        state.load[p] = force * lengths[a // m] * lengths[b // m]
        for c in range(3):
            state.normal[p, c] = r[c] / d
        contacts += 1
    return contacts


@kernel
def contact_energy(
    points: FloatArray, base: FloatArray, candidates: Candidates, lengths: FloatArray, law: ContactLaw, state: PairState
) -> tuple[float, float]:
    """Return normal and frictional energy [E r^3]; infinite where cores overlap."""
    m = points.shape[0] // lengths.size
    normal, friction = 0.0, 0.0
    for p in range(candidates.a.size):
        a, b = candidates.a[p], candidates.b[p]
        r = sub(row(points, a), row(points, b))
        d2 = dot(r, r)
        if d2 < law.reach * law.reach:
            overlap = law.distance - np.sqrt(d2)
            if overlap >= law.overlap_limit:
                return np.inf, np.inf
            energy, _, _ = pair_potential(overlap, law)
            normal += energy * lengths[a // m] * lengths[b // m]
        if law.friction > 0.0 and state.load[p] > 0.0:
            s = norm(elastic_slip(p, a, b, points, base, state))
            huber = 0.5 * s * s / law.slip if s < law.slip else s - 0.5 * law.slip
            friction += law.friction * state.load[p] * huber
    return normal, friction


@inline_kernel
def _friction_force(
    p: int, a: int, b: int, points: FloatArray, base: FloatArray, law: ContactLaw, state: PairState
) -> Vector:
    """Return the gradient of a pair's friction potential in the relative position."""
    u = elastic_slip(p, a, b, points, base, state)
    s = norm(u)
    return scale(law.friction * state.load[p] / max(s, law.slip), u)


@kernel
def contact_gradient(
    points: FloatArray,
    base: FloatArray,
    candidates: Candidates,
    samples: Samples,
    law: ContactLaw,
    state: PairState,
    gradient: FloatArray,
) -> float:
    """Add contact and friction forces to `gradient` (N, 4) [E r^2]; return the sum of loads."""
    w = samples.weights
    m = w.shape[0]
    total = 0.0
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d2 = dot(r, r)
            force = (0.0, 0.0, 0.0)
            if d2 < law.reach * law.reach:
                d = np.sqrt(d2)
                _, f, _ = pair_potential(law.distance - d, law)
                total += f * weight
                force = scale(-f * weight / d, r)
            elif state.load[p] == 0.0:
                continue
            if law.friction > 0.0 and state.load[p] > 0.0:
                force = add(force, _friction_force(p, a, b, points, base, law, state))
            ka, kb = a - i * m, b - j * m
            for n in range(3):
                for c in range(3):
                    gradient[i - 1 + n, c] += w[ka, n] * force[c]
                    gradient[j - 1 + n, c] -= w[kb, n] * force[c]
    return total


@inline_kernel
def _stiffness(
    p: int,
    a: int,
    b: int,
    points: FloatArray,
    base: FloatArray,
    weight: float,
    law: ContactLaw,
    exact: float,
    state: PairState,
) -> tuple[float, float, float, float, float, float]:
    """Return the six entries (xx, yy, zz, yz, xz, xy) of a pair's 3 x 3 Hessian."""
    r = sub(row(points, a), row(points, b))
    d2 = dot(r, r)
    xx, yy, zz, yz, xz, xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if d2 < law.reach * law.reach:
        d = np.sqrt(d2)
        _, f, k = pair_potential(law.distance - d, law)
        across = -exact * weight * f / d
        n = scale(1.0 / d, r)
        along = weight * k - across
        xx = along * n[0] * n[0] + across
        yy = along * n[1] * n[1] + across
        zz = along * n[2] * n[2] + across
        yz, xz, xy = along * n[1] * n[2], along * n[0] * n[2], along * n[0] * n[1]
    if law.friction > 0.0 and state.load[p] > 0.0:
        u = elastic_slip(p, a, b, points, base, state)
        s = norm(u)
        n = row(state.normal, p)
        g = law.friction * state.load[p] / max(s, law.slip)
        xx += g * (1.0 - n[0] * n[0])
        yy += g * (1.0 - n[1] * n[1])
        zz += g * (1.0 - n[2] * n[2])
        yz -= g * n[1] * n[2]
        xz -= g * n[0] * n[2]
        xy -= g * n[0] * n[1]
        if s > law.slip:
            u = scale(1.0 / s, u)
            xx -= g * u[0] * u[0]
            yy -= g * u[1] * u[1]
            zz -= g * u[2] * u[2]
            yz -= g * u[1] * u[2]
            xz -= g * u[0] * u[2]
            xy -= g * u[0] * u[1]
    return xx, yy, zz, yz, xz, xy


@inline_kernel
def _scatter(blocks: FloatArray, b: int, s: float, acc: FloatArray, k: int) -> None:
    xx, yy, zz = s * acc[k, 0], s * acc[k, 1], s * acc[k, 2]
    yz, xz, xy = s * acc[k, 3], s * acc[k, 4], s * acc[k, 5]
    blocks[b, 0, 0] += xx
    blocks[b, 1, 1] += yy
    blocks[b, 2, 2] += zz
    blocks[b, 1, 2] += yz
    blocks[b, 2, 1] += yz
    blocks[b, 0, 2] += xz
    blocks[b, 2, 0] += xz
    blocks[b, 0, 1] += xy
    blocks[b, 1, 0] += xy


@inline_kernel
def _scatter_span(i: int, n: int, acc: FloatArray, pattern: Pattern, blocks: FloatArray) -> None:
    _scatter(blocks, pattern.diagonal[i - 1], 1.0, acc, n)
    _scatter(blocks, pattern.below[i], 1.0, acc, n + 1)
    _scatter(blocks, pattern.diagonal[i], 1.0, acc, n + 2)
    _scatter(blocks, pattern.below2[i + 1], 1.0, acc, n + 3)
    _scatter(blocks, pattern.below[i + 1], 1.0, acc, n + 4)
    _scatter(blocks, pattern.diagonal[i + 1], 1.0, acc, n + 5)


@inline_kernel
def gather_pair(
    acc: FloatArray, w: FloatArray, ka: int, kb: int, h: tuple[float, float, float, float, float, float]
) -> None:
    """Add a pair's six entries to the 21 node pairs of its span pair, with the nodes' weights."""
    n = 0
    for r in range(3):
        for c in range(r + 1):
            wa, wb = w[ka, r] * w[ka, c], w[kb, r] * w[kb, c]
            for e in range(6):
                acc[n, e] += wa * h[e]
                acc[n + 6, e] += wb * h[e]
            n += 1
    n = 12
    for r in range(3):
        for c in range(3):
            wab = w[kb, r] * w[ka, c]
            for e in range(6):
                acc[n, e] += wab * h[e]
            n += 1


@inline_kernel
def scatter_pair(acc: FloatArray, i: int, j: int, s: int, pattern: Pattern, blocks: FloatArray) -> None:
    """Add what `gather_pair` gathered to the blocks of spans i, j and of span pair s."""
    _scatter_span(i, 0, acc, pattern, blocks)
    _scatter_span(j, 6, acc, pattern, blocks)
    for n in range(9):
        _scatter(blocks, pattern.across[s, n], -1.0, acc, 12 + n)


@kernel
def contact_hessian(
    points: FloatArray,
    base: FloatArray,
    candidates: Candidates,
    samples: Samples,
    law: ContactLaw,
    exact: float,
    state: PairState,
    pattern: Pattern,
    blocks: FloatArray,
) -> None:
    """Add the Hessian of contact and friction to the node blocks.

    Parameters
    ----------
    points, base : (N m, 3) arrays
        Sample positions now and at the last equilibrium [r].
    candidates, samples, law, state
        The pairs, the samples, the contact law and the pairs' friction state.
    exact : float
        Weight of the (negative) geometric part: 0 is Gauss-Newton.
    pattern : Pattern
        Where the blocks of a span's own nodes and of span pairs are stored.
    blocks : (B, 4, 4) array
        Block (i, j), i >= j.

    Notes
    -----
    Pairs of one span pair share six nodes: their 3 x 3 matrices are summed with
    the nodes' weights first (6 + 9 + 6 node pairs) and scattered once.
    """
    w = samples.weights
    m = w.shape[0]
    acc = np.zeros((21, 6))
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        touched = False
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            if state.load[p] == 0.0 and dot(r, r) >= law.reach * law.reach:
                continue
            if not touched:
                acc[:] = 0.0
                touched = True
            h = _stiffness(p, a, b, points, base, weight, law, exact, state)
            ka, kb = a - i * m, b - j * m
            gather_pair(acc, w, ka, kb, h)
        if touched:
            scatter_pair(acc, i, j, s, pattern, blocks)

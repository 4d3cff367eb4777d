"""Contact and friction between samples: energy and forces.

Friction is Coulomb's with memory: a pair carries the elastic slip it had at the last equilibrium; with the
normal load and direction lagged, its potential is mu load Huber(|slip|; eps), a spring up to eps and mu load
beyond it.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.neighbours import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.contact.slip import Placed, add_slip_slope, opened
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, combine, dot, norm, row, scale, sub


class PairState(NamedTuple):
    """What friction knows of every candidate pair.

    `anchor`: (P, 3) line between the centrelines at the last equilibrium less the elastic slip there;
    `start_slip`: (P, 3) that slip; `start_load`: (P,) normal force there; `load`: (P,) lagged normal force;
    `normal`: (P, 3) lagged direction from b to a; `slope`: (P, 6, 4) slope of the slip along friction's pull in the
    unknowns of the two spans' nodes, set where there is a load whenever forces are computed.
    """

    anchor: FloatArray
    start_slip: FloatArray
    start_load: FloatArray
    load: FloatArray
    normal: FloatArray
    slope: FloatArray

    @classmethod
    def zeros(cls, pairs: int) -> Self:
        """Allocate the state of pairs that have never touched."""
        return cls(
            anchor=np.zeros((pairs, 3)),
            start_slip=np.zeros((pairs, 3)),
            start_load=np.zeros(pairs),
            load=np.zeros(pairs),
            normal=np.zeros((pairs, 3)),
            slope=np.empty((pairs, 6, 4)),
        )


@inline_kernel
def elastic_slip(p: int, a: int, b: int, m: int, placed: Placed, state: PairState) -> Vector:
    """Return a pair's elastic slip: what has opened since the anchor, across the lagged normal."""
    u = opened(a, b, m, placed, row(state.anchor, p))
    n = row(state.normal, p)
    return combine(1.0, u, -dot(u, n), n)


@kernel
def lag(placed: Placed, candidates: Candidates, lengths: FloatArray, law: ContactLaw, state: PairState) -> int:
    """Take normal loads and directions of the present configuration into `state`; count contacts."""
    points = placed.points
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
    placed: Placed, candidates: Candidates, lengths: FloatArray, law: ContactLaw, state: PairState
) -> tuple[float, float]:
    """Return normal and frictional energy [E r^3]; infinite where cores overlap."""
    points = placed.points
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
            s = norm(elastic_slip(p, a, b, m, placed, state))
            huber = 0.5 * s * s / law.slip if s < law.slip else s - 0.5 * law.slip
            friction += law.friction * state.load[p] * huber
    return normal, friction


@inline_kernel
def add_pair(factor: float, slope: FloatArray, i: int, j: int, out: FloatArray) -> None:
    """Add factor times a pair's slope to the rows of its six nodes; the last angle of a span has no part in it."""
    for n in range(3):
        for c in range(4):
            out[i - 1 + n, c] += factor * slope[n, c]
            out[j - 1 + n, c] += factor * slope[n + 3, c]


@kernel
def contact_gradient(
    placed: Placed, candidates: Candidates, samples: Samples, law: ContactLaw, state: PairState, gradient: FloatArray
) -> None:
    """Add contact and friction forces to `gradient` (N, 4) [E r^2, E r^3]."""
    w, points = samples.weights, placed.points
    m = w.shape[0]
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            ka, kb = a - i * m, b - j * m
            r = sub(row(points, a), row(points, b))
            d2 = dot(r, r)
            if d2 < law.reach * law.reach:
                d = np.sqrt(d2)
                _, f, _ = pair_potential(law.distance - d, law)
                force = scale(-f * weight / d, r)
                for n in range(3):
                    for c in range(3):
                        gradient[i - 1 + n, c] += w[ka, n] * force[c]
                        gradient[j - 1 + n, c] -= w[kb, n] * force[c]
            if law.friction > 0.0 and state.load[p] > 0.0:
                u = elastic_slip(p, a, b, m, placed, state)
                pull = scale(1.0 / max(norm(u), law.slip), u)
                slope, anchor = state.slope[p], row(state.anchor, p)
                for n in range(6):
                    for c in range(4):
                        slope[n, c] = 0.0
                add_slip_slope(pull, 1.0, i, ka, w, placed, anchor, slope, 0)
                add_slip_slope(pull, -1.0, j, kb, w, placed, anchor, slope, 3)
                add_pair(law.friction * state.load[p], slope, i, j, gradient)

"""Contact and friction between samples: energy and forces.

Friction is Coulomb's with memory: a pair carries the elastic slip it had at the last equilibrium; with the
normal load and direction lagged, its potential is mu load Huber(|slip|; eps), a spring up to eps and mu load
beyond it.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.friction_law import friction_law
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.pairs import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.contact.slip import Placed, add_edge_pulls, add_pull, opened
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, combine, dot, norm, row, scale, sub


class PairState(NamedTuple):
    """State of friction of pairs.

    `anchor`: (P, 3) line between the centrelines at the last equilibrium less the elastic slip there;
    `start_slip`: (P, 3) that slip; `start_load`: (P,) normal force there; `load`: (P,) lagged normal force;
    `normal`: (P, 3) lagged direction from b to a; `pull`: (P, 3) friction's share of its limit with its direction,
    set where there is a load whenever forces are computed.
    """

    anchor: FloatArray
    start_slip: FloatArray
    start_load: FloatArray
    load: FloatArray
    normal: FloatArray
    pull: FloatArray

    @classmethod
    def zeros(cls, pairs: int) -> Self:
        """Allocate the state of pairs that have never touched."""
        return cls(
            anchor=np.zeros((pairs, 3)),
            start_slip=np.zeros((pairs, 3)),
            start_load=np.zeros(pairs),
            load=np.zeros(pairs),
            normal=np.zeros((pairs, 3)),
            pull=np.zeros((pairs, 3)),
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
    contacts = 0
    for s in range(candidates.span_a.size):
        weight = lengths[candidates.span_a[s]] * lengths[candidates.span_b[s]]
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d2 = dot(r, r)
            state.load[p] = 0.0
            if d2 >= law.reach * law.reach:
                continue
            d = np.sqrt(d2)
            _, force, _ = pair_potential(law.distance - d, law)
            state.load[p] = force * weight
            for c in range(3):
                state.normal[p, c] = r[c] / d
            contacts += 1
    return contacts


@kernel
def contact_energy(points: FloatArray, candidates: Candidates, lengths: FloatArray, law: ContactLaw) -> float:
    """Return the energy of normal contact [E r^3]; infinite where cores overlap."""
    energy = 0.0
    for s in range(candidates.span_a.size):
        weight = lengths[candidates.span_a[s]] * lengths[candidates.span_b[s]]
        for p in range(candidates.start[s], candidates.start[s + 1]):
            r = sub(row(points, candidates.a[p]), row(points, candidates.b[p]))
            d2 = dot(r, r)
            if d2 >= law.reach * law.reach:
                continue
            overlap = law.distance - np.sqrt(d2)
            if overlap >= law.overlap_limit:
                return np.inf
            psi, _, _ = pair_potential(overlap, law)
            energy += psi * weight
    return energy


@kernel
def friction_energy(placed: Placed, candidates: Candidates, law: ContactLaw, state: PairState) -> float:
    """Return the energy that friction stores at lagged loads [E r^3]."""
    m = placed.points.shape[0] // placed.length.size
    energy = 0.0
    for p in range(candidates.a.size):
        if state.load[p] > 0.0:
            s = norm(elastic_slip(p, candidates.a[p], candidates.b[p], m, placed, state))
            f, _, _ = friction_law(s, law.slip)
            energy += law.friction * state.load[p] * f
    return energy


@inline_kernel
def add_pair(factor: float, slope: FloatArray, i: int, j: int, out: FloatArray) -> None:
    """Add factor times a pair's slope to the rows of its six nodes; the last angle of a span has no part in it."""
    for n in range(3):
        for c in range(4):
            out[i - 1 + n, c] += factor * slope[n, c]
            out[j - 1 + n, c] += factor * slope[n + 3, c]


@kernel
def contact_gradient(
    points: FloatArray, candidates: Candidates, samples: Samples, law: ContactLaw, gradient: FloatArray
) -> None:
    """Add the forces of normal contact to `gradient` (N, 4) [E r^2, E r^3]."""
    w = samples.weights
    m = w.shape[0]
    sums = np.zeros((6, 3))
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        sums[:] = 0.0
        for p in range(candidates.start[s], candidates.start[s + 1]):
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d2 = dot(r, r)
            if d2 >= law.reach * law.reach:
                continue
            d = np.sqrt(d2)
            _, f, _ = pair_potential(law.distance - d, law)
            force = scale(-f * weight / d, r)
            ka, kb = a - i * m, b - j * m
            for n in range(3):
                for c in range(3):
                    sums[n, c] += w[ka, n] * force[c]
                    sums[n + 3, c] -= w[kb, n] * force[c]
        for n in range(3):
            for c in range(3):
                gradient[i - 1 + n, c] += sums[n, c]
                gradient[j - 1 + n, c] += sums[n + 3, c]


@kernel
def friction_gradient(
    placed: Placed, candidates: Candidates, samples: Samples, law: ContactLaw, state: PairState, gradient: FloatArray
) -> None:
    """Add the forces of friction at lagged loads to `gradient` (N, 4) [E r^2, E r^3]; keep the pulls."""
    w = samples.weights
    m = w.shape[0]
    sums, moments = np.zeros((6, 4)), np.zeros((4, 3, 3))
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        sums[:] = 0.0
        moments[:] = 0.0
        for p in range(candidates.start[s], candidates.start[s + 1]):
            if state.load[p] == 0.0:
                continue
            a, b = candidates.a[p], candidates.b[p]
            u = elastic_slip(p, a, b, m, placed, state)
            _, over, _ = friction_law(norm(u), law.slip)
            pull = scale(over, u)
            for c in range(3):
                state.pull[p, c] = pull[c]
            force = scale(law.friction * state.load[p], pull)
            add_pull(force, a - i * m, b - j * m, w, row(state.anchor, p), sums, moments)
        add_edge_pulls(i, j, placed, moments, sums)
        add_pair(1.0, sums, i, j, gradient)

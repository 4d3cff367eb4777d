"""What friction remembers between equilibria, and the coupling of its limit to the normal load."""

from typing import Final, NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.forces import PairState, add_pair, elastic_slip
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.pairs import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.contact.slip import Placed, add_edge_pulls, add_pull, carried_along, opened
from knitlab_core.jit import kernel
from knitlab_core.rods.vectors import combine, dot, norm, row, scale, sub


class Memory(NamedTuple):
    """Every pair that was loaded at the last equilibrium, sorted by key.

    `key`: (K,) a times the number of samples plus b; `slip`: (K, 3) elastic
    slip; `load`: (K,) normal force; `normal`: (K, 3) direction from b to a;
    `moved`: (K, 3) slip in the step that led there.
    """

    key: IndexArray
    slip: FloatArray
    load: FloatArray
    normal: FloatArray
    moved: FloatArray

    @classmethod
    def empty(cls) -> Self:
        """Remember nothing: no pair has touched yet."""
        return cls(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)))


class Lead(NamedTuple):
    """Extrapolation of slip from the mean of a step to its end, where friction acts.

    Friction points along the slip rate at the end of a step. The backward Euler rule takes the slip u of the whole
    step for it, an error of first order. With the slip u' of the step before, `ratio` times shorter, the rate at the
    end of a step of unit length is u + share (u - ratio u'), share = ratio / (1 + ratio): second order (as BDF2).
    """

    share: float
    ratio: float


STEADY: Final = Lead(0.0, 0.0)
"""No extrapolation: the first step in a direction, or one after a kink."""


@kernel
def _recall(memory: Memory, candidates: Candidates, base: FloatArray, lead: Lead, state: PairState) -> None:
    samples = base.shape[0]
    for p in range(candidates.a.size):
        a, b = candidates.a[p], candidates.b[p]
        for c in range(3):
            state.anchor[p, c] = base[a, c] - base[b, c]
    known = memory.key.size
    for s in range(candidates.span_a.size):
        # Within a span pair keys rise, as they do in the memory: one pass along both.
        first, last = candidates.start[s], candidates.start[s + 1]
        k = np.searchsorted(memory.key, candidates.a[first] * samples + candidates.b[first])
        for p in range(first, last):
            key = candidates.a[p] * samples + candidates.b[p]
            while k < known and memory.key[k] < key:
                k += 1
            if k == known:
                break
            if memory.key[k] == key:
                for c in range(3):
                    ahead = memory.slip[k, c] - lead.share * lead.ratio * memory.moved[k, c]
                    state.anchor[p, c] -= ahead / (1.0 + lead.share)
                    state.start_slip[p, c] = memory.slip[k, c]
                    state.normal[p, c] = memory.normal[k, c]
                state.load[p] = memory.load[k]
                state.start_load[p] = memory.load[k]


def recall(memory: Memory, candidates: Candidates, base: FloatArray, lead: Lead = STEADY) -> PairState:
    """Return the state of every candidate pair at the last equilibrium; new pairs start without slip.

    Parameters
    ----------
    memory : Memory
        The pairs loaded there.
    candidates : Candidates
        The pairs now.
    base : (N m, 3) array
        Sample positions at the last equilibrium [r].
    lead : Lead
        Extrapolation of slip in the step.

    Notes
    -----
    A pair's slip is measured from an anchor. With the extrapolation in the anchor, and the limit of elastic slip
    divided by 1 + share (`step_law`), forces and their derivatives are those of the backward Euler rule.
    """
    state = PairState.zeros(candidates.a.size)
    _recall(memory, candidates, base, lead, state)
    return state


def step_law(law: ContactLaw, lead: Lead) -> ContactLaw:
    """Return the law of a step in which slip is extrapolated; see `recall`."""
    return law._replace(slip=law.slip / (1.0 + lead.share))


@kernel
def _settle(
    placed: Placed,
    base: FloatArray,
    candidates: Candidates,
    law: ContactLaw,
    lead: Lead,
    state: PairState,
    slip: FloatArray,
    across: FloatArray,
) -> float:
    """Fill elastic slip and slip of the step (P, 3) at the new equilibrium; return the work against friction."""
    m = placed.points.shape[0] // placed.length.size
    work = 0.0
    for p in range(candidates.a.size):
        if state.load[p] == 0.0 and state.start_load[p] == 0.0:
            continue
        a, b = candidates.a[p], candidates.b[p]
        moved = opened(a, b, m, placed, sub(row(base, a), row(base, b)))
        # The slip carried from before, turned along with the strands.
        before = row(state.start_slip, p)
        before = combine(
            0.5, carried_along(a // m, a % m, m, placed, before), 0.5, carried_along(b // m, b % m, m, placed, before)
        )
        force = scale(law.friction * state.start_load[p] / law.slip, before)
        if state.load[p] > 0.0:
            u = scale(1.0 + lead.share, elastic_slip(p, a, b, m, placed, state))
            u = scale(min(1.0, law.slip / max(norm(u), 1e-300)), u)
            slip[p, 0], slip[p, 1], slip[p, 2] = u
            force = combine(1.0, force, law.friction * state.load[p] / law.slip, u)
            n = row(state.normal, p)
            across[p, 0], across[p, 1], across[p, 2] = combine(1.0, moved, -dot(moved, n), n)
        work += 0.5 * dot(force, moved)
    return work


def settle(
    placed: Placed, base: FloatArray, candidates: Candidates, law: ContactLaw, state: PairState, lead: Lead = STEADY
) -> tuple[Memory, float]:
    """Accept an equilibrium: clip the elastic slip to its limit and remember the loaded pairs.

    Parameters
    ----------
    placed : Placed
        Samples and edges now.
    base : (N m, 3) array
        Sample positions at the last equilibrium [r].
    candidates, law, state
        The pairs, the contact law, and the pairs' state with loads of the present configuration.
    lead : Lead
        Extrapolation of slip with which they were recalled.

    Returns
    -------
    Memory, float
        What to carry on, and the work done against friction since the last
        equilibrium (trapezium rule) [E r^3].
    """
    slip, moved = np.zeros_like(state.anchor), np.zeros_like(state.anchor)
    work = _settle(placed, base, candidates, law, lead, state, slip, moved)
    loaded = np.flatnonzero(state.load > 0.0)
    key = candidates.a[loaded] * len(base) + candidates.b[loaded]
    loaded = loaded[np.argsort(key)]
    memory = Memory(np.sort(key), slip[loaded], state.load[loaded], state.normal[loaded], moved[loaded])
    return memory, float(work)


@kernel
def slip_change(before: Memory, after: Memory, ratio: float, limit: float) -> tuple[float, float]:
    """Return how much slip changed its rate between two steps (0 steady, 1 turned or stuck) and all loads [E r^2].

    It is the error of friction's forces where their direction is that of the mean slip of a step: the change of slip
    per unit of the fixtures' way, relative to slip itself or to the elastic limit, averaged over the normal loads of
    all pairs that touched at both equilibria. Where these carry only a part of all load, it counts less.

    Parameters
    ----------
    before, after : Memory
        At the ends of two steps, one after the other.
    ratio : float
        Length of the second step over that of the first.
    limit : float
        Elastic slip before sliding [r].
    """
    wrong, known, loads = 0.0, 0.0, 0.0
    k = 0
    for p in range(after.key.size):
        loads += after.load[p]
        while k < before.key.size and before.key[k] < after.key[p]:
            k += 1
        if k == before.key.size or before.key[k] != after.key[p]:
            continue
        expected, moved = scale(ratio, row(before.moved, k)), row(after.moved, p)
        size = max(norm(expected), norm(moved), limit)
        known += after.load[p]
        wrong += after.load[p] * min(1.0, norm(sub(moved, expected)) / size)
    return (wrong / np.sqrt(known * loads) if known > 0.0 else 0.0), loads


@kernel
def add_load_coupling(
    placed: Placed,
    candidates: Candidates,
    samples: Samples,
    law: ContactLaw,
    state: PairState,
    v: FloatArray,
    out: FloatArray,
) -> None:
    """Add to `out` (N, 4) how friction changes because a motion `v` (N, 4) changes the loads.

    The friction force mu load h grows with the load, which grows with overlap:
    its derivative -mu w psi'' h n^T is not symmetric and so not in the Hessian.
    Forces must have been computed in this configuration.
    """
    w, points = samples.weights, placed.points
    m = w.shape[0]
    sums, moments = np.zeros((6, 4)), np.zeros((4, 3, 3))
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        sums[:] = 0.0
        moments[:] = 0.0
        for p in range(candidates.start[s], candidates.start[s + 1]):
            if state.load[p] == 0.0:
                continue
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d = norm(r)
            if d >= law.reach:
                continue
            _, _, k = pair_potential(law.distance - d, law)
            ka, kb = a - i * m, b - j * m
            opening = 0.0
            for e in range(3):
                for c in range(3):
                    opening += r[c] * (w[ka, e] * v[i - 1 + e, c] - w[kb, e] * v[j - 1 + e, c])
            force = scale(-law.friction * weight * k * opening / d, row(state.pull, p))
            add_pull(force, ka, kb, w, row(state.anchor, p), sums, moments)
        add_edge_pulls(i, j, placed, moments, sums)
        add_pair(1.0, sums, i, j, out)

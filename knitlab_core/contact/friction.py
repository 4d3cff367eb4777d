"""What friction remembers between equilibria, and the coupling of its limit to the normal load."""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.forces import PairState, add_pair, elastic_slip
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.pairs import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.contact.slip import Placed, add_edge_pulls, add_pull, opened
from knitlab_core.jit import kernel
from knitlab_core.rods.vectors import combine, dot, norm, row, scale, sub


class Memory(NamedTuple):
    """Every pair that was loaded at the last equilibrium, sorted by key.

    `key`: (K,) a times the number of samples plus b; `slip`: (K, 3) elastic
    slip; `load`: (K,) normal force; `normal`: (K, 3) direction from b to a.
    """

    key: IndexArray
    slip: FloatArray
    load: FloatArray
    normal: FloatArray

    @classmethod
    def empty(cls) -> Self:
        """Remember nothing: no pair has touched yet."""
        return cls(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))


@kernel
def _recall(memory: Memory, candidates: Candidates, base: FloatArray, state: PairState) -> None:
    samples = base.shape[0]
    for p in range(candidates.a.size):
        a, b = candidates.a[p], candidates.b[p]
        for c in range(3):
            state.anchor[p, c] = base[a, c] - base[b, c]
    known = memory.key.size
    for s in range(candidates.span_a.size):
        # Within a span pair keys rise, as they do in the memory: one walk along both.
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
                    state.anchor[p, c] -= memory.slip[k, c]
                    state.normal[p, c] = memory.normal[k, c]
                state.load[p] = memory.load[k]
                state.start_load[p] = memory.load[k]


def recall(memory: Memory, candidates: Candidates, base: FloatArray) -> PairState:
    """Give every candidate pair what it had at the last equilibrium; new pairs start without slip.

    Parameters
    ----------
    memory : Memory
        The pairs loaded there.
    candidates : Candidates
        The pairs now.
    base : (N m, 3) array
        Sample positions at the last equilibrium [r].
    """
    state = PairState.zeros(candidates.a.size)
    _recall(memory, candidates, base, state)
    return state


@kernel
def _settle(
    placed: Placed, base: FloatArray, candidates: Candidates, law: ContactLaw, state: PairState, slip: FloatArray
) -> float:
    """Fill the elastic slip (P, 3) at the new equilibrium; return the work against friction."""
    m = placed.points.shape[0] // placed.length.size
    work = 0.0
    for p in range(candidates.a.size):
        if state.load[p] == 0.0 and state.start_load[p] == 0.0:
            continue
        a, b = candidates.a[p], candidates.b[p]
        moved = opened(a, b, m, placed, sub(row(base, a), row(base, b)))
        # The slip carried from before, turned along with the strands.
        before = sub(opened(a, b, m, placed, row(state.anchor, p)), moved)
        force = scale(law.friction * state.start_load[p] / law.slip, before)
        if state.load[p] > 0.0:
            u = elastic_slip(p, a, b, m, placed, state)
            u = scale(min(1.0, law.slip / max(norm(u), 1e-300)), u)
            slip[p, 0], slip[p, 1], slip[p, 2] = u
            force = combine(1.0, force, law.friction * state.load[p] / law.slip, u)
        work += 0.5 * dot(force, moved)
    return work


def settle(
    placed: Placed, base: FloatArray, candidates: Candidates, law: ContactLaw, state: PairState
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

    Returns
    -------
    Memory, float
        What to carry on, and the work done against friction since the last
        equilibrium (trapezium rule) [E r^3].
    """
    slip = np.zeros_like(state.anchor)
    work = _settle(placed, base, candidates, law, state, slip)
    loaded = np.flatnonzero(state.load > 0.0)
    key = candidates.a[loaded] * len(base) + candidates.b[loaded]
    loaded = loaded[np.argsort(key)]
    memory = Memory(np.sort(key), slip[loaded], state.load[loaded], state.normal[loaded])
    return memory, float(work)


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

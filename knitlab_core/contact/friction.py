"""What friction remembers between equilibria, and the coupling of its limit to the normal load."""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.forces import PairState, elastic_slip
from knitlab_core.contact.law import ContactLaw, pair_potential
from knitlab_core.contact.neighbours import Candidates
from knitlab_core.contact.samples import Samples
from knitlab_core.jit import kernel
from knitlab_core.rods.vectors import add, dot, norm, row, scale, sub


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


def recall(memory: Memory, candidates: Candidates, samples: int) -> PairState:
    """Give every candidate pair what it had at the last equilibrium; new pairs start at zero."""
    state = PairState.zeros(candidates.a.size)
    if memory.key.size:
        keys = candidates.a * samples + candidates.b
        place = np.minimum(np.searchsorted(memory.key, keys), memory.key.size - 1)
        known = memory.key[place] == keys
        place = place[known]
        state.carried[known] = memory.slip[place]
        state.load[known] = memory.load[place]
        state.start_load[known] = memory.load[place]
        state.normal[known] = memory.normal[place]
    return state


@kernel
def _settle(
    points: FloatArray,
    base: FloatArray,
    candidates: Candidates,
    law: ContactLaw,
    state: PairState,
    slip: FloatArray,
) -> float:
    """Fill the elastic slip (P, 3) at the new equilibrium; return the work against friction."""
    work = 0.0
    for p in range(candidates.a.size):
        start = scale(law.friction * state.start_load[p] / law.slip, row(state.carried, p))
        end = (0.0, 0.0, 0.0)
        if state.load[p] > 0.0:
            u = elastic_slip(p, candidates.a[p], candidates.b[p], points, base, state)
            u = scale(min(1.0, law.slip / max(norm(u), 1e-300)), u)
            slip[p, 0], slip[p, 1], slip[p, 2] = u
            end = scale(law.friction * state.load[p] / law.slip, u)
        elif state.start_load[p] == 0.0:
            continue
        a, b = candidates.a[p], candidates.b[p]
        moved = sub(sub(row(points, a), row(points, b)), sub(row(base, a), row(base, b)))
        work += 0.5 * dot(add(start, end), moved)
    return work


def settle(
    points: FloatArray,
    base: FloatArray,
    candidates: Candidates,
    law: ContactLaw,
    state: PairState,
) -> tuple[Memory, float]:
    """Accept an equilibrium: clip the elastic slip to its limit and remember the loaded pairs.

    Parameters
    ----------
    points, base : (N m, 3) arrays
        Sample positions now and at the last equilibrium [r].
    candidates, law, state
        The pairs, the contact law, and the pairs' state with loads of the present configuration.

    Returns
    -------
    Memory, float
        What to carry on, and the work done against friction since the last
        equilibrium (trapezium rule) [E r^3].
    """
    slip = np.zeros_like(state.carried)
    work = _settle(points, base, candidates, law, state, slip)
    loaded = np.flatnonzero(state.load > 0.0)
    key = candidates.a[loaded] * points.shape[0] + candidates.b[loaded]
    loaded = loaded[np.argsort(key)]
    memory = Memory(np.sort(key), slip[loaded], state.load[loaded], state.normal[loaded])
    return memory, float(work)


@kernel
def add_load_coupling(
    points: FloatArray,
    base: FloatArray,
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
    """
    w = samples.weights
    m = w.shape[0]
    for s in range(candidates.span_a.size):
        i, j = candidates.span_a[s], candidates.span_b[s]
        weight = samples.length[i] * samples.length[j]
        for p in range(candidates.start[s], candidates.start[s + 1]):
            if state.load[p] == 0.0:
                continue
            a, b = candidates.a[p], candidates.b[p]
            r = sub(row(points, a), row(points, b))
            d = norm(r)
            if d >= law.reach:
                continue
            _, _, k = pair_potential(law.distance - d, law)
            u = elastic_slip(p, a, b, points, base, state)
            ka, kb = a - i * m, b - j * m
            opening = 0.0
            for e in range(3):
                for c in range(3):
                    opening += r[c] * (w[ka, e] * v[i - 1 + e, c] - w[kb, e] * v[j - 1 + e, c])
            change = -law.friction * weight * k * opening / (d * max(norm(u), law.slip))
            for e in range(3):
                for c in range(3):
                    out[i - 1 + e, c] += w[ka, e] * change * u[c]
                    out[j - 1 + e, c] -= w[kb, e] * change * u[c]

"""Two disjoint parts of an elimination, which two threads may do at once, and what is left for one."""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.jit import kernel
from knitlab_core.sparse.supernodes import Factorisation

SPLIT_ABOVE = 1.2e7
"""Operations of a factorisation from which it is split: a planar knit of 6x6 loops (7e6) gains nothing."""

MOST_CUTS = 60
"""So many of the largest subtrees are cut at their roots in search of two even halves."""


class Split(NamedTuple):
    """Supernodes of the two halves and those left, each ascending.

    `own` are the places of the nodes of the second, `common` those of the rest.
    """

    first: IndexArray
    second: IndexArray
    rest: IndexArray
    own: IndexArray
    common: IndexArray

    @property
    def is_whole(self) -> bool:
        """Return whether nothing was split off."""
        return self.second.size == 0


@kernel
def _costs(plan: Factorisation, parent: IndexArray, cost: FloatArray, total: FloatArray) -> None:
    """Fill each supernode's parent, -1 for none, its operations, and those of its subtree."""
    supers = plan.first.size - 1
    for s in range(supers):
        width = 4.0 * (plan.first[s + 1] - plan.first[s])
        below = 4.0 * (plan.row_start[s + 1] - plan.row_start[s])
        parent[s] = plan.owner[plan.row_start[s]] if below > 0.0 else -1
        # The last term stands for what every panel costs however small.
        cost[s] = width * (width * width / 3.0 + width * below + below * below + 200.0)
        total[s] = cost[s]
    for s in range(supers):
        if parent[s] >= 0:
            total[parent[s]] += total[s]


@kernel
def _inherit(parent: IndexArray, owner: IndexArray) -> None:
    """Give every supernode without an owner (-1) that of its parent, 2 where that has none of the halves."""
    for s in range(parent.size - 1, -1, -1):
        if owner[s] < 0:
            owner[s] = owner[parent[s]] if parent[s] >= 0 else 2


def _halves(parent: IndexArray, cost: FloatArray, total: FloatArray) -> dict[int, int]:
    """Return the half, 0 or 1, that each of the subtrees with these roots goes to; all above them is left."""
    roots = [int(s) for s in np.flatnonzero(parent < 0)]
    left, least, best = 0.0, np.inf, dict[int, int]()
    for _ in range(MOST_CUTS):
        roots.sort(key=lambda s: (-total[s], s))
        work, halves = [0.0, 0.0], dict[int, int]()
        for s in roots:
            half = 0 if work[0] <= work[1] else 1
            work[half] += float(total[s])
            halves[s] = half
        if max(work) + left < least:
            least, best = max(work) + left, halves
        if not roots:
            break
        largest = roots.pop(0)
        left += float(cost[largest])
        roots += [int(s) for s in np.flatnonzero(parent == largest)]
    return best


def split(plan: Factorisation, operations: float) -> Split:
    """Part the supernodes into two halves that do not depend on each other and a rest that depends on both.

    Parameters
    ----------
    plan : Factorisation
        The panels.
    operations : float
        Additions and multiplications; below `SPLIT_ABOVE` all is left in the first part.
    """
    supers = plan.first.size - 1
    none = np.zeros(0, dtype=np.int64)
    if operations < SPLIT_ABOVE:
        return Split(np.arange(supers), none, none, none, none)
    parent, cost, total = np.empty(supers, np.int64), np.empty(supers), np.empty(supers)
    _costs(plan, parent, cost, total)
    owner = np.full(supers, -1)
    for root, half in _halves(parent, cost, total).items():
        owner[root] = half
    _inherit(parent, owner)
    first, second, rest = (np.flatnonzero(owner == k) for k in range(3))
    places = np.repeat(owner, np.diff(plan.first))
    return Split(first, second, rest, np.flatnonzero(places == 1), np.flatnonzero(places == 2))

"""Approximate minimum degree order of a graph, part after part.

The quotient graph, the bound on the degree and the merging of alike nodes are
those of Amestoy, Davis & Duff, *An approximate minimum degree ordering algorithm*,
SIAM J. Matrix Anal. Appl. 17 (1996), 886-905. Nodes of a later part wait for
those of the parts before, but count in their degrees.
"""

import numpy as np

from knitlab_core.arrays import IndexArray
from knitlab_core.jit import inner_kernel, kernel
from knitlab_core.sparse.quotient import ELEMENT, GONE, VARIABLE, Graph, Quotient, append, enlist, quotient, unlist


@inner_kernel
def _make_element(g: Quotient, lists: IndexArray, free: int, p: int) -> tuple[int, int]:
    """Turn variable p into the element of all it touches, listed from `free` on.

    Return where the list ends, or -1 where it finds no room, and its weight.
    """
    first, split = g.first[p], g.first[p] + g.elements[p]
    last = first + g.length[p]
    room = last - split
    for q in range(first, split):
        room += g.length[lists[q]]
    if free + room > lists.size:
        return -1, 0
    g.weight[p] = -g.weight[p]
    g.first[p] = free
    size = 0
    for q in range(first, last):
        e = lists[q]
        from_, to = (g.first[e], g.first[e] + g.length[e]) if q < split else (q, q + 1)
        for s in range(from_, to):
            v = lists[s]
            if g.weight[v] > 0:
                size += g.weight[v]
                g.weight[v] = -g.weight[v]
                lists[free] = v
                free += 1
        if q < split:
            g.kind[e] = GONE
    g.length[p], g.elements[p] = free - g.first[p], 0
    g.kind[p], g.degree[p] = ELEMENT, size
    return free, size


@inner_kernel
def _measure(g: Quotient, lists: IndexArray, p: int, flag: int) -> None:
    """Set mark[e] - flag to the weight of element e outside element p, for all that touch p."""
    for s in range(g.first[p], g.first[p] + g.length[p]):
        i = lists[s]
        for q in range(g.first[i], g.first[i] + g.elements[i]):
            e = lists[q]
            if g.kind[e] == ELEMENT:
                if g.mark[e] < flag:
                    g.mark[e] = flag + g.degree[e]
                g.mark[e] += g.weight[i]  # negative: i is in p


@inner_kernel
def _prune(g: Quotient, lists: IndexArray, i: int, p: int, flag: int) -> int:
    """Make p the last element of variable i, drop what p covers; return its degree outside p."""
    first, split = g.first[i], g.first[i] + g.elements[i]
    last = first + g.length[i]
    outside, key, put = 0, p, first
    for q in range(first, split):
        e = lists[q]
        if g.kind[e] != ELEMENT:
            continue
        if g.mark[e] > flag:
            outside += g.mark[e] - flag
            key += e
            lists[put] = e
            put += 1
        else:
            g.kind[e] = GONE
    g.elements[i] = put - first + 1
    # p takes the place of a variable or an element that is gone, so there is room before or among these.
    kept = split
    for q in range(split, last):
        v = lists[q]
        if g.weight[v] > 0:
            outside += g.weight[v]
            key += v
            lists[kept] = v
            kept += 1
    count = kept - split
    if put < split:
        for q in range(count):
            lists[put + 1 + q] = lists[split + q]
    else:
        for q in range(count - 1, -1, -1):
            lists[put + 1 + q] = lists[split + q]
    lists[put] = p
    g.length[i] = put + 1 + count - first
    g.key[i] = key % g.key.size
    return outside


@inner_kernel
def _merge_alike(g: Quotient, lists: IndexArray, part: IndexArray, p: int, flag: int) -> int:
    """Let one variable of element p stand for all with the same neighbours; return the next free flag."""
    for s in range(g.first[p], g.first[p] + g.length[p]):
        if g.weight[lists[s]] >= 0:
            continue
        key = g.key[lists[s]]
        i = g.bucket[key]
        g.bucket[key] = -1
        while i >= 0 and g.same[i] >= 0:
            flag += 1
            for q in range(g.first[i], g.first[i] + g.length[i]):
                g.mark[lists[q]] = flag
            previous, j = i, g.same[i]
            while j >= 0:
                alike = g.length[j] == g.length[i] and g.elements[j] == g.elements[i] and part[j] == part[i]
                q = g.first[j]
                while alike and q < g.first[j] + g.length[j]:
                    alike = g.mark[lists[q]] == flag
                    q += 1
                if alike:
                    g.weight[i] += g.weight[j]
                    g.weight[j] = 0
                    g.kind[j] = GONE
                    g.next_alike[g.last_alike[i]] = j
                    g.last_alike[i] = g.last_alike[j]
                    g.same[previous] = g.same[j]
                else:
                    previous = j
                j = g.same[j]
            i = g.same[i]
    return flag + 1


@inner_kernel
def _eliminate(
    g: Quotient, lists: IndexArray, free: int, part: IndexArray, p: int, order: IndexArray, done: int, flag: int
) -> tuple[int, int, int, int]:
    """Eliminate variable p; return the end of the lists (-1: no room), of the order, the least degree and the flag."""
    n, own = order.size, part[p]
    free, size = _make_element(g, lists, free, p)
    if free < 0:
        return free, done, 0, flag
    done = append(g, p, order, done)
    begin, end = g.first[p], free
    for s in range(begin, end):
        if part[lists[s]] == own:
            unlist(g, lists[s])
    _measure(g, lists, p, flag)
    for s in range(begin, end):
        i = lists[s]
        outside = _prune(g, lists, i, p, flag)
        if outside == 0 and part[i] == own:
            size += g.weight[i]
            done = append(g, i, order, done)
            g.weight[i], g.kind[i] = 0, GONE
        else:
            g.degree[i] = min(g.degree[i], outside)
            g.same[i] = g.bucket[g.key[i]]
            g.bucket[g.key[i]] = i
    g.degree[p] = size
    flag = _merge_alike(g, lists, part, p, flag + n + 1)
    least, free = n, begin
    for s in range(begin, end):
        i = lists[s]
        if g.weight[i] < 0:
            g.weight[i] = -g.weight[i]
            g.degree[i] = min(g.degree[i] + size, n - done) - g.weight[i]
            if part[i] == own:
                enlist(g, i)
                least = min(least, g.degree[i])
            lists[free] = i
            free += 1
    g.length[p] = free - begin
    return free, done, least, flag


@kernel
def _order(g: Quotient, lists: IndexArray, free: int, part: IndexArray, by_part: IndexArray, order: IndexArray) -> int:
    """Fill the order; return its length, which is short where the lists found no room."""
    n = part.size
    flag, done, began = 1, 0, 0
    while began < n:
        own, ended = part[by_part[began]], began
        while ended < n and part[by_part[ended]] == own:
            ended += 1
        # Backwards, so that of like nodes the first is eliminated first.
        for t in range(ended - 1, began - 1, -1):
            if g.kind[by_part[t]] == VARIABLE:
                enlist(g, by_part[t])
        least = 0
        while done < ended:
            while g.head[least] < 0:
                least += 1
            p = g.head[least]
            unlist(g, p)
            free, done, lowest, flag = _eliminate(g, lists, free, part, p, order, done, flag)
            if free < 0:
                return done
            least = min(least, lowest)
        began = ended
    return done


def minimum_degree(graph: Graph, part: IndexArray | None = None) -> IndexArray:
    """Return an order (N,) of the nodes in which elimination fills little.

    Parameters
    ----------
    graph : Graph
        Symmetric.
    part : (N,) array, optional
        Parts to eliminate one after the other, by ascending number; by default all nodes are one.
    """
    n = graph.start.size - 1
    if part is None:
        part = np.zeros(n, dtype=np.int64)
    by_part = np.argsort(part, kind="stable")
    order = np.empty(n, dtype=np.int64)
    edges = graph.neighbour.size
    room = 2 * edges + 4 * n
    while True:
        lists = np.empty(edges + room, dtype=np.int64)
        lists[:edges] = graph.neighbour
        if _order(quotient(graph), lists, edges, part, by_part, order) == n:
            return order
        room *= 2

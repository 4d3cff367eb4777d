"""Pairs of samples that may touch soon: a cell grid over spans, then over samples.

A candidate list is valid as long as no two samples have approached by more than
its skin. Never all pairs.
"""

from math import floor, sqrt
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.samples import Samples, sample_point
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, combine, dot, norm, row, sub

MAX_CELLS = 4_000_000


Cells = tuple[FloatArray, float, IndexArray, IndexArray, IndexArray, IndexArray]


class Candidates(NamedTuple):
    """Sample pairs grouped by span pairs.

    `span_a`, `span_b`: (S,) inner nodes, a < b; `start`: (S + 1,) first sample
    pair of each span pair; `a`, `b`: (P,) sample numbers i m + k.
    """

    span_a: IndexArray
    span_b: IndexArray
    start: IndexArray
    a: IndexArray
    b: IndexArray


@kernel
def _span_balls(q: FloatArray, spans: IndexArray, centre: FloatArray) -> float:
    """Fill centres (M, 3) of the spans and return the largest radius of their balls."""
    largest = 0.0
    for s in range(spans.size):
        i = spans[s]
        a, x, b = row(q, i - 1), row(q, i), row(q, i + 1)
        for c in range(3):
            centre[s, c] = (a[c] + 6.0 * x[c] + b[c]) / 8.0
        mid = row(centre, s)
        for p in (
            x,
            combine(0.5, a, 0.5, x),
            combine(0.5, b, 0.5, x),
        ):
            largest = max(largest, norm(sub(p, mid)))
    return largest


@kernel
def _sort_cells(
    centre: FloatArray,
    low: FloatArray,
    cell: float,
    dims: IndexArray,
    cell_of: IndexArray,
    first: IndexArray,
    order: IndexArray,
) -> None:
    """Sort spans by cell (counting sort): fill `cell_of`, `first` and `order`."""
    first[:] = 0
    for s in range(centre.shape[0]):
        k = 0
        for c in range(3):
            k = k * dims[c] + floor((centre[s, c] - low[c]) / cell)
        cell_of[s] = k
        first[k + 1] += 1
    for k in range(first.size - 1):
        first[k + 1] += first[k]
    for s in range(centre.shape[0] - 1, -1, -1):
        first[cell_of[s] + 1] -= 1
        order[first[cell_of[s] + 1]] = s


@inline_kernel
def _count_samples(
    q: FloatArray,
    samples: Samples,
    i: int,
    j: int,
    centre: Vector,
    ball2: float,
    reach2: float,
    exclusion: float,
    a: IndexArray,
    b: IndexArray,
    at: int,
) -> int:
    """Count the sample pairs of two spans within reach; write them from `at` when it is >= 0."""
    m = samples.weights.shape[0]
    same = samples.strand[i] == samples.strand[j]
    count = 0
    for k in range(m):
        x = sample_point(q, i, samples.weights, k)
        away = sub(x, centre)
        if dot(away, away) > ball2:
            continue
        arc_k = samples.arc[i] + ((k + 0.5) / m - 0.5) * samples.length[i] * m
        for n in range(m):
            if same:
                arc_n = samples.arc[j] + ((n + 0.5) / m - 0.5) * samples.length[j] * m
                if abs(arc_n - arc_k) < exclusion:
                    continue
            d = sub(x, sample_point(q, j, samples.weights, n))
            if dot(d, d) < reach2:
                if at >= 0:
                    a[at + count] = i * m + k
                    b[at + count] = j * m + n
                count += 1
    return count


@kernel
def _find(
    q: FloatArray,
    samples: Samples,
    centre: FloatArray,
    cells: Cells,
    ball: float,
    reach: float,
    exclusion: float,
    fill: bool,
    out: Candidates,
) -> tuple[int, int]:
    """Visit neighbouring cells; return the number of span pairs and of sample pairs.

    `cells` is (low, cell, dims, cell_of, first, order); `out` is written if `fill`.
    """
    _, _, dims, cell_of, first, order = cells
    reach_span2 = (reach + 2.0 * ball) ** 2
    spans, pairs = 0, 0
    for s in range(centre.shape[0]):
        i = samples.spans[s]
        x = row(centre, s)
        k = cell_of[s]
        kz, ky, kx = k % dims[2], (k // dims[2]) % dims[1], k // (dims[2] * dims[1])
        for cx in range(max(kx - 1, 0), min(kx + 2, dims[0])):
            for cy in range(max(ky - 1, 0), min(ky + 2, dims[1])):
                for cz in range(max(kz - 1, 0), min(kz + 2, dims[2])):
                    c = (cx * dims[1] + cy) * dims[2] + cz
                    for o in range(first[c + 1], first[c + 2]):
                        t = order[o]
                        if t <= s:
                            continue
                        j = samples.spans[t]
                        # Spans of one strand that share nodes are never paired.
                        if j - i < 3 and samples.strand[i] == samples.strand[j]:
                            continue
                        d = sub(x, row(centre, t))
                        if dot(d, d) > reach_span2:
                            continue
                        at = pairs if fill else -1
                        n = _count_samples(
                            q,
                            samples,
                            i,
                            j,
                            row(centre, t),
                            (reach + ball) ** 2,
                            reach * reach,
                            exclusion,
                            out.a,
                            out.b,
                            at,
                        )
                        if n > 0:
                            if fill:
                                out.span_a[spans] = i
                                out.span_b[spans] = j
                                out.start[spans + 1] = pairs + n
                            spans += 1
                            pairs += n
    return spans, pairs


def find_candidates(q: FloatArray, samples: Samples, law: ContactLaw, skin: float) -> Candidates:
    """List all sample pairs nearer than contact distance plus skin.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and angles.
    samples : Samples
        Where samples lie.
    law : ContactLaw
        Contact distance and exclusion.
    skin : float
        Extra distance [r].
    """
    centre = np.empty((samples.spans.size, 3))
    ball = _span_balls(q, samples.spans, centre)
    reach = law.distance + skin
    cell = reach + 2.0 * ball
    low = centre.min(axis=0)
    size = centre.max(axis=0) - low
    while True:
        dims = np.floor(size / cell).astype(np.int64) + 1
        if float(np.prod(dims.astype(float))) <= MAX_CELLS:
            break
        cell *= 2.0
    count = int(np.prod(dims))
    cells = (
        low,
        cell,
        dims,
        np.empty(centre.shape[0], np.int64),
        np.zeros(count + 2, np.int64),
        np.empty(centre.shape[0], np.int64),
    )
    _sort_cells(centre, *cells)
    none = Candidates(*(np.zeros(1, np.int64) for _ in range(5)))
    spans, pairs = _find(q, samples, centre, cells, ball, reach, law.exclusion, False, none)
    found = Candidates(
        np.empty(spans, np.int64),
        np.empty(spans, np.int64),
        np.zeros(spans + 1, np.int64),
        np.empty(pairs, np.int64),
        np.empty(pairs, np.int64),
    )
    _find(q, samples, centre, cells, ball, reach, law.exclusion, True, found)
    return found


@kernel
def largest_fraction(
    points: FloatArray, moves: FloatArray, candidates: Candidates, law: ContactLaw, share: float
) -> float:
    """Return the largest fraction of a move that uses at most `share` of any pair's room.

    The room of a pair is the distance of its samples less that of touching
    cores; a pair whose relative motion is less can never pass through.
    """
    fraction = 1.0
    core = law.distance - law.overlap_limit
    for p in range(candidates.a.size):
        a, b = candidates.a[p], candidates.b[p]
        d = norm(sub(row(points, a), row(points, b)))
        m = norm(sub(row(moves, a), row(moves, b)))
        room = share * (d - core)
        if m * fraction > room:
            fraction = room / m
    return fraction


@kernel
def _largest_motion(dx: FloatArray) -> float:
    """Return the largest length of the rows' first three entries."""
    largest = 0.0
    for i in range(dx.shape[0]):
        largest = max(largest, dx[i, 0] ** 2 + dx[i, 1] ** 2 + dx[i, 2] ** 2)
    return sqrt(largest)


def largest_approach(x: FloatArray, dx: FloatArray, reach: float, enough: float) -> float:
    """Bound by how much any two strands within `reach` approach when nodes move by `dx`.

    A uniform stretch brings no strands together beyond its strain, so motions
    too large to be harmless are split by least squares into dx = A x + c and a rest.

    Parameters
    ----------
    x, dx : (N, 3+) arrays
        Positions and motions [r].
    reach : float
        Distance up to which strands matter [r].
    enough : float
        A bound below this need not be sharpened [r].
    """
    simple = 2.0 * _largest_motion(dx)
    if simple <= enough:
        return float(simple)
    centred = x[:, :3] - x[:, :3].mean(axis=0)
    moved = dx[:, :3] - dx[:, :3].mean(axis=0)
    # The unit added keeps flat and straight specimens regular.
    moment = centred.T @ centred + len(x) * np.eye(3)
    gradient = np.linalg.solve(moment, centred.T @ moved)
    rest = moved - centred @ gradient
    return float(2.0 * _largest_motion(rest) + np.linalg.norm(gradient) * reach)

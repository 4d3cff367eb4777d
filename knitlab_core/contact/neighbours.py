"""Pairs of samples that may touch soon: a cell grid over spans, then over samples.

A candidate list is valid as long as no two samples have approached by more than
its skin. Never all pairs.
"""

from math import floor, sqrt
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.samples import Samples, sample_points
from knitlab_core.jit import kernel
from knitlab_core.rods.vectors import combine, dot, norm, row, sub

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


@kernel
def _near_spans(
    samples: Samples, centre: FloatArray, cells: Cells, reach2: float, first: IndexArray, second: IndexArray
) -> int:
    """Fill the pairs of spans (as places in `samples.spans`) nearer than the reach; return their number.

    `cells` is (low, cell, dims, cell_of, start, order). What does not fit is counted but not written.
    """
    _, _, dims, cell_of, start, order = cells
    count = 0
    for s in range(centre.shape[0]):
        i = samples.spans[s]
        x = row(centre, s)
        k = cell_of[s]
        kz, ky, kx = k % dims[2], (k // dims[2]) % dims[1], k // (dims[2] * dims[1])
        for cx in range(max(kx - 1, 0), min(kx + 2, dims[0])):
            for cy in range(max(ky - 1, 0), min(ky + 2, dims[1])):
                for cz in range(max(kz - 1, 0), min(kz + 2, dims[2])):
                    c = (cx * dims[1] + cy) * dims[2] + cz
                    for o in range(start[c + 1], start[c + 2]):
                        t = order[o]
                        if t <= s:
                            continue
                        j = samples.spans[t]
                        # Spans of one strand that share nodes are never paired.
                        if j - i < 3 and samples.strand[i] == samples.strand[j]:
                            continue
                        d = sub(x, row(centre, t))
                        if dot(d, d) > reach2:
                            continue
                        if count < first.size:
                            first[count] = s
                            second[count] = t
                        count += 1
    return count


@kernel
def _near_samples(
    points: FloatArray,
    samples: Samples,
    centre: FloatArray,
    near: tuple[IndexArray, IndexArray],
    ball: float,
    reach: float,
    exclusion: float,
    out: Candidates,
) -> tuple[int, int]:
    """Fill the sample pairs of near spans; return the number of span pairs and of sample pairs."""
    m = samples.weights.shape[0]
    spans, pairs = 0, 0
    for e in range(near[0].size):
        i, j = samples.spans[near[0][e]], samples.spans[near[1][e]]
        same = samples.strand[i] == samples.strand[j]
        middle = row(centre, near[1][e])
        before = pairs
        for k in range(m):
            x = row(points, i * m + k)
            away = sub(x, middle)
            if dot(away, away) > (reach + ball) ** 2:
                continue
            arc_k = samples.arc[i] + ((k + 0.5) / m - 0.5) * samples.length[i] * m
            for n in range(m):
                if same:
                    arc_n = samples.arc[j] + ((n + 0.5) / m - 0.5) * samples.length[j] * m
                    if abs(arc_n - arc_k) < exclusion:
                        continue
                d = sub(x, row(points, j * m + n))
                if dot(d, d) < reach * reach:
                    out.a[pairs] = i * m + k
                    out.b[pairs] = j * m + n
                    pairs += 1
        if pairs > before:
            out.span_a[spans] = i
            out.span_b[spans] = j
            out.start[spans + 1] = pairs
            spans += 1
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
    cells = _cells(centre, reach + 2.0 * ball)
    size = 4 * samples.spans.size
    while True:
        near = np.empty(size, np.int64), np.empty(size, np.int64)
        count = _near_spans(samples, centre, cells, (reach + 2.0 * ball) ** 2, *near)
        if count <= size:
            break
        size = count
    near = near[0][:count], near[1][:count]
    m = len(samples.weights)
    points = np.empty((len(q) * m, 3))
    sample_points(q, samples, points)
    # Room for every pair of samples of near spans; what is not used is never touched, and given back.
    out = Candidates(
        np.empty(count, np.int64),
        np.empty(count, np.int64),
        np.zeros(count + 1, np.int64),
        np.empty(count * m * m, np.int64),
        np.empty(count * m * m, np.int64),
    )
    spans, pairs = _near_samples(points, samples, centre, near, ball, reach, law.exclusion, out)
    return Candidates(
        out.span_a[:spans].copy(),
        out.span_b[:spans].copy(),
        out.start[: spans + 1].copy(),
        out.a[:pairs].copy(),
        out.b[:pairs].copy(),
    )


def _cells(centre: FloatArray, cell: float) -> Cells:
    """Sort span centres into cubic cells of at least the given size, fewer than `MAX_CELLS`."""
    low = centre.min(axis=0)
    size = centre.max(axis=0) - low
    while True:
        dims = np.floor(size / cell).astype(np.int64) + 1
        if float(np.prod(dims.astype(float))) <= MAX_CELLS:
            break
        cell *= 2.0
    cell_of, order = np.empty(len(centre), np.int64), np.empty(len(centre), np.int64)
    start = np.zeros(int(np.prod(dims)) + 2, np.int64)
    _sort_cells(centre, low, cell, dims, cell_of, start, order)
    return low, cell, dims, cell_of, start, order


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

"""Span pairs that may touch soon, by a cell grid; sample pairs within a distance.

A list of span pairs is valid as long as no two samples have approached by more
than its skin. Never all pairs.
"""

from math import floor

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.pairs import Balls, Candidates, SpanPairs, fill_balls, gather_pairs
from knitlab_core.contact.samples import Samples, sample_points
from knitlab_core.jit import kernel
from knitlab_core.rods.vectors import dot, row, sub

MAX_CELLS = 4_000_000


Cells = tuple[FloatArray, float, IndexArray, IndexArray, IndexArray, IndexArray]


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
    samples: Samples,
    centre: FloatArray,
    radius: FloatArray,
    cells: Cells,
    reach: float,
    first: IndexArray,
    second: IndexArray,
) -> int:
    """Fill the pairs of spans whose balls are nearer than the reach; return their number.

    `cells` is (low, cell, dims, cell_of, start, order). What does not fit is counted but not written.
    """
    _, _, dims, cell_of, start, order = cells
    count = 0
    for s in range(centre.shape[0]):
        i = samples.spans[s]
        x, own = row(centre, s), reach + radius[s]
        k = cell_of[s]
        kz, ky, kx = k % dims[2], (k // dims[2]) % dims[1], k // (dims[2] * dims[1])
        for cx in range(max(kx - 1, 0), min(kx + 2, dims[0])):
            for cy in range(max(ky - 1, 0), min(ky + 2, dims[1])):
                for cz in range(max(kz - 1, 0), min(kz + 2, dims[2])):
                    c = (cx * dims[1] + cy) * dims[2] + cz
                    # Spans of a cell are sorted: the later ones alone are partners.
                    for o in range(start[c + 2] - 1, start[c + 1] - 1, -1):
                        t = order[o]
                        if t <= s:
                            break
                        j = samples.spans[t]
                        # Spans of one strand that share nodes are never paired.
                        if j - i < 3 and samples.strand[i] == samples.strand[j]:
                            continue
                        if samples.image[i] and samples.image[j]:
                            continue
                        d = sub(x, row(centre, t))
                        if dot(d, d) > (own + radius[t]) ** 2:
                            continue
                        if count < first.size:
                            first[count] = i
                            second[count] = j
                        count += 1
    return count


def list_spans(q: FloatArray, samples: Samples, reach: float, balls: Balls) -> SpanPairs:
    """List all pairs of spans that may hold samples nearer than a reach, sorted.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and angles.
    samples : Samples
        Where samples lie.
    reach : float
        Distance [r].
    balls : Balls
        Filled with those of the spans.
    """
    fill_balls(q, samples.spans, balls)
    return pair_balls(samples, reach, balls)


def list_swept(samples: Samples, reach: float, balls: Balls, moves: Balls) -> SpanPairs:
    """List all pairs of spans that may hold samples nearer than a reach anywhere on a straight move, sorted.

    `balls` are those of the spans where they begin, `moves` those of their motions.
    """
    half = np.sqrt(moves.centre[:, 0] ** 2 + moves.centre[:, 1] ** 2 + moves.centre[:, 2] ** 2) / 2.0
    swept = Balls(balls.centre + 0.5 * moves.centre, balls.radius + (half + moves.radius))
    return pair_balls(samples, reach, swept)


def pair_balls(samples: Samples, reach: float, balls: Balls) -> SpanPairs:
    """List all pairs of spans whose balls are nearer than a reach, sorted."""
    n = len(balls.radius)
    centre, radius = balls.centre[samples.spans], balls.radius[samples.spans]
    largest = float(radius.max())
    cells = _cells(centre, reach + 2.0 * largest)
    size = 4 * samples.spans.size
    while True:
        first, second = np.empty(size, np.int64), np.empty(size, np.int64)
        count = _near_spans(samples, centre, radius, cells, reach, first, second)
        if count <= size:
            break
        size = count
    # In this order whatever the cells: sums over pairs have the same bits in every list that holds them.
    key = np.sort(first[:count] * n + second[:count])
    return SpanPairs(key // n, key % n)


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
    reach = law.distance + skin
    balls = Balls.zeros(len(q))
    spans = list_spans(q, samples, reach, balls)
    points = np.empty((len(q) * len(samples.weights), 3))
    sample_points(q, samples, points)
    count, pairs = 64, 1024
    while True:
        out = Candidates.empty(count, pairs)
        room = count, pairs
        count, pairs = gather_pairs(points, balls, spans, samples, reach, law.exclusion, out)
        if count <= room[0] and pairs <= room[1]:
            return out.first(count, pairs)


def least_distance(q: FloatArray, samples: Samples, law: ContactLaw) -> float:
    """Return the least distance of two samples [r], rounded down; infinite if none are within the law's reach.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and angles.
    samples, law
        Where samples lie, and the contact law.
    """
    pairs = find_candidates(q, samples, law, law.onset)
    points = np.empty((len(q) * len(samples.weights), 3))
    sample_points(q, samples, points)
    x, y, z = (points[pairs.a] - points[pairs.b]).T
    return float(np.sqrt((x * x + y * y + z * z).min(initial=np.inf))) * (1.0 - 1e-12)


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

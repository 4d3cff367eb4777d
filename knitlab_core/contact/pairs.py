"""Sample pairs near each other, found in a list of span pairs by the balls that hold the spans."""

from math import sqrt
from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.contact.samples import Samples
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import combine, dot, norm, row, sub


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

    @classmethod
    def empty(cls, spans: int, pairs: int) -> Self:
        """Allocate room for so many span pairs and sample pairs."""
        return cls(*(np.empty(size, np.int64) for size in (spans, spans, spans + 1, pairs, pairs)))

    def first(self, spans: int, pairs: int) -> Self:
        """Return a view of the first span pairs and sample pairs."""
        return type(self)(
            self.span_a[:spans], self.span_b[:spans], self.start[: spans + 1], self.a[:pairs], self.b[:pairs]
        )


class SpanPairs(NamedTuple):
    """Pairs of spans, sorted: `a`, `b` (S,) inner nodes, a < b."""

    a: IndexArray
    b: IndexArray


class Balls(NamedTuple):
    """Balls that hold all samples of a span: `centre` (N, 3) and `radius` (N,), set at inner nodes."""

    centre: FloatArray
    radius: FloatArray

    @classmethod
    def zeros(cls, nodes: int) -> Self:
        """Allocate for so many nodes."""
        return cls(np.zeros((nodes, 3)), np.zeros(nodes))


@kernel
def fill_balls(x: FloatArray, spans: IndexArray, balls: Balls) -> float:
    """Fill the balls of spans for nodes x (N, 3+), positions or motions; return the largest radius.

    A span is inside the triangle of its control polygon.
    """
    largest = 0.0
    for i in spans:
        before, here, after = row(x, i - 1), row(x, i), row(x, i + 1)
        for c in range(3):
            balls.centre[i, c] = 0.125 * (before[c] + 6.0 * here[c] + after[c])
        middle, radius = row(balls.centre, i), 0.0
        for corner in (here, combine(0.5, before, 0.5, here), combine(0.5, after, 0.5, here)):
            away = sub(corner, middle)
            radius = max(radius, dot(away, away))
        # Rounding must not leave a sample outside.
        balls.radius[i] = sqrt(radius) * (1.0 + 1e-12)
        largest = max(largest, balls.radius[i])
    return largest


@inline_kernel
def sample_arc(i: int, k: int, m: int, samples: Samples) -> float:
    """Return the rest arc length at sample k of span i."""
    return float(samples.arc[i] + ((k + 0.5) / m - 0.5) * samples.length[i] * m)


@kernel
def gather_pairs(
    points: FloatArray,
    balls: Balls,
    spans: SpanPairs,
    samples: Samples,
    reach: float,
    exclusion: float,
    out: Candidates,
) -> tuple[int, int]:
    """Fill the sample pairs nearer than the reach; return the number of span pairs and of sample pairs.

    What does not fit into `out` is counted but not written.

    Parameters
    ----------
    points : (N m, 3) array
        Samples.
    balls : Balls
        Of the same configuration.
    spans : SpanPairs
        Span pairs to look at.
    samples : Samples
        The samples.
    reach, exclusion : float
        Distance of samples, and rest arc length within which samples of one strand are no pair [r].
    out : Candidates
        Filled.
    """
    m = samples.weights.shape[0]
    room, span_room = out.a.size, out.span_a.size
    count, pairs, limit = 0, 0, reach * reach
    out.start[0] = 0
    for s in range(spans.a.size):
        i, j = spans.a[s], spans.b[s]
        middle, ball = row(balls.centre, j), reach + balls.radius[j]
        away = sub(row(balls.centre, i), middle)
        if dot(away, away) > (ball + balls.radius[i]) ** 2:
            continue
        same = samples.strand[i] == samples.strand[j]
        before = pairs
        for k in range(m):
            x = row(points, i * m + k)
            away = sub(x, middle)
            if dot(away, away) > ball * ball:
                continue
            arc = sample_arc(i, k, m, samples)
            for n in range(m):
                d = sub(x, row(points, j * m + n))
                if dot(d, d) >= limit:
                    continue
                if same and abs(sample_arc(j, n, m, samples) - arc) < exclusion:
                    continue
                if pairs < room:
                    out.a[pairs] = i * m + k
                    out.b[pairs] = j * m + n
                pairs += 1
        if pairs > before:
            if count < span_room:
                out.span_a[count] = i
                out.span_b[count] = j
                out.start[count + 1] = pairs
            count += 1
    return count, pairs


@kernel
def largest_fraction(
    points: FloatArray,
    moves: FloatArray,
    balls: Balls,
    move_balls: Balls,
    spans: SpanPairs,
    samples: Samples,
    exclusion: float,
    core: float,
    share: float,
) -> float:
    """Return the largest fraction of a move that uses at most `share` of any pair's room.

    The room of a pair is the distance of its samples less that of touching
    cores; a pair whose relative motion is less can never pass through.

    Parameters
    ----------
    points, moves : (N m, 3) arrays
        Samples and their motions [r].
    balls, move_balls : Balls
        Balls of the spans' positions and of their motions.
    spans, samples, exclusion
        As for `gather_pairs`.
    core : float
        Distance of touching cores [r].
    share : float
        Between 0 and 1.
    """
    m = samples.weights.shape[0]
    fraction = 1.0
    for s in range(spans.a.size):
        i, j = spans.a[s], spans.b[s]
        middle, move = row(balls.centre, j), row(move_balls.centre, j)
        spread = move_balls.radius[j]
        most = norm(sub(row(move_balls.centre, i), move)) + spread + move_balls.radius[i]
        # A pair that is farther apart than this has room enough.
        near = core + most * fraction / share + balls.radius[j]
        away = sub(row(balls.centre, i), middle)
        if dot(away, away) > (near + balls.radius[i]) ** 2:
            continue
        same = samples.strand[i] == samples.strand[j]
        for k in range(m):
            x, dx = row(points, i * m + k), row(moves, i * m + k)
            near = core + (norm(sub(dx, move)) + spread) * fraction / share
            away = sub(x, middle)
            if dot(away, away) > (near + balls.radius[j]) ** 2:
                continue
            arc = sample_arc(i, k, m, samples)
            for n in range(m):
                d = sub(x, row(points, j * m + n))
                d2 = dot(d, d)
                if d2 >= near * near:
                    continue
                if same and abs(sample_arc(j, n, m, samples) - arc) < exclusion:
                    continue
                motion = norm(sub(dx, row(moves, j * m + n)))
                room = max(share * (sqrt(d2) - core), 0.0)
                if motion * fraction > room:
                    fraction = room / motion
    return fraction


def grouped(key: IndexArray, samples: int, m: int) -> Candidates:
    """Return the sample pairs of keys a `samples` + b, grouped by sorted span pairs.

    Parameters
    ----------
    key : (P,) array
        One number a pair.
    samples, m : int
        Number of samples of all spans, and of one.
    """
    a, b = key // samples, key % samples
    nodes = samples // m
    order = np.lexsort((b, a, (a // m) * nodes + b // m))
    a, b = a[order], b[order]
    first = np.ones(a.size, dtype=np.bool_)
    first[1:] = (a[1:] // m != a[:-1] // m) | (b[1:] // m != b[:-1] // m)
    start = np.append(np.flatnonzero(first), a.size)
    return Candidates(a[first] // m, b[first] // m, start, a, b)

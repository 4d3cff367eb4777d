"""Slip between the surfaces of two strands: how it is measured, and how it depends on the unknowns.

The points of the two surfaces that touched at the last equilibrium ride on their strands: each is half-way
along the line r0 between the two centrelines and turns with its own strand by R since then. What has opened
between them since is r - (Ra + Rb) r0 / 2; across the normal that is the slip. Strands that move and turn
together do not slip, strands that roll on each other do not either, and friction acts on them with a couple.

A pair that carries an elastic slip xi keeps the anchor c = r0 - xi in place of r0, so that xi turns along.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.frames import Frames, material_directors
from knitlab_core.rods.vectors import Vector, combine, cross, dot, row, scale, sub

Matrix = tuple[Vector, Vector, Vector]
"""Rows of a 3 x 3 matrix."""


class Placed(NamedTuple):
    """Samples and edges in one configuration.

    `points`: (N m, 3) samples [r]; `turn`: (N, 3, 3) rotation of each edge's
    material frame since the last equilibrium; `tangent`: (N, 3); `length`: (N,).
    """

    points: FloatArray
    turn: FloatArray
    tangent: FloatArray
    length: FloatArray

    @classmethod
    def zeros(cls, nodes: int, samples: int) -> Self:
        """Allocate for so many nodes and samples."""
        return cls(np.zeros((samples, 3)), np.zeros((nodes, 3, 3)), np.zeros((nodes, 3)), np.zeros(nodes))


@kernel
def material_frames(q: FloatArray, has_edge: BoolArray, frames: Frames, out: FloatArray) -> None:
    """Fill the material frame of every edge: columns tangent, m1, m2 of `out` (N, 3, 3)."""
    for i in range(q.shape[0]):
        if not has_edge[i]:
            continue
        t = row(frames.tangent, i)
        a, b = material_directors(t, row(frames.director, i), q[i, 3])
        for c in range(3):
            out[i, c, 0] = t[c]
            out[i, c, 1] = a[c]
            out[i, c, 2] = b[c]


@kernel
def place_edges(q: FloatArray, has_edge: BoolArray, frames: Frames, base: FloatArray, placed: Placed) -> None:
    """Fill tangents, lengths and the rotations of the edges since their material frames were `base`."""
    for i in range(q.shape[0]):
        if not has_edge[i]:
            continue
        t = row(frames.tangent, i)
        a, b = material_directors(t, row(frames.director, i), q[i, 3])
        placed.length[i] = frames.length[i]
        for r in range(3):
            placed.tangent[i, r] = t[r]
            for c in range(3):
                placed.turn[i, r, c] = t[r] * base[i, c, 0] + a[r] * base[i, c, 1] + b[r] * base[i, c, 2]


@inline_kernel
def _turned(i: int, turn: FloatArray, v: Vector) -> Vector:
    return (
        turn[i, 0, 0] * v[0] + turn[i, 0, 1] * v[1] + turn[i, 0, 2] * v[2],
        turn[i, 1, 0] * v[0] + turn[i, 1, 1] * v[1] + turn[i, 1, 2] * v[2],
        turn[i, 2, 0] * v[0] + turn[i, 2, 1] * v[1] + turn[i, 2, 2] * v[2],
    )


@inline_kernel
def carried_along(i: int, k: int, m: int, placed: Placed, v: Vector) -> Vector:
    """Turn a vector with sample k of span i: between its two edges in proportion."""
    u = (k + 0.5) / m
    return combine(1.0 - u, _turned(i - 1, placed.turn, v), u, _turned(i, placed.turn, v))


@inline_kernel
def opened(a: int, b: int, m: int, placed: Placed, v: Vector) -> Vector:
    """Return r - (Ra + Rb) v / 2: what has opened between two points that were v apart."""
    on_a = carried_along(a // m, a % m, m, placed, v)
    on_b = carried_along(b // m, b % m, m, placed, v)
    r = sub(row(placed.points, a), row(placed.points, b))
    return (
        r[0] - 0.5 * (on_a[0] + on_b[0]),
        r[1] - 0.5 * (on_a[1] + on_b[1]),
        r[2] - 0.5 * (on_a[2] + on_b[2]),
    )


@inline_kernel
def _edge_slope(e: Vector, i: int, placed: Placed, v: Vector) -> tuple[Vector, float]:
    """Return h and s with e . d(R v) = h . d(edge i) + s d(angle i)."""
    t = row(placed.tangent, i)
    along, across = dot(t, v), dot(e, t)
    h = combine(along, e, -across, v)  # across t as it is
    return scale(1.0 / placed.length[i], h), dot(e, cross(t, v))


@inline_kernel
def add_pull(
    force: Vector, ka: int, kb: int, w: FloatArray, anchor: Vector, sums: FloatArray, moments: FloatArray
) -> None:
    """Add a pair's force along its slip to the sums of its span pair.

    The slope of slip is linear in the direction, and its part by the edges' turns bilinear in direction and anchor:
    `moments` (4, 3, 3) sums force times anchor for the edges i - 1, i, j - 1, j; `sums` (6, 4) sums the rest at
    the six nodes. `add_edge_pulls` brings them together.
    """
    m = w.shape[0]
    ua, ub = 0.5 * (ka + 0.5) / m, 0.5 * (kb + 0.5) / m
    for r in range(3):
        for n in range(3):
            sums[n, r] += w[ka, n] * force[r]
            sums[n + 3, r] -= w[kb, n] * force[r]
        for c in range(3):
            product = force[r] * anchor[c]
            moments[0, r, c] += (0.5 - ua) * product
            moments[1, r, c] += ua * product
            moments[2, r, c] += (0.5 - ub) * product
            moments[3, r, c] += ub * product


@inline_kernel
def _moment(n: int, i: int, placed: Placed, moments: FloatArray) -> Matrix:
    """Return the rows of moment n, its anchors turned with edge i: the sum of e v^T."""
    a = moments
    return (
        _turned(i, placed.turn, (a[n, 0, 0], a[n, 0, 1], a[n, 0, 2])),
        _turned(i, placed.turn, (a[n, 1, 0], a[n, 1, 1], a[n, 1, 2])),
        _turned(i, placed.turn, (a[n, 2, 0], a[n, 2, 1], a[n, 2, 2])),
    )


@inline_kernel
def _times(a: Matrix, v: Vector) -> Vector:
    """Return A v of a matrix given by its rows."""
    return (dot(a[0], v), dot(a[1], v), dot(a[2], v))


@inline_kernel
def _transposed_times(a: Matrix, v: Vector) -> Vector:
    """Return A^T v of a matrix given by its rows."""
    return combine(1.0, combine(v[0], a[0], v[1], a[1]), v[2], a[2])


@inline_kernel
def _axial(a: Matrix) -> Vector:
    """Return the sum of v x e for the sum of e v^T given by its rows."""
    return (a[2][1] - a[1][2], a[0][2] - a[2][0], a[1][0] - a[0][1])


@inline_kernel
def add_edge_pulls(i: int, j: int, placed: Placed, moments: FloatArray, sums: FloatArray) -> None:
    """Add what `moments` (4, 3, 3) of span pair i, j do to its nodes to `sums` (6, 4)."""
    for n in range(4):
        edge = (i if n < 2 else j) - 1 + n % 2
        at = n if n < 2 else n + 1
        a, t = _moment(n, edge, placed, moments), row(placed.tangent, edge)
        h = scale(1.0 / placed.length[edge], sub(_times(a, t), _transposed_times(a, t)))
        for c in range(3):
            sums[at, c] += h[c]
            sums[at + 1, c] -= h[c]
        sums[at, 3] -= dot(_axial(a), t)


@inline_kernel
def _add_edge_curvature(a: Matrix, i: int, placed: Placed, square: FloatArray, at: int) -> None:
    """Subtract the second derivatives of e . R v of edge i from `square`, its nodes' unknowns from place `at` on.

    `a` is e v^T, or a sum of them. Blocks above the diagonal are left out.
    """
    t, inverse = row(placed.tangent, i), 1.0 / placed.length[i]
    ahead = _times(a, t)
    g = sub(ahead, _transposed_times(a, t))
    h = combine(1.0, _axial(a), 1.0, cross(ahead, t))
    h = combine(1.0, h, -dot(h, t), t)
    both = a[0][0] + a[1][1] + a[2][2]
    # (e x t) times the components of v, then rows of (e x t) (v x t)^T.
    x = cross((a[0][0], a[1][0], a[2][0]), t)
    y = cross((a[0][1], a[1][1], a[2][1]), t)
    z = cross((a[0][2], a[1][2], a[2][2]), t)
    ev = (cross((x[0], y[0], z[0]), t), cross((x[1], y[1], z[1]), t), cross((x[2], y[2], z[2]), t))
    for r in range(3):
        for c in range(3):
            k = 0.5 * (ev[r][c] + ev[c][r]) - t[r] * g[c] - g[r] * t[c] + both * t[r] * t[c]
            if r == c:
                k -= both
            k *= inverse * inverse
            square[at + r, at + c] -= k
            square[at + 4 + r, at + c] += k
            square[at + 4 + r, at + 4 + c] -= k
        k = inverse * h[r]
        square[at + 3, at + r] += k
        square[at + r, at + 3] += k
        square[at + 4 + r, at + 3] -= k
    square[at + 3, at + 3] -= dot(ahead, t) - both


@inline_kernel
def add_edge_curvatures(i: int, j: int, placed: Placed, moments: FloatArray, square: FloatArray) -> None:
    """Add the second derivatives of slip that `moments` (4, 3, 3) of span pair i, j stand for to `square` (24, 24).

    Unlike the slope they do not vanish where a strand is free to spin: then they are all the stiffness there is.
    """
    for n in range(4):
        edge = (i if n < 2 else j) - 1 + n % 2
        _add_edge_curvature(_moment(n, edge, placed, moments), edge, placed, square, 4 * (n if n < 2 else n + 1))


@inline_kernel
def turned_anchor(i: int, k: int, m: int, placed: Placed, anchor: Vector) -> tuple[Vector, Vector]:
    """Return half an anchor as the edges i - 1 and i carry it with sample k of span i."""
    u = 0.5 * (k + 0.5) / m
    return scale(0.5 - u, _turned(i - 1, placed.turn, anchor)), scale(u, _turned(i, placed.turn, anchor))


@inline_kernel
def fill_slope(
    e: Vector,
    sign: float,
    i: int,
    k: int,
    w: FloatArray,
    placed: Placed,
    turned: tuple[Vector, Vector],
    out: FloatArray,
    at: int,
) -> None:
    """Write the slope of the slip along `e` in the twelve unknowns of a strand to `out` from place `at` on.

    `turned` is what `turned_anchor` gives; else as `add_slip_slope`.
    """
    before, turn_before = _edge_slope(e, i - 1, placed, turned[0])
    after, turn_after = _edge_slope(e, i, placed, turned[1])
    for c in range(3):
        out[at + c] = sign * w[k, 0] * e[c] + before[c]
        out[at + 4 + c] = sign * w[k, 1] * e[c] - before[c] + after[c]
        out[at + 8 + c] = sign * w[k, 2] * e[c] - after[c]
    out[at + 3], out[at + 7], out[at + 11] = -turn_before, -turn_after, 0.0


@inline_kernel
def add_slip_slope(
    e: Vector, sign: float, i: int, k: int, w: FloatArray, placed: Placed, anchor: Vector, out: FloatArray, at: int
) -> None:
    """Add to rows at, at + 1, at + 2 of `out` (., 4) the slope of the slip along `e` in a strand's unknowns.

    The rows are those of nodes i - 1, i, i + 1; `sign` is +1 for strand a and -1 for b.
    """
    u = (k + 0.5) / w.shape[0]
    before, turn_before = _edge_slope(e, i - 1, placed, scale(0.5 * (1.0 - u), _turned(i - 1, placed.turn, anchor)))
    after, turn_after = _edge_slope(e, i, placed, scale(0.5 * u, _turned(i, placed.turn, anchor)))
    for c in range(3):
        out[at, c] += sign * w[k, 0] * e[c] + before[c]
        out[at + 1, c] += sign * w[k, 1] * e[c] - before[c] + after[c]
        out[at + 2, c] += sign * w[k, 2] * e[c] - after[c]
    out[at, 3] -= turn_before
    out[at + 1, 3] -= turn_after


@inline_kernel
def add_slip_curvature(
    e: Vector, i: int, k: int, m: int, placed: Placed, anchor: Vector, square: FloatArray, at: int
) -> None:
    """Add the second derivatives of the slip along `e` in a strand's unknowns to `square` (24, 24).

    Unlike the slope they do not vanish where a strand is free to spin: then they are all the stiffness there is.
    `at` is the place of node i - 1's unknowns: 0 for strand a and 12 for b. Blocks above the diagonal are left out.
    """
    for n, v in enumerate(turned_anchor(i, k, m, placed, anchor)):
        outer = scale(e[0], v), scale(e[1], v), scale(e[2], v)
        _add_edge_curvature(outer, i - 1 + n, placed, square, at + 4 * n)

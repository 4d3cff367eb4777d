"""What never changes in a test: rest shapes and stiffnesses of all rods, in scaled units.

Rods lie one after the other in the node arrays. Node i has four unknowns: its
position and the angle of the edge that leaves it. The last node of a rod has no
edge; its angle is a dummy that stays fixed.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.frames import (
    Frames,
    curvature_binormal,
    follow,
    initial_directors,
    material_curvature,
    material_directors,
)
from knitlab_core.rods.vectors import Vector, combine, dot, norm, row


class Rods(NamedTuple):
    """Rest state and stiffness of every span, scaled by r and E r^2.

    The yarn is the quadratic B-spline that the nodes control. Span i belongs to the
    inner node i and runs from the middle of edge i - 1 to the middle of edge i.

    `has_edge`, `is_inner`: (N,) bool; `rest_length`: (N,) length of every edge;
    `span`: (N,) length of every span of the spline; `stretched`: (N,) length that the
    axial strain at a node is measured over: its span, or half the edge of a node where a
    rod ends; `evenness`: (N,) length that weighs the unevenness of a span in the energy
    as `stretched` does its axial strain; `easing`: (N,) how fast that weight falls as the
    span bends, EA span^2 / EI; `stretch_stiffness`: (N,) EA per node; `bend_stiffness`, `twist_stiffness`:
    (N,) EI and GJ per inner node. What every node is at rest at: `rest_stretch`: (N, 2)
    axial strain and unevenness, none as made; `rest_curvature`: (N, 2); `rest_twist`: (N,).
    """

    has_edge: BoolArray
    is_inner: BoolArray
    rest_length: FloatArray
    span: FloatArray
    stretched: FloatArray
    evenness: FloatArray
    easing: FloatArray
    stretch_stiffness: FloatArray
    bend_stiffness: FloatArray
    twist_stiffness: FloatArray
    rest_stretch: FloatArray
    rest_curvature: FloatArray
    rest_twist: FloatArray


def edges_of(sizes: tuple[int, ...]) -> BoolArray:
    """Mark where an edge leaves a node, for rods of the given node counts."""
    has_edge = np.ones(sum(sizes), dtype=np.bool_)
    has_edge[np.cumsum(sizes) - 1] = False
    return has_edge


def make_rods(
    x: FloatArray,
    sizes: tuple[int, ...],
    *,
    poisson_ratio: float,
    straight: bool = False,
) -> tuple[Rods, Frames]:
    """Make circular rods of unit radius and unit modulus through the given nodes.

    Parameters
    ----------
    x : (N, 3) array
        Node positions of all rods [r]; edges are unstretched here.
    sizes : tuple of int
        Nodes per rod, each at least 3.
    poisson_ratio : float
        For the shear modulus.
    straight : bool
        Rest shape straight and untwisted instead of the given one.

    Returns
    -------
    Rods, Frames
        The rods and the frames of the given configuration.
    """
    n = x.shape[0]
    has_edge = edges_of(sizes)
    inner = np.zeros(n, dtype=np.bool_)
    inner[1:] = has_edge[:-1] & has_edge[1:]
    frames = Frames.zeros(n)
    initial_directors(x, has_edge, frames.tangent, frames.director, frames.length)
    q = np.column_stack([x, np.zeros(n)])
    follow(q, has_edge, frames.copy(), frames)
    span = np.zeros(n)
    measure_spans(inner, frames, span)
    rest_length = frames.length.copy()
    # The strains of two bars end to end are their mean and their difference: these weights give the bars' energy.
    before = np.append(0.0, rest_length[:-1])
    evenness = np.where(inner, 0.5 * before * rest_length / np.maximum(before + rest_length, np.finfo(float).tiny), 0.0)
    area, inertia = np.pi, np.pi / 4.0
    curvature, twist = np.zeros((n, 2)), np.zeros(n)
    if not straight:
        measure_strains(q, inner, frames, curvature, twist)
    rods = Rods(
        has_edge=has_edge,
        is_inner=inner,
        rest_length=rest_length,
        span=span,
        stretched=stretched_lengths(has_edge, inner, rest_length, span),
        evenness=evenness,
        easing=area * span**2 / inertia,
        stretch_stiffness=np.full(n, area),
        bend_stiffness=np.where(inner, inertia, 0.0),
        twist_stiffness=np.where(inner, inertia / (1.0 + poisson_ratio), 0.0),
        rest_stretch=np.zeros((n, 2)),
        rest_curvature=curvature,
        rest_twist=twist,
    )
    return rods, frames


def stretched_lengths(
    has_edge: BoolArray, is_inner: BoolArray, rest_length: FloatArray, span: FloatArray
) -> FloatArray:
    """Return the lengths (N,) that axial strains are measured over: together every rod from end to end of its spline.

    Parameters
    ----------
    has_edge, is_inner : (N,) bool arrays
        Where an edge leaves a node, and where two meet.
    rest_length, span : (N,) arrays
        Of edges and spans [r].
    """
    half = np.where(has_edge, 0.5 * rest_length, 0.0)
    return np.asarray(np.where(is_inner, span, half + np.append(0.0, half[:-1])))


@inline_kernel
def span_chord(te: Vector, le: float, tf: Vector, lf: float) -> tuple[Vector, float]:
    """Return direction and length of the line across the two edges of a span."""
    s = combine(le, te, lf, tf)
    c = norm(s)
    return (s[0] / c, s[1] / c, s[2] / c), c


@inline_kernel
def span_length(chord: float, le: float, lf: float) -> float:
    """Return the length of a span of the spline: Simpson's rule on its speed."""
    return chord / 3.0 + (le + lf) / 6.0


@inline_kernel
def eased(i: int, cosine: float, rods: Rods) -> tuple[float, float]:
    """Return the root sqrt(W) by which bending eases the unevenness of span i, and W easing.

    W = 1 / (1 + easing (1 - te . tf)). Edges of a bent yarn differ in length where its curvature changes, by
    phi^2 / 12; to forbid that at the price of EA would lock the bending of slender rods.
    """
    w = 1.0 / (1.0 + rods.easing[i] * (1.0 - cosine))
    return sqrt(w), w * rods.easing[i]


@kernel
def measure_spans(is_inner: BoolArray, frames: Frames, span: FloatArray) -> None:
    """Fill the lengths (N,) of the spans of a configuration [r]."""
    for i in range(1, is_inner.shape[0]):
        if is_inner[i]:
            le, lf = frames.length[i - 1], frames.length[i]
            _, chord = span_chord(row(frames.tangent, i - 1), le, row(frames.tangent, i), lf)
            span[i] = span_length(chord, le, lf)


@kernel
def measure_stretch(rods: Rods, frames: Frames, stretch: FloatArray) -> None:
    """Fill axial strain and unevenness (N, 2) of a configuration.

    The unevenness of a span is the strain of its first edge less that of its second, eased as the span bends.
    Without it nodes could slide along the yarn, every other one to and fro, while all spans keep their lengths.
    """
    for i in range(rods.has_edge.shape[0]):
        if not rods.has_edge[i]:
            continue
        lf = frames.length[i]
        along = lf / rods.rest_length[i]
        if rods.is_inner[i]:
            le = frames.length[i - 1]
            te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
            _, chord = span_chord(te, le, tf, lf)
            root, _ = eased(i, dot(te, tf), rods)
            stretch[i, 0] = span_length(chord, le, lf) / rods.span[i] - 1.0
            stretch[i, 1] = root * (le / rods.rest_length[i - 1] - along)
        else:
            stretch[i, 0] = along - 1.0
        if not rods.is_inner[i + 1]:
            stretch[i + 1, 0] = along - 1.0


@kernel
def measure_strains(
    q: FloatArray, is_inner: BoolArray, frames: Frames, curvature: FloatArray, twist: FloatArray
) -> None:
    """Fill material curvature (N, 2) and twist (N,) of a configuration (integrated, unitless)."""
    for i in range(1, q.shape[0]):
        if not is_inner[i]:
            continue
        te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
        m1e, m2e = material_directors(te, row(frames.director, i - 1), q[i - 1, 3])
        m1f, m2f = material_directors(tf, row(frames.director, i), q[i, 3])
        kb = curvature_binormal(te, tf)
        k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
        curvature[i, 0] = k1
        curvature[i, 1] = k2
        twist[i] = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i]

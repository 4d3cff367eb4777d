"""What never changes in a test: rest shapes and stiffnesses of all rods, in scaled units.

Rods lie one after the other in the node arrays. Node i has four unknowns: its
position and the angle of the edge that leaves it. The last node of a rod has no
edge; its angle is a dummy that stays fixed.
"""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.jit import kernel
from knitlab_core.rods.frames import (
    Frames,
    curvature_binormal,
    follow,
    initial_directors,
    material_curvature,
    material_directors,
)
from knitlab_core.rods.vectors import row


class Rods(NamedTuple):
    """Rest state and stiffness of every edge and inner node, scaled by r and E r^2.

    `has_edge`, `is_inner`: (N,) bool; `rest_length`: (N,) per edge;
    `span`: (N,) rest length an inner node stands for; `stretch_stiffness`: (N,)
    EA per edge; `bend_stiffness`, `twist_stiffness`: (N,) EI and GJ per inner
    node; `rest_curvature`: (N, 2); `rest_twist`: (N,).
    """

    has_edge: BoolArray
    is_inner: BoolArray
    rest_length: FloatArray
    span: FloatArray
    stretch_stiffness: FloatArray
    bend_stiffness: FloatArray
    twist_stiffness: FloatArray
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
    span[1:] = 0.5 * (frames.length[:-1] + frames.length[1:])
    span[~inner] = 0.0
    area, inertia = np.pi, np.pi / 4.0
    curvature, twist = np.zeros((n, 2)), np.zeros(n)
    if not straight:
        measure_strains(q, inner, frames, curvature, twist)
    rods = Rods(
        has_edge=has_edge,
        is_inner=inner,
        rest_length=frames.length.copy(),
        span=span,
        stretch_stiffness=np.where(has_edge, area, 0.0),
        bend_stiffness=np.where(inner, inertia, 0.0),
        twist_stiffness=np.where(inner, inertia / (1.0 + poisson_ratio), 0.0),
        rest_curvature=curvature,
        rest_twist=twist,
    )
    return rods, frames


@kernel
def measure_strains(
    q: FloatArray, is_inner: BoolArray, frames: Frames, curvature: FloatArray, twist: FloatArray
) -> None:
    """Fill material curvature (N, 2) and twist (N,) of a configuration (integrated, unitless)."""
    for i in range(1, q.shape[0]):
        if not is_inner[i]:
            continue
        te, tf = row(frames.tangent, i - 1), row(frames.tangent, i)
        m1e, m2e = material_directors(te, row(frames.director, i - 1), np.cos(q[i - 1, 3]), np.sin(q[i - 1, 3]))
        m1f, m2f = material_directors(tf, row(frames.director, i), np.cos(q[i, 3]), np.sin(q[i, 3]))
        kb = curvature_binormal(te, tf)
        k1, k2 = material_curvature(kb, m1e, m2e, m1f, m2f)
        curvature[i, 0] = k1
        curvature[i, 1] = k2
        twist[i] = q[i, 3] - q[i - 1, 3] + frames.reference_twist[i]

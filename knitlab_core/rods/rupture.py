"""How much a fibre is strained at its surface, and a rod cut in two."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.relaxation import rod_strains
from knitlab_core.rods.rod import Rods


def fibre_strain(q: FloatArray, rods: Rods, frames: Frames, radius: float = 1.0) -> FloatArray:
    """Return the largest strain of the fibre's surface along every edge.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and edge angles [rad].
    rods : Rods
        Rest state.
    frames : Frames
        Frames of `q`.
    radius : float
        Radius of the fibre [r]; less than 1 where a rod stands for a yarn of several.

    Returns
    -------
    (N,) array
        |axial| + radius |κ - κ_rest| [1] with the curvature at that end of the edge that bends more;
        zero where no edge leaves a node.
    """
    strain = rod_strains(q, rods, frames)
    return np.asarray(np.where(rods.has_edge, np.abs(strain[:, 0]) + _bent(strain, rods, radius), 0.0))


def bending_strain(q: FloatArray, rods: Rods, frames: Frames, radius: float = 1.0) -> FloatArray:
    """Return the part of `fibre_strain` that bending has along every edge, radius |κ - κ_rest|, shape (N,) [1]."""
    return _bent(rod_strains(q, rods, frames), rods, radius)


def _bent(strain: FloatArray, rods: Rods, radius: float) -> FloatArray:
    """Return how much bending strains a surface at that end of every edge (N,) that bends more [1]."""
    inner = rods.is_inner
    bent = np.zeros(len(strain))
    bent[inner] = radius * np.linalg.norm(strain[inner, 1:3], axis=1) / rods.span[inner]
    return np.asarray(np.where(rods.has_edge, np.maximum(bent, np.append(bent[1:], 0.0)), 0.0))


def cut_rods(rods: Rods, edge: int) -> Rods:
    """Take an edge out of its rod, and the bending and twisting at both of its nodes.

    Parameters
    ----------
    rods : Rods
        Rods with an edge there.
    edge : int
        Number of the node that the edge leaves.

    Returns
    -------
    Rods
        One rod more; all else is as before.
    """
    has_edge, is_inner = rods.has_edge.copy(), rods.is_inner.copy()
    has_edge[edge] = False
    is_inner[[edge, edge + 1]] = False
    return rods._replace(
        has_edge=has_edge,
        is_inner=is_inner,
        span=np.where(is_inner, rods.span, 0.0),
        stretch_stiffness=np.where(has_edge, rods.stretch_stiffness, 0.0),
        bend_stiffness=np.where(is_inner, rods.bend_stiffness, 0.0),
        twist_stiffness=np.where(is_inner, rods.twist_stiffness, 0.0),
    )

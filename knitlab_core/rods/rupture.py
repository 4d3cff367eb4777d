"""How much a fibre is strained at its surface, and a rod cut in two."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.relaxation import rod_strains
from knitlab_core.rods.rod import Rods, stretched_lengths


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
        |axial| + radius |κ - κ_rest| [1]: the axial strain of the edge, and the curvature of that of its two ends
        which bends more; zero where no edge leaves a node.
    """
    strain = rod_strains(q, rods, frames)
    return np.abs(_stretched(strain, rods)) + _bent(strain, rods, radius)


def axial_strain(q: FloatArray, rods: Rods, frames: Frames) -> FloatArray:
    """Return the axial strain of every edge, between the two spans that it is part of, shape (N,) [1]."""
    return _stretched(rod_strains(q, rods, frames), rods)


def _stretched(strain: FloatArray, rods: Rods) -> FloatArray:
    """Return the axial strain of every edge (N,) [1]: the mean of its halves, which belong to the nodes at its ends."""
    first, second = _halves(strain, rods)
    return np.asarray(np.where(rods.has_edge, 0.5 * (second + np.append(first[1:], 0.0)), 0.0))


def _halves(strain: FloatArray, rods: Rods) -> tuple[FloatArray, FloatArray]:
    """Return the axial strains (..., N) of the halves of every span, before its node and after it [1]."""
    before = np.append(0.0, rods.rest_length[:-1])
    share = np.where(rods.is_inner, before / np.maximum(before + rods.rest_length, np.finfo(float).tiny), 0.0)
    axial, uneven = strain[..., 0], strain[..., 4]
    return axial + (1.0 - share) * uneven, axial - share * uneven


def cut_history(history: FloatArray, rods: Rods, edge: int) -> FloatArray:
    """Return the history (M, N, 5) of rods that relax after a cut: new ends remember what their half edges do."""
    first, second = _halves(history, rods)
    cut = history.copy()
    cut[:, edge : edge + 2] = 0.0
    cut[:, edge, 0], cut[:, edge + 1, 0] = first[:, edge], second[:, edge + 1]
    return cut


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
    span = np.where(is_inner, rods.span, 0.0)
    stretched = stretched_lengths(has_edge, is_inner, rods.rest_length, span)
    return rods._replace(
        has_edge=has_edge,
        is_inner=is_inner,
        span=span,
        stretched=stretched,
        evenness=np.where(is_inner, rods.evenness, 0.0),
        stretch_stiffness=np.where(stretched > 0.0, rods.stretch_stiffness, 0.0),
        bend_stiffness=np.where(is_inner, rods.bend_stiffness, 0.0),
        twist_stiffness=np.where(is_inner, rods.twist_stiffness, 0.0),
    )

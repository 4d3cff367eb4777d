"""Least distance between surfaces, measured on the meshes.

An independent check of `knitlab_core.knits.distance`, which measures the curve: here only the meshes are
used. Parts of one fibre with less yarn between them than half the circle of its tightest
bend are always near each other and are left out, as there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from app.printing.surface import bend_radii

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from app.printing.fibres import Fibre
    from rigs.axes import FloatArray

_REFINED = 200


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rings:
    """Rings of all meshes: corners (m, sides, 3), centres (m, 3), fibre and arc length of each (m,)."""

    corners: FloatArray
    centres: FloatArray
    fibre: NDArray[np.int64]
    arc: FloatArray
    spacing: float


def mesh_gap(fibres: Sequence[Fibre]) -> float:
    """Return the least distance from a corner of a mesh to the facets of a far part, below 0 inside them [mm].

    The centres of the rings find the parts that come near, by a KD-tree; among the corners there, the 200
    nearest to the other part's axis are measured against its triangles.

    Parameters
    ----------
    fibres : sequence of Fibre
        All of equal radius and sides.

    Returns
    -------
    float
        Infinite where no fibre is long enough to meet another or itself.
    """
    rings = _rings(fibres)
    apart = np.pi * min(float(bend_radii(fibre.points).min(initial=np.inf)) for fibre in fibres)
    pairs = _near_pairs(rings, apart)
    if not len(pairs):
        return np.inf
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    corner, distance = _to_axis(rings, pairs)
    nearest = np.argsort(distance)[:_REFINED]
    points = rings.corners[pairs[nearest, 0], corner[nearest]]
    return min(_to_facets(point, rings, int(ring)) for point, ring in zip(points, pairs[nearest, 1], strict=True))


def _rings(fibres: Sequence[Fibre]) -> _Rings:
    """Return the rings of the meshes."""
    sides = fibres[0].sides
    corners = [np.asarray(one.mesh.vertices)[: len(one.points) * sides].reshape(-1, sides, 3) for one in fibres]
    centres = [ring.mean(axis=1) for ring in corners]
    steps = [np.linalg.norm(np.diff(centre, axis=0), axis=-1) for centre in centres]
    return _Rings(
        corners=np.concatenate(corners),
        centres=np.concatenate(centres),
        fibre=np.repeat(np.arange(len(fibres)), [len(centre) for centre in centres]),
        arc=np.concatenate([np.concatenate([[0.0], np.cumsum(step)]) for step in steps]),
        spacing=max(float(step.max()) for step in steps),
    )


def _near_pairs(rings: _Rings, apart: float) -> NDArray[np.int64]:
    """Return the pairs of rings (k, 2) whose distance can be the least: within a spacing of the least of centres."""
    tree = cKDTree(rings.centres)
    extent = float(np.linalg.norm(np.ptp(rings.centres, axis=0)))
    reach = 4.0 * rings.spacing
    while True:
        pairs: NDArray[np.int64] = tree.query_pairs(reach, output_type="ndarray")
        one, other = pairs.T
        pairs = pairs[(rings.fibre[one] != rings.fibre[other]) | (np.abs(rings.arc[one] - rings.arc[other]) >= apart)]
        if len(pairs):
            distance = np.linalg.norm(rings.centres[pairs[:, 0]] - rings.centres[pairs[:, 1]], axis=-1)
            enough = float(distance.min()) + rings.spacing
            if enough <= reach:
                near: NDArray[np.int64] = pairs[distance <= enough]
                return near
            reach = enough * (1.0 + 1e-9)
        elif reach > extent:
            return pairs
        else:
            reach *= 1.5


def _to_axis(rings: _Rings, pairs: NDArray[np.int64]) -> tuple[NDArray[np.int64], FloatArray]:
    """Return the corner of each pair's first ring that is nearest to the second one's axis, and its distance, (k,)."""
    centre = rings.centres[pairs[:, 1]]
    before, after = (rings.centres[_neighbour(rings, pairs[:, 1], step)] for step in (-1, 1))
    half = 0.5 * np.linalg.norm(after - before, axis=-1)[:, None]
    axis = 0.5 * (after - before) / half
    away = rings.corners[pairs[:, 0]] - centre[:, None]
    along = np.clip(np.einsum("ijk,ik->ij", away, axis), -half, half)
    away -= along[..., None] * axis[:, None]
    distance = np.linalg.norm(away, axis=-1)
    corner = np.argmin(distance, axis=1)
    return corner, distance[np.arange(len(pairs)), corner]


def _to_facets(point: FloatArray, rings: _Rings, ring: int) -> float:
    """Return the signed distance of a point from the band of triangles on both sides of a ring."""
    numbers = np.array([_neighbour(rings, np.array([ring]), step)[0] for step in (-2, -1, 0, 1, 2)])
    band = rings.corners[np.unique(numbers)]
    turned = np.roll(band, -1, axis=1)
    lower = np.stack([band[:-1], turned[:-1], turned[1:]], axis=-2)
    upper = np.stack([band[:-1], turned[1:], band[1:]], axis=-2)
    triangles = np.concatenate([lower, upper]).reshape(-1, 3, 3)
    closest = trimesh.triangles.closest_point(triangles, np.broadcast_to(point, (len(triangles), 3)))
    distance = np.linalg.norm(point - closest, axis=-1)
    best = int(np.argmin(distance))
    normal = np.cross(triangles[best, 1] - triangles[best, 0], triangles[best, 2] - triangles[best, 0])
    return float(np.copysign(distance[best], normal @ (point - closest[best])))


def _neighbour(rings: _Rings, ring: NDArray[np.int64], step: int) -> NDArray[np.int64]:
    """Return the ring `step` further on, or the nearest one that is on the same fibre."""
    found = ring.copy()
    for _ in range(abs(step)):
        beyond = np.clip(found + (1 if step > 0 else -1), 0, len(rings.fibre) - 1)
        found = np.where(rings.fibre[beyond] == rings.fibre[ring], beyond, found)
    return found

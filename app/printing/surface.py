"""Sweep of a circle along a polyline: a closed tube of triangles.

`app.views.tubes` hands pictures a centreline and leaves the tube to VTK, which neither bounds its error nor runs
without the extra for pictures; nothing of it fits here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np
import trimesh

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rigs.axes import FloatArray

FEWEST_SIDES: Final = 8


def sides_for(radius: float, tolerance: float) -> int:
    """Return how many sides keep a circle's chords within a tolerance, ``r (1 - cos(pi/n)) <= tolerance``.

    Examples
    --------
    >>> sides_for(0.4, 0.01)
    15
    """
    if tolerance >= radius:
        return FEWEST_SIDES
    return max(FEWEST_SIDES, math.ceil(math.pi / math.acos(1.0 - tolerance / radius)))


def tangents(points: FloatArray) -> FloatArray:
    """Return unit tangents of a smooth curve at points on it, second order in their spacing, (m, 3) -> (m, 3)."""
    along = _arcs(points)
    slope = np.gradient(points, along, axis=0, edge_order=2 if len(points) > 2 else 1)
    unit: FloatArray = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    return unit


def bend_radii(points: FloatArray) -> FloatArray:
    """Return the radius of the circle through each inner point and its neighbours, (m, 3) -> (m - 2,)."""
    before, after = np.diff(points[:-1], axis=0), np.diff(points[1:], axis=0)
    across = np.linalg.norm(points[2:] - points[:-2], axis=-1)
    doubled = np.linalg.norm(np.cross(before, after), axis=-1)
    sizes = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1) * across
    straight = np.full(len(sizes), np.inf)
    radii: FloatArray = np.divide(sizes, 2.0 * doubled, out=straight, where=doubled > 0.0)
    return radii


def frames(points: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit normals per point with the least rotation about the curve.

    Any normals are laid down first, then turned by the sum of the angles at which the double reflection of
    one misses the next: no loop, and no flip, for a normal's own choice cancels.

    Parameters
    ----------
    points, along : FloatArray
        Points (m, 3) and unit tangents (m, 3).

    Returns
    -------
    tuple of FloatArray
        Normals e1 and e2 = along x e1, each (m, 3).

    References
    ----------
    Wang, Jüttler, Zheng and Liu, "Computation of rotation minimizing frames", ACM Trans. Graphics 27 (2008),
    section 3: double reflection.
    """
    least = np.eye(3)[np.argmin(np.abs(along), axis=-1)]
    first = np.cross(along, least)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(along, first)
    step = np.diff(points, axis=0)
    carried = _reflect(first[:-1], step)
    carried = _reflect(carried, along[1:] - _reflect(along[:-1], step))
    missed = np.arctan2(np.sum(carried * second[1:], axis=-1), np.sum(carried * first[1:], axis=-1))
    turn = np.concatenate([[0.0], np.cumsum(missed)])[:, None]
    return np.cos(turn) * first + np.sin(turn) * second, np.cos(turn) * second - np.sin(turn) * first


def tube_mesh(points: FloatArray, radius: float, sides: int) -> trimesh.Trimesh:
    """Sweep a regular polygon along a curve and close both ends flat.

    Rings stand across the curve at each point, their corners on the tube: facets lie inside it, but for those on
    the inner side of a bend, whose chords along the tube pass outside. Ends are flat, for the fibre to be as long
    as its centreline and its volume area times length (Pappus).

    Parameters
    ----------
    points : FloatArray
        Points (m, 3) on the smooth centreline, two or more, with turns well under 90 degrees between them [mm].
    radius : float
        Radius of the tube [mm].
    sides : int
        Corners of the polygon, three or more.

    Returns
    -------
    Trimesh
        Closed, outward, 2 m sides triangles; its vertices are the rings one after the other, then both end points.

    Raises
    ------
    SpecificationError
        If it cannot be swept.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2 or not np.isfinite(points).all():
        raise SpecificationError("points", points.shape, "two or more finite points (m, 3)")
    step = np.diff(points, axis=0)
    if not step.any(axis=-1).all() or (np.sum(step[1:] * step[:-1], axis=-1) <= 0.0).any():
        found = "neighbours that are equal, or a turn of 90 degrees or more at one point"
        raise SpecificationError("points", found, "points that advance along a smooth curve")
    if not radius > 0.0 or sides < 3:
        raise SpecificationError("tube", f"radius {radius:g} mm, {sides} sides", "a radius above 0 mm, 3 sides or more")
    first, second = frames(points, tangents(points))
    angle = 2.0 * np.pi * np.arange(sides) / sides
    spokes = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    rings = points[:, None] + radius * spokes
    vertices = np.concatenate([rings.reshape(-1, 3), points[[0, -1]]])
    return trimesh.Trimesh(vertices=vertices, faces=_faces(len(points), sides), process=False)


def _faces(rings: int, sides: int) -> NDArray[np.int64]:
    """Return the triangles (2 rings sides, 3): sides of the tube, then the fans of both ends."""
    corner = np.arange(sides)
    after = (corner + 1) % sides
    base = sides * np.arange(rings - 1)[:, None]
    lower = np.stack([base + corner, base + after, base + sides + after], axis=-1)
    upper = np.stack([base + corner, base + sides + after, base + sides + corner], axis=-1)
    start, last = rings * sides, (rings - 1) * sides
    head = np.stack([np.full(sides, start), after, corner], axis=-1)
    tail = np.stack([np.full(sides, start + 1), last + corner, last + after], axis=-1)
    return np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3), head, tail]).astype(np.int64)


def _arcs(points: FloatArray) -> FloatArray:
    """Return the length of the polyline up to each point, (m, 3) -> (m,)."""
    arcs: FloatArray = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=-1))])
    return arcs


def _reflect(vectors: FloatArray, normal: FloatArray) -> FloatArray:
    """Reflect vectors (m, 3) in the planes across normals (m, 3) of any length but 0."""
    share = 2.0 * np.sum(vectors * normal, axis=-1) / np.sum(normal * normal, axis=-1)
    reflected: FloatArray = vectors - share[:, None] * normal
    return reflected

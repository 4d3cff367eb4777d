"""Surfaces of a specimen's fibres, as fine as a printer needs them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from app.printing.surface import bend_radii, sides_for, tube_mesh
from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fibres import fibre_strands

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import trimesh

    from knitlab_core.knits import Specimen
    from rigs.axes import FloatArray

MOST_TRIANGLES: Final = 5_000_000
"""Some 3.7 GB while they are checked and written, 250 MB as STL."""

_LOOKS_PER_DIAMETER: Final = 8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fibre:
    """A fibre and its surface.

    Attributes
    ----------
    points : FloatArray
        Where its rings stand, (m, 3) on the smooth centreline [mm].
    radius : float
        Its radius [mm].
    sides : int
        Corners of a ring.
    mesh : Trimesh
        Its closed surface [mm].
    """

    points: FloatArray
    radius: float
    sides: int
    mesh: trimesh.Trimesh


def specimen_fibres(specimen: Specimen, chord_error: float) -> tuple[Fibre, ...]:
    """Make the surface of a specimen as printed, its lowest corner at the origin of the tray.

    Parameters
    ----------
    specimen : Specimen
        Every fibre of its yarn is printed, however the solver sees the yarn, and along the smooth centreline, not
        the solver's nodes.
    chord_error : float
        How far the mesh may lie off the true tube [m].

    Returns
    -------
    tuple of Fibre

    Raises
    ------
    SpecificationError
        If it would take more than `MOST_TRIANGLES`; nothing was allocated then.
    """
    if not 0.0 < chord_error < math.inf:
        raise SpecificationError("chord_error", f"{chord_error:g} m", "a length above 0 m")
    curve, yarn, unit = specimen.centreline, specimen.yarn, specimen.loop_width

    def lay(s: FloatArray) -> tuple[FloatArray, ...]:
        return fibre_strands(curve, s, yarn)

    arcs = ring_arcs(lay, curve.length, yarn.fibre_radius, chord_error / unit, twist=yarn.twist)
    return make_fibres([1e3 * unit * points for points in lay(arcs)], 1e3 * unit * yarn.fibre_radius, 1e3 * chord_error)


def make_fibres(strands: Sequence[FloatArray], radius: float, chord_error: float) -> tuple[Fibre, ...]:
    """Make the surfaces of strands of equal radius, moved together so that their lowest corner is the origin.

    Parameters
    ----------
    strands : sequence of FloatArray
        Points (m, 3) of each, spaced as `ring_arcs` says [mm].
    radius, chord_error : float
        Radius and how far the mesh may lie off the tube [mm].

    Returns
    -------
    tuple of Fibre
    """
    sides = sides_for(radius, 0.5 * chord_error)
    _budget(sum(len(points) for points in strands), sides)
    meshes = [tube_mesh(points, radius, sides) for points in strands]
    corner = np.min([mesh.bounds[0] for mesh in meshes], axis=0)
    for mesh in meshes:
        mesh.apply_translation(-corner)
    return tuple(
        Fibre(points=points - corner, radius=radius, sides=sides, mesh=mesh)
        for points, mesh in zip(strands, meshes, strict=True)
    )


def ring_arcs(
    lay: Callable[[FloatArray], Sequence[FloatArray]],
    length: float,
    radius: float,
    chord_error: float,
    *,
    twist: float = 0.0,
) -> FloatArray:
    """Return the arc lengths of a tube's rings along a yarn, closer together where it bends more.

    On frames that do not turn about the curve, the edges along a tube are chords of curves parallel to it: between
    rings ``ds`` apart they miss it by ``ds² k (1 + k r)/8`` on the outer side of a bend, and less on the inner one.
    The errors along and around add up; half each is what takes the fewest triangles. The mesh then lies up to the
    whole error inside the tube, and up to half of it outside. Rings are at most a diameter apart.

    Parameters
    ----------
    lay : callable
        Returns the points (m, 3) of every fibre beside the arc lengths (m,) of the yarn it is given.
    length : float
        Of the yarn.
    radius, chord_error : float
        Radius of the tubes and the error allowed; all lengths in one unit.
    twist : float
        Angle by which fibres wind about the yarn per length [rad]: they are looked at four times a radian.

    Returns
    -------
    FloatArray, shape (m,)
        Arc lengths of the yarn, both ends among them.

    Raises
    ------
    SpecificationError
        If a tube would take more than `MOST_TRIANGLES`.
    """
    sides = sides_for(radius, 0.5 * chord_error)
    looks = length * max(0.5 * _LOOKS_PER_DIAMETER / radius, 4.0 * abs(twist))
    _budget(math.ceil(looks / _LOOKS_PER_DIAMETER), sides)
    s = np.linspace(0.0, length, math.ceil(looks) + 3)
    needed = np.max([_rings_between(points, radius, chord_error) for points in lay(s)], axis=0)
    rings = np.concatenate([[0.0], np.cumsum(needed)])
    wanted = math.ceil(rings[-1])
    _budget(wanted + 1, sides)
    return np.interp(np.linspace(0.0, rings[-1], wanted + 1), rings, s)


def _rings_between(points: FloatArray, radius: float, chord_error: float) -> FloatArray:
    """Return how many rings, in parts of one, a tube needs between its points, (m, 3) -> (m - 1,)."""
    bend = 1.0 / bend_radii(points)
    bend = np.concatenate([bend[:1], np.maximum(bend[1:], bend[:-1]), bend[-1:]])
    per_length = np.maximum(np.sqrt(bend * (1.0 + bend * radius) / (4.0 * chord_error)), 0.5 / radius)
    rings: FloatArray = per_length * np.linalg.norm(np.diff(points, axis=0), axis=-1)
    return rings


def _budget(rings: int, sides: int) -> None:
    """Raise if a mesh would have more triangles than are allowed."""
    triangles = 2 * rings * sides
    if triangles > MOST_TRIANGLES:
        allowed = f"at most {MOST_TRIANGLES} triangles: a smaller knit or a larger chord error"
        raise SpecificationError("surface", f"{triangles} triangles", allowed)

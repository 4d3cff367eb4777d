"""Checks of a knit's surface: closed, clear of itself, and within the printer's limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from trimesh.graph import connected_component_labels

from app.printing.gap import mesh_gap
from app.printing.surface import bend_radii

if TYPE_CHECKING:
    from collections.abc import Sequence

    import trimesh

    from app.printing.fibres import Fibre
    from rigs.axes import FloatArray
    from rigs.machines.printer import PrinterData


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """A figure beside its allowed range.

    Attributes
    ----------
    name : str
        What was checked.
    found : float
        The figure [unit].
    least, most : float
        Bounds of what is allowed, both included [unit].
    unit : str
        ``mm`` or ``1``.
    note : str
        Where the bound comes from.
    """

    name: str
    found: float
    least: float = -math.inf
    most: float = math.inf
    unit: str = "1"
    note: str = ""

    @property
    def met(self) -> bool:
        """Whether the figure is allowed; never for NaN."""
        return self.least <= self.found <= self.most


def surface_checks(fibres: Sequence[Fibre], chord_error: float) -> list[Check]:
    """Check that each fibre's surface is one closed, manifold, outward tube of the right volume.

    Parameters
    ----------
    fibres : sequence of Fibre
        The fibres.
    chord_error : float
        How far their meshes may lie off the true tubes [mm].

    Returns
    -------
    list of Check
        Edges counted over all fibres; of the rest the fibre that is farthest off.
    """
    edges = [_edge_faults(fibre.mesh) for fibre in fibres]
    pieces = [_pieces(fibre.mesh) for fibre in fibres]
    euler = [fibre.mesh.euler_number for fibre in fibres]
    volumes = [_volume_share(fibre) for fibre in fibres]
    least = (1.0 - min(1.0, chord_error / fibres[0].radius)) ** 2
    return [
        Check(name="edges not of two faces", found=sum(open_ for open_, _ in edges), most=0),
        Check(name="edges of turned faces", found=sum(turned for _, turned in edges), most=0),
        Check(name="pieces of a fibre", found=max(pieces), least=1, most=1),
        Check(name="Euler characteristic", found=_farthest(euler, 2.0), least=2, most=2),
        Check(
            name="volume / (π r² L)",
            found=_farthest(volumes, 0.5 * (least + 1.0)),
            least=least,
            most=1.0,
            note="the chord error's",
        ),
    ]


def printer_checks(fibres: Sequence[Fibre], printer: PrinterData, clearance: float | None) -> list[Check]:
    """Check that a printer can make the fibres, and that they do not meet.

    Parameters
    ----------
    fibres : sequence of Fibre
        The fibres.
    printer : PrinterData
        What it can resolve.
    clearance : float or None
        Least distance between surfaces by the centreline itself [mm], where it is known.

    Returns
    -------
    list of Check
    """
    least = 1e3 * printer.clearance.value
    feature = 1e3 * printer.smallest_feature.value
    radius = fibres[0].radius
    bend = min(float(bend_radii(fibre.points).min(initial=np.inf)) for fibre in fibres)
    of_gap = "assumed" if printer.clearance.assumed else ""
    of_feature = "assumed" if printer.smallest_feature.assumed else ""
    checks = [
        Check(name="fibre diameter", found=2.0 * radius, least=feature, unit="mm", note=of_feature),
        Check(name="radius of tightest bend", found=bend, least=radius, unit="mm", note="the fibre's own"),
    ]
    if clearance is not None:
        checks.append(Check(name="gap by the centreline", found=clearance, least=least, unit="mm", note=of_gap))
    found = mesh_gap(fibres)
    return [*checks, Check(name="gap by the mesh", found=found, least=least, unit="mm", note=of_gap)]


def _edge_faults(mesh: trimesh.Trimesh) -> tuple[int, int]:
    """Return how many edges lack two faces, and how many have two faces of the same direction."""
    inverse = mesh.edges_unique_inverse
    faces = np.bincount(inverse)
    forward = mesh.edges[:, 0] < mesh.edges[:, 1]
    ways = np.bincount(inverse, weights=np.where(forward, 1.0, -1.0))
    return int(np.count_nonzero(faces != 2)), int(np.count_nonzero((faces == 2) & (ways != 0.0)))


def _pieces(mesh: trimesh.Trimesh) -> int:
    """Return how many parts a mesh falls into."""
    used = np.unique(mesh.faces)
    labels = connected_component_labels(mesh.edges_unique, node_count=len(mesh.vertices))
    return len(np.unique(labels[used]))


def _farthest(values: Sequence[float], middle: float) -> float:
    """Return the value that is farthest from the middle of the allowed range."""
    return max(values, key=lambda value: abs(value - middle))


def _volume_share(fibre: Fibre) -> float:
    """Return the volume of a mesh relative to its tube's, area times length of the smooth centreline."""
    return float(fibre.mesh.volume) / (math.pi * fibre.radius**2 * smooth_length(fibre.points))


def smooth_length(points: FloatArray) -> float:
    """Return the length of the smooth curve through points: each chord and its arc's excess, ``k² c³/24``."""
    chords = np.linalg.norm(np.diff(points, axis=0), axis=-1)
    bend = 1.0 / bend_radii(points)
    if not len(bend):
        return float(chords.sum())
    at_ends = np.concatenate([bend[:1], bend, bend[-1:]])
    squared = 0.5 * (at_ends[:-1] ** 2 + at_ends[1:] ** 2)
    return float(np.sum(chords + squared * chords**3 / 24.0))

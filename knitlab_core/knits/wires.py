"""Wires through the boundary loops of a planar knit: one for every hook that has a loop to hang it on.

A wire is across the knit's plane, inside its loop, and almost touches the yarn at the apex: when its carriage
draws it outwards it takes the loop along. The two wires of a loop are side by side. Apart, the first pull would
draw them together: on poles that hardly rub, yarn that runs from one to the other leaves them nothing to hold on to.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.crossing import crossing_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.centreline import SiteSet
    from knitlab_core.knits.specimen import Specimen

GAP: Final = 0.05
"""Room between the surfaces of wire and yarn as mounted [contact radii]: a little more than where they feel it."""

HALF_LENGTH: Final = 10.0
"""Half the length of a wire [contact radii]: twice the depth of a loop."""

OUTWARDS: Final[Mapping[SiteSet, tuple[float, float]]] = MappingProxyType(
    {"course-": (-1.0, 0.0), "course+": (1.0, 0.0), "wale-": (0.0, -1.0), "wale+": (0.0, 1.0)}
)
"""Direction in which the hooks of an edge are drawn, in the plane."""

_SAMPLES: Final = 129
_PUSHES: Final = 20


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoopWires:
    """Wires through one boundary loop: two, or one where the knit's corner leaves half a loop.

    Parameters
    ----------
    hooks : tuple of int
        Which of their edge's hooks they are, counted as its sites.
    nodes : tuple of (n, 3) arrays
        Nodes of each, along +z [m].
    """

    hooks: tuple[int, ...]
    nodes: tuple[FloatArray, ...]


def wires_through(specimen: Specimen, edge: SiteSet) -> tuple[LoopWires, ...]:
    """Put wires as thick as the yarn through the loops of an edge of a planar knit.

    The loop of a wale edge is a head or a sinker, that of a course edge a turn-around. Sites near an end of the yarn
    have no wire: what hangs there is no loop.

    Parameters
    ----------
    specimen : Specimen
        The knit as it was made.
    edge : SiteSet
        One of its four edges.

    Raises
    ------
    SpecificationError
        If the knit is volumetric.
    GeometryError
        If a wire would overlap the yarn or another wire, or its loop does not go around it.
    """
    radius, outwards = specimen.radius / specimen.loop_width, np.array(OUTWARDS[edge])
    length = specimen.centreline.length
    yarn = specimen.centreline.position(np.linspace(0.0, length, round(4.0 * length / radius)))
    middles: list[FloatArray] = []
    found = []
    for hooks in _loops(specimen, edge):
        wires = []
        for apex, side in hooks.values():
            beside = side * (1.0 + 0.5 * GAP) * radius * np.abs(outwards[::-1])
            middle = specimen.centreline.position(np.array([apex]))[0]
            middle[:2] += beside
            middle[:2] = _clear(specimen, yarn, middle, outwards)
            _check(specimen, apex, yarn, middle, middles)
            middles.append(middle)
            wires.append(_straight(specimen, middle))
        found.append(LoopWires(hooks=tuple(hooks), nodes=tuple(wires)))
    return tuple(found)


def _loops(specimen: Specimen, edge: SiteSet) -> list[dict[int, tuple[float, float]]]:
    """Return for each loop of an edge its hooks, and for each of these the apex [loop widths] and the hook's side."""
    line, distances = specimen.centreline, specimen.fabric.apex_distances
    if edge not in distances:
        raise SpecificationError("hook", f"wire in {_kind(specimen)}", "pin: wires hold the loops of planar knits")
    far, quarter = distances[edge], 0.25 * specimen.fabric.loop_length(specimen.counts)
    along = 1 if edge.startswith("course") else 0
    loops: list[dict[int, tuple[float, float]]] = []
    for hook, site in enumerate(one for one in line.sites if one.set == edge):
        if not quarter < site.arc_length < line.length - quarter:
            continue
        at = np.array([site.arc_length])
        apex = site.arc_length + far * float(np.sign(line.tangent(at)[0, :2] @ OUTWARDS[edge]))
        side = float(np.sign(line.position(at)[0, along] - line.position(np.array([apex]))[0, along]))
        before = next(iter(loops[-1].values()))[0] if loops else -np.inf
        if abs(apex - before) > 0.5 * far:
            loops.append({})
        loops[-1][hook] = apex, side
    return loops


def _clear(specimen: Specimen, yarn: FloatArray, middle: FloatArray, outwards: FloatArray) -> FloatArray:
    """Return the place (2,) of a wire that is pushed inwards from a point on the yarn until it is clear of it."""
    radius = specimen.radius / specimen.loop_width
    wanted = (2.0 + GAP) * radius
    near = yarn[np.linalg.norm(yarn - middle, axis=1) < 4.0 * wanted, :2]
    place = middle[:2] - wanted * outwards
    for _ in range(_PUSHES):
        place = place - max(wanted - float(np.linalg.norm(near - place, axis=1).min(initial=np.inf)), 0.0) * outwards
    return place


def _check(specimen: Specimen, apex: float, yarn: FloatArray, middle: FloatArray, others: list[FloatArray]) -> None:
    """Refuse a wire that overlaps yarn or other wires of its edge, or that its loop does not go around."""
    line, radius = specimen.centreline, specimen.radius / specimen.loop_width
    half, quarter = HALF_LENGTH * radius, 0.25 * specimen.fabric.loop_length(specimen.counts)
    place = line.place(apex)
    beside = yarn[np.abs(yarn[:, 2] - middle[2]) < half + 2.0 * radius]
    gaps = [float(np.linalg.norm(beside[:, :2] - middle[:2], axis=1).min(initial=np.inf)) - 2.0 * radius]
    gaps += [float(np.linalg.norm(other[:2] - middle[:2])) - 2.0 * radius for other in others]
    if min(gaps) < 0.0:
        found = f"a wire that overlaps by {-1e3 * min(gaps) * specimen.loop_width:.2g} mm at {place}"
        raise GeometryError("hook", found, "pin, or a knit whose boundary loops have room for wires")
    loop = line.position(np.linspace(apex - quarter, apex + quarter, _SAMPLES))
    wire = middle + np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    if crossing_number(loop, wire) == 0:
        raise GeometryError("hook", f"a wire that is not inside the loop at {place}", "pin")


def _straight(specimen: Specimen, middle: FloatArray) -> FloatArray:
    """Return the nodes (n, 3) of a wire [m] with a middle [loop widths], as far apart as the yarn's."""
    edge = float(np.diff(specimen.arc_lengths).mean()) / specimen.radius
    count = 2 * round(HALF_LENGTH / edge) + 1
    centred: FloatArray = middle - specimen.fabric.middle(specimen.counts)
    nodes: FloatArray = np.tile(centred * specimen.loop_width, (count, 1))
    nodes[:, 2] += specimen.radius * HALF_LENGTH * np.linspace(-1.0, 1.0, count)
    return nodes


def _kind(specimen: Specimen) -> str:
    """Return what a fabric without loops for wires is."""
    if specimen.fabric.straight:
        return "a straight filament"
    return "a volumetric knit" if "P" in specimen.fabric.axes else "a fabric whose loops are not known"

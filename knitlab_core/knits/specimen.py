"""Cut a knit to size: nodes in metres, checked to be clear of itself and really knitted."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.linalg import solve_banded

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.clasp import stitch_clasp
from knitlab_core.knits.clearance import check_clearance
from knitlab_core.knits.stitch import is_positive
from knitlab_core.knits.stockinette import check_count, knit_middle, stockinette

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch

FEWEST_NODES_PER_LOOP: Final = 8
MOST_NODES_PER_LOOP: Final = 1000
MOST_NODES: Final = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Specimen:
    """Hold a knit as the solver takes it: one yarn of nodes, centred on 0, in SI units.

    Parameters
    ----------
    nodes : FloatArray
        Positions (N, 3) along the yarn: x course, y wale, z out of plane [m]. The quadratic B-spline that they
        control passes through the yarn, so a node lies outside a bend by edge² curvature / 8.
    arc_lengths : FloatArray
        Yarn length (N,) from the yarn's start to each node [m].
    radius : float
        Fibre radius [m].
    loop_width : float
        The stitch's unit of length [m].
    rows, loops : int
        Counts along wale and course.
    stitch : Stitch
        The loop.
    centreline : Centreline
        The smooth yarn [loop widths], not centred.
    yarn_length : float
        Whole length, turn-arounds included [m].
    clearance : float
        Least distance between the surfaces of strands [m].
    sites : Mapping of str to IntArray
        Node indices of each set of boundary sites, along +x (``wale``) or +y (``course``).
    """

    nodes: FloatArray
    arc_lengths: FloatArray
    radius: float
    loop_width: float
    rows: int
    loops: int
    stitch: Stitch
    centreline: Centreline
    yarn_length: float
    clearance: float
    sites: Mapping[SiteSet, IntArray]


def planar_specimen(stitch: Stitch, *, rows: int, loops: int, loop_width: float, nodes_per_loop: int = 48) -> Specimen:
    """Build a planar stockinette specimen and refuse one that cannot exist.

    The yarn is divided at its boundary sites; between two of them edges are equal in arc length and as near as
    their whole number allows to ``yarn_per_loop / nodes_per_loop``. Every site is a node.

    Parameters
    ----------
    stitch : Stitch
        The loop.
    rows, loops : int
        1 to 200 each.
    loop_width : float
        l [m].
    nodes_per_loop : int
        8 to 1000; the mesh as a whole has at most 2 million nodes.

    Returns
    -------
    Specimen

    Raises
    ------
    SpecificationError
        If a value is out of its bounds.
    GeometryError
        If strands overlap (it names both places), the yarn bends tighter than its own radius, or rows do not
        hold each other.
    """
    if not is_positive(loop_width):
        raise SpecificationError("specimen.loop_width", loop_width, "a length above 0 m")
    check_count("specimen.nodes_per_loop", nodes_per_loop, most=MOST_NODES_PER_LOOP, least=FEWEST_NODES_PER_LOOP)
    centreline = stockinette(stitch, rows=rows, loops=loops)
    at_sites = np.sort([site.arc_length for site in centreline.sites])
    edges = _edge_counts(np.diff(at_sites), yarn_per_loop(stitch) / nodes_per_loop)
    if edges.sum() >= MOST_NODES:
        raise SpecificationError("specimen", f"{edges.sum() + 1} nodes", f"a mesh of at most {MOST_NODES} nodes")
    approach = check_clearance(stitch, rows=rows, loops=loops, loop_width=loop_width)
    if rows > 1 and stitch_clasp(stitch) == 0:
        allowed = "a row spacing, height and depth with which each loop holds the next row's"
        raise GeometryError("specimen.knit", "rows that do not hold each other", allowed)
    arc_lengths = _divide(at_sites, edges)
    on_yarn = (centreline.position(arc_lengths) - knit_middle(stitch, rows, loops)) * loop_width
    return Specimen(
        nodes=control_points(on_yarn),
        arc_lengths=arc_lengths * loop_width,
        radius=stitch.fibre_radius * loop_width,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        stitch=stitch,
        centreline=centreline,
        yarn_length=centreline.length * loop_width,
        clearance=(approach.distance - 2.0 * stitch.fibre_radius) * loop_width,
        sites=_site_nodes(centreline, at_sites, edges),
    )


def control_points(points: FloatArray) -> FloatArray:
    """Return nodes (N, 3) whose quadratic B-spline passes through points on the yarn; the ends stay.

    A spline with its nodes on the yarn cuts every bend; at 48 nodes per loop that costs 5 to 9 % of the force.
    """
    bands = np.full((3, len(points)), 0.125)
    bands[1] = 0.75
    bands[1, [0, -1]] = 1.0
    bands[0, 1] = bands[2, -2] = 0.0
    nodes: FloatArray = solve_banded((1, 1), bands, points)
    return nodes


def _site_nodes(centreline: Centreline, at_sites: FloatArray, edges: IntArray) -> Mapping[SiteSet, IntArray]:
    first_of_stretch = np.concatenate([[0], np.cumsum(edges)])
    arcs: dict[SiteSet, list[float]] = {}
    for site in centreline.sites:
        arcs.setdefault(site.set, []).append(site.arc_length)
    return MappingProxyType({edge: first_of_stretch[np.searchsorted(at_sites, arc)] for edge, arc in arcs.items()})


def _edge_counts(stretches: FloatArray, wanted: float) -> IntArray:
    """Return how many equal edges of each stretch are nearest in length to the wanted one."""
    fewer = np.maximum(np.floor(stretches / wanted), 1.0)
    long, short = stretches / fewer, stretches / (fewer + 1.0)
    counts = np.where(np.abs(long - wanted) <= np.abs(short - wanted), fewer, fewer + 1.0)
    return counts.astype(np.int64)


def _divide(ends: FloatArray, counts: IntArray) -> FloatArray:
    """Return the ends (k + 1,) with each stretch between them divided evenly (sum(counts) + 1,)."""
    stretch = np.repeat(np.arange(counts.size), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    inner = ends[stretch] + np.diff(ends)[stretch] * (within / counts[stretch])
    return np.append(inner, ends[-1])

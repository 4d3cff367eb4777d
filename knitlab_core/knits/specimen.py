"""Cut a knit to size: nodes in metres, checked to be clear of itself and really knitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.clasp import stitch_clasp
from knitlab_core.knits.clearance import check_clearance, check_volumetric_clearance
from knitlab_core.knits.mesh import control_points, yarn_mesh
from knitlab_core.knits.stitch import is_positive
from knitlab_core.knits.stockinette import check_count, knit_middle, stockinette
from knitlab_core.knits.volumetric import volumetric, volumetric_middle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.mesh import Mesh
    from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch
    from knitlab_core.knits.volumetric_stitch import VolumetricStitch

FEWEST_NODES_PER_LOOP: Final = 8
MOST_NODES_PER_LOOP: Final = 1000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Specimen:
    """Hold a knit as the solver takes it: one yarn of nodes, centred on 0, in SI units.

    Parameters
    ----------
    nodes : FloatArray
        Positions (N, 3) along the yarn: x course, y wale, z pile or out of plane [m]. The quadratic B-spline that they
        control passes through the yarn, so a node lies outside a bend by edge² curvature / 8.
    arc_lengths : FloatArray
        Yarn length (N,) from the yarn's start to each node [m].
    radius : float
        Fibre radius [m].
    loop_width : float
        The stitch's unit of length [m].
    rows, loops, layers : int
        Counts along wale, course and pile; one layer is planar unless its stitch is volumetric.
    stitch : Stitch or VolumetricStitch
        The loop, or the stitch of two loops.
    centreline : Centreline
        The smooth yarn [loop widths], not centred.
    yarn_length : float
        Whole length, turn-arounds included [m].
    clearance : float
        Least distance between the surfaces of strands [m].
    sites : Mapping of str to IntArray
        Node indices of each set of boundary sites, along +x (``wale``) or +y (``course``), on the faces of a
        volumetric knit by layer, row and +x; only such a knit has ``pile+`` and ``pile-``.
    """

    nodes: FloatArray
    arc_lengths: FloatArray
    radius: float
    loop_width: float
    rows: int
    loops: int
    layers: int
    stitch: Stitch | VolumetricStitch
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
    _check_size(loop_width, nodes_per_loop)
    centreline = stockinette(stitch, rows=rows, loops=loops)
    mesh = yarn_mesh(centreline, yarn_per_loop(stitch) / nodes_per_loop)
    approach = check_clearance(stitch, rows=rows, loops=loops, loop_width=loop_width)
    if rows > 1 and stitch_clasp(stitch) == 0:
        allowed = "a row spacing, height and depth with which each loop holds the next row's"
        raise GeometryError("specimen.knit", "rows that do not hold each other", allowed)
    return Specimen(
        nodes=_nodes(centreline, mesh, knit_middle(stitch, rows, loops), loop_width),
        arc_lengths=mesh.arc_lengths * loop_width,
        radius=stitch.fibre_radius * loop_width,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=1,
        stitch=stitch,
        centreline=centreline,
        yarn_length=centreline.length * loop_width,
        clearance=(approach.distance - 2.0 * stitch.fibre_radius) * loop_width,
        sites=mesh.sites,
    )


def volumetric_specimen(
    stitch: VolumetricStitch, *, rows: int, loops: int, layers: int, loop_width: float, nodes_per_loop: int = 48
) -> Specimen:
    """Build a volumetric specimen and refuse one that cannot exist.

    It is meshed as a planar one, with the mean of wale and pile loop for the nominal edge; 6x6x6 stitches make
    about 21,000 nodes. Here the whole yarn is searched for overlap.

    Parameters
    ----------
    stitch : VolumetricStitch
        The stitch.
    rows, loops, layers : int
        Rows, stitches per row (two loops each) and layers, 1 to 200 each.
    loop_width : float
        l [m].
    nodes_per_loop : int
        8 to 1000, for each of a stitch's two loops; the mesh as a whole has at most 2 million nodes.

    Returns
    -------
    Specimen

    Raises
    ------
    SpecificationError
        If a value is out of its bounds.
    GeometryError
        If strands overlap (it names both places), the yarn bends tighter than its own radius, or rows or layers
        do not hold each other.
    """
    _check_size(loop_width, nodes_per_loop)
    centreline = volumetric(stitch, rows=rows, loops=loops, layers=layers)
    per_loop = 0.5 * (yarn_per_loop(stitch.wale_loop) + yarn_per_loop(stitch.pile_loop))
    mesh = yarn_mesh(centreline, per_loop / nodes_per_loop)
    middle = volumetric_middle(stitch, rows, loops, layers)
    for count, loop, joined in ((rows, stitch.wale_loop, "rows"), (layers, stitch.pile_loop, "layers")):
        if count > 1 and stitch_clasp(loop) == 0:
            allowed = f"spacings, heights and a depth with which loops hold the next of the {joined}"
            raise GeometryError("specimen.knit", f"{joined} that do not hold each other", allowed)
    approach = check_volumetric_clearance(stitch, centreline, middle=middle, loop_width=loop_width)
    return Specimen(
        nodes=_nodes(centreline, mesh, middle, loop_width),
        arc_lengths=mesh.arc_lengths * loop_width,
        radius=stitch.fibre_radius * loop_width,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=layers,
        stitch=stitch,
        centreline=centreline,
        yarn_length=centreline.length * loop_width,
        clearance=(approach.distance - 2.0 * stitch.fibre_radius) * loop_width,
        sites=mesh.sites,
    )


def _check_size(loop_width: float, nodes_per_loop: int) -> None:
    if not is_positive(loop_width):
        raise SpecificationError("specimen.loop_width", loop_width, "a length above 0 m")
    check_count("specimen.nodes_per_loop", nodes_per_loop, most=MOST_NODES_PER_LOOP, least=FEWEST_NODES_PER_LOOP)


def _nodes(centreline: Centreline, mesh: Mesh, middle: FloatArray, loop_width: float) -> FloatArray:
    """Return the control points (N, 3) of the yarn about its middle [m]."""
    return control_points((centreline.position(mesh.arc_lengths) - middle) * loop_width)

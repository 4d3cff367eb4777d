"""Cut a knit to size: nodes in metres, checked to be clear of itself and really knitted."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.clasp import stitch_clasp
from knitlab_core.knits.clearance import check_clearance, check_volumetric_clearance
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn, check_turn, fibre_sites, fibre_strands
from knitlab_core.knits.filament import filament_line
from knitlab_core.knits.mesh import control_points, yarn_mesh
from knitlab_core.knits.stitch import is_positive
from knitlab_core.knits.stockinette import check_count, knit_middle, stockinette
from knitlab_core.knits.volumetric import volumetric, volumetric_middle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.filament import Filament
    from knitlab_core.knits.mesh import Mesh
    from knitlab_core.knits.stitch import FloatArray, IntArray, Stitch
    from knitlab_core.knits.volumetric_stitch import VolumetricStitch

FEWEST_NODES_PER_LOOP: Final = 8
MOST_NODES_PER_LOOP: Final = 1000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Specimen:
    """Hold a knit as the solver takes it: the nodes of its yarn, centred on 0, in SI units.

    Parameters
    ----------
    nodes : FloatArray
        Positions (N, 3) strand by strand: x course, y wale, z pile or out of plane [m]. The quadratic B-spline that
        they control passes through the strand, so a node lies outside a bend by edge² curvature / 8.
    arc_lengths : FloatArray
        Length (n,) along the yarn's centreline from its start to each node of a strand, the same for all [m].
    yarn : Yarn
        The fibres of the yarn [loop widths].
    radius : float
        Radius at which strands touch [m].
    loop_width : float
        The stitch's unit of length [m].
    rows, loops, layers : int
        Counts along wale, course and pile; one layer is planar unless its stitch is volumetric.
    stitch : Stitch, VolumetricStitch or Filament
        The loop, the stitch of two loops, or what is no knit.
    centreline : Centreline
        The smooth yarn [loop widths], not centred.
    yarn_length : float
        Whole length, turn-arounds included [m].
    clearance : float
        Least distance between the surfaces of yarns [m].
    sites : Mapping of str to IntArray
        Node indices of each set of boundary sites, hook by hook one of every strand: along +x (``wale``) or +y
        (``course``), on the faces of a volumetric knit by layer, row and +x; only such a knit has ``pile+`` and
        ``pile-``.
    """

    nodes: FloatArray
    arc_lengths: FloatArray
    yarn: Yarn
    radius: float
    loop_width: float
    rows: int
    loops: int
    layers: int
    stitch: Stitch | VolumetricStitch | Filament
    centreline: Centreline
    yarn_length: float
    clearance: float
    sites: Mapping[SiteSet, IntArray]

    @property
    def strands(self) -> tuple[FloatArray, ...]:
        """Return the nodes (n, 3) of every strand: each fibre of a bundle, otherwise the yarn itself [m]."""
        return tuple(self.nodes.reshape(-1, len(self.arc_lengths), 3))


def planar_specimen(
    stitch: Stitch, *, rows: int, loops: int, loop_width: float, nodes_per_loop: int = 48, yarn: Yarn | None = None
) -> Specimen:
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
    yarn : Yarn, optional
        Its fibres; one of the stitch's own radius unless given.

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
    if rows > 1 and stitch_clasp(stitch) == 0:
        allowed = "a row spacing, height and depth with which each loop holds the next row's"
        raise GeometryError("specimen.knit", "rows that do not hold each other", allowed)
    if yarn is None:
        approach = check_clearance(stitch, rows=rows, loops=loops, loop_width=loop_width)
        gap = approach.distance - 2.0 * stitch.fibre_radius
    else:
        gap = check_fibres(centreline, yarn, loop_width=loop_width).between
    return _cut(
        stitch,
        centreline,
        mesh,
        yarn,
        counts=(rows, loops, 1),
        middle=knit_middle(stitch, rows, loops),
        gap=gap,
        loop_width=loop_width,
    )


def volumetric_specimen(
    stitch: VolumetricStitch,
    *,
    rows: int,
    loops: int,
    layers: int,
    loop_width: float,
    nodes_per_loop: int = 48,
    yarn: Yarn | None = None,
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
    yarn : Yarn, optional
        Its fibres; one of the stitch's own radius unless given.

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
    if yarn is None:
        approach = check_volumetric_clearance(stitch, centreline, middle=middle, loop_width=loop_width)
        gap = approach.distance - 2.0 * stitch.fibre_radius
    else:
        gap = check_fibres(centreline, yarn, loop_width=loop_width).between
    return _cut(
        stitch,
        centreline,
        mesh,
        yarn,
        counts=(rows, loops, layers),
        middle=middle,
        gap=gap,
        loop_width=loop_width,
    )


def filament_specimen(filament: Filament, *, length: float, nodes: int = 48) -> Specimen:
    """Lay a straight filament along the course, clear of anything by its own length.

    Parameters
    ----------
    filament : Filament
        Its radius.
    length : float
        Its length [m].
    nodes : int
        Edges that it is divided into, 8 to 1000.

    Returns
    -------
    Specimen

    Raises
    ------
    SpecificationError
        If a value is out of its bounds.
    """
    _check_size(length, nodes)
    line = filament_line()
    return _cut(
        filament,
        line,
        yarn_mesh(line, 1.0 / nodes),
        None,
        counts=(1, 1, 1),
        middle=np.array([0.5, 0.0, 0.0]),
        gap=1.0,
        loop_width=length,
    )


def _cut(
    stitch: Stitch | VolumetricStitch | Filament,
    centreline: Centreline,
    mesh: Mesh,
    yarn: Yarn | None,
    *,
    counts: tuple[int, int, int],
    middle: FloatArray,
    gap: float,
    loop_width: float,
) -> Specimen:
    """Lay the strands along a checked centreline; middle and gap are in loop widths."""
    fibres = Yarn(fibre_radius=stitch.fibre_radius) if yarn is None else yarn
    nodes, sites = _strands(centreline, mesh, fibres, middle)
    rows, loops, layers = counts
    return Specimen(
        nodes=nodes * loop_width,
        arc_lengths=mesh.arc_lengths * loop_width,
        yarn=fibres,
        radius=fibres.contact_radius * loop_width,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=layers,
        stitch=stitch,
        centreline=centreline,
        yarn_length=centreline.length * loop_width,
        clearance=gap * loop_width,
        sites=sites,
    )


def _check_size(loop_width: float, nodes_per_loop: int) -> None:
    if not is_positive(loop_width):
        raise SpecificationError("specimen.loop_width", loop_width, "a length above 0 m")
    check_count("specimen.nodes_per_loop", nodes_per_loop, most=MOST_NODES_PER_LOOP, least=FEWEST_NODES_PER_LOOP)


def _strands(
    centreline: Centreline, mesh: Mesh, yarn: Yarn, middle: FloatArray
) -> tuple[FloatArray, Mapping[SiteSet, IntArray]]:
    """Return the control points (N, 3) of all strands about the knit's middle [loop widths], and their sites."""
    check_turn(yarn, mesh.arc_lengths)
    one = yarn.model == "yarn"
    points = (centreline.position(mesh.arc_lengths),) if one else fibre_strands(centreline, mesh.arc_lengths, yarn)
    sites = {
        edge: fibre_sites(nodes, nodes=len(mesh.arc_lengths), fibres=len(points)).ravel()
        for edge, nodes in mesh.sites.items()
    }
    return np.concatenate([control_points(strand - middle) for strand in points]), MappingProxyType(sites)

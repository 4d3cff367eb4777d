"""Cut a knit to size: nodes in metres, checked to be clear of itself and really knitted."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fabric import Counts
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn, check_turn, fibre_sites, fibre_strands
from knitlab_core.knits.loop_shape import is_positive
from knitlab_core.knits.mesh import control_points, yarn_mesh
from knitlab_core.knits.planar import check_count

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.fabric import Fabric
    from knitlab_core.knits.mesh import Mesh

FEWEST_NODES_PER_LOOP: Final = 8
MOST_NODES_PER_LOOP: Final = 1000


class Cell(NamedTuple):
    """What repeats.

    `vectors`: (D, 3) along course and wale, of a volumetric knit also along the pile [m]; `shifts`: by row, multiples
    of the vectors after which it goes on: 1 along the course, -1 where the yarn comes back; `reach`: (D,) so many cells
    away along each vector strands may touch; `neighbours`: pairs of rows that are next to each other,
    and `stitches` of a row, for so many of which each such pair counts.
    """

    vectors: FloatArray
    shifts: tuple[tuple[int, ...], ...]
    reach: tuple[int, ...]
    neighbours: tuple[tuple[int, int], ...]
    stitches: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Specimen:
    """Knit as the solver takes it: the nodes of its yarn, centred on 0, in SI units.

    Parameters
    ----------
    nodes : FloatArray
        Positions (N, 3) strand by strand: x course, y wale, z pile or out of plane [m]. The quadratic B-spline that
        they control passes through the strand, so a node is outside a bend by edge² curvature / 8.
    arc_lengths : FloatArray
        Length (n,) along the yarn's centreline from its start to each node of a strand, the same for all [m].
    yarn : Yarn
        The fibres of the yarn [loop widths].
    radius : float
        Radius at which strands touch [m].
    loop_width : float
        The stitch's unit of length [m].
    rows, loops, layers : int
        Counts along wale, course and pile; one layer is planar unless its fabric has pile faces.
    fabric : Fabric
        The knit that it is cut from.
    centreline : Centreline
        The smooth yarn [loop widths], not centred.
    yarn_length : float
        Whole length, turn-arounds included [m].
    clearance : float
        Least distance between the surfaces of yarns [m].
    sites : Mapping of str to IndexArray
        Node indices of each set of boundary sites, hook by hook one of every strand: along +x (``wale``) or +y
        (``course``), on the faces of a volumetric knit by layer, row and +x; only such a knit has ``pile+`` and
        ``pile-``.
    cell : Cell or None
        What repeats in a specimen without edges, whose strands are its rows; None in one that has edges.
    """

    nodes: FloatArray
    arc_lengths: FloatArray
    yarn: Yarn
    radius: float
    loop_width: float
    rows: int
    loops: int
    layers: int
    fabric: Fabric
    centreline: Centreline
    yarn_length: float
    clearance: float
    sites: Mapping[SiteSet, IndexArray]
    cell: Cell | None = None

    @property
    def counts(self) -> Counts:
        """Return how often the fabric repeats in it."""
        return Counts(self.rows, self.loops, self.layers)

    @property
    def strands(self) -> tuple[FloatArray, ...]:
        """Return the nodes (n, 3) of every strand: each fibre of a bundle, otherwise the yarn itself [m]."""
        return tuple(self.nodes.reshape(-1, len(self.arc_lengths), 3))


def knit_specimen(
    fabric: Fabric,
    *,
    loop_width: float,
    rows: int = 1,
    loops: int = 1,
    layers: int = 1,
    nodes_per_loop: int = 48,
    yarn: Yarn | None = None,
) -> Specimen:
    """Build a specimen of a fabric and refuse one that cannot exist.

    The yarn is divided at its boundary sites; between two of them edges are equal in arc length and as near as
    their whole number allows to the mean yarn length of a loop over ``nodes_per_loop``. Every site is a node.

    Parameters
    ----------
    fabric : Fabric
        The knit; 6x6x6 stitches of a volumetric one make about 21,000 nodes.
    loop_width : float
        l; the length of a straight filament [m].
    rows, loops, layers : int
        1 to 200 each; in a volumetric knit stitches of two loops each; layers are 1 in a fabric without pile faces.
    nodes_per_loop : int
        8 to 1000; the mesh as a whole has at most 2 million nodes.
    yarn : Yarn, optional
        Its fibres; one of the fabric's own radius unless given.

    Returns
    -------
    Specimen

    Raises
    ------
    SpecificationError
        If a value is out of its bounds.
    GeometryError
        If strands overlap (it names both places), the yarn bends tighter than its own radius, or rows or layers do
        not hold each other.
    """
    check_size(loop_width, nodes_per_loop)
    counts = Counts(rows, loops, layers)
    if layers != 1 and "P" not in fabric.axes:
        raise SpecificationError("specimen.layers", layers, "1: a planar knit has one layer")
    centreline = fabric.centreline(counts)
    mesh = yarn_mesh(centreline, fabric.loop_length(counts) / nodes_per_loop)
    fabric.check_held(counts)
    if yarn is None:
        gap = fabric.clearance(centreline, counts, loop_width=loop_width)
    else:
        gap = check_fibres(centreline, yarn, loop_width=loop_width).between
    fibres = Yarn(fibre_radius=fabric.fibre_radius) if yarn is None else yarn
    nodes, sites = _strands(centreline, mesh, fibres, fabric.middle(counts))
    return Specimen(
        nodes=nodes * loop_width,
        arc_lengths=mesh.arc_lengths * loop_width,
        yarn=fibres,
        radius=fibres.contact_radius * loop_width,
        loop_width=loop_width,
        rows=rows,
        loops=loops,
        layers=layers,
        fabric=fabric,
        centreline=centreline,
        yarn_length=centreline.length * loop_width,
        clearance=gap * loop_width,
        sites=sites,
    )


def check_size(loop_width: float, nodes_per_loop: int) -> None:
    """Refuse a loop width or a mesh out of its range.

    Raises
    ------
    SpecificationError
        Naming the field.
    """
    if not is_positive(loop_width):
        raise SpecificationError("specimen.loop_width", loop_width, "a length above 0 m")
    check_count("specimen.nodes_per_loop", nodes_per_loop, most=MOST_NODES_PER_LOOP, least=FEWEST_NODES_PER_LOOP)


def _strands(
    centreline: Centreline, mesh: Mesh, yarn: Yarn, middle: FloatArray
) -> tuple[FloatArray, Mapping[SiteSet, IndexArray]]:
    """Return the control points (N, 3) of all strands about the knit's middle [loop widths], and their sites."""
    check_turn(yarn, mesh.arc_lengths)
    one = yarn.model == "yarn"
    points = (centreline.position(mesh.arc_lengths),) if one else fibre_strands(centreline, mesh.arc_lengths, yarn)
    sites = {
        edge: fibre_sites(nodes, nodes=len(mesh.arc_lengths), fibres=len(points)).ravel()
        for edge, nodes in mesh.sites.items()
    }
    return np.concatenate([control_points(strand - middle) for strand in points]), MappingProxyType(sites)

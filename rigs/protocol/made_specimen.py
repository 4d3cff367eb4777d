"""A specimen as it was made: its yarn, its gauge lengths and its size."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, cast

import numpy as np

from knitlab_core.knits import (
    BoundEdges,
    Fabric,
    Specimen,
    Yarn,
    clamp_nodes,
    knit_cell,
    knit_specimen,
    plate_nodes,
)
from rigs.axes import COORDINATE, DIRECTIONS, FACE, SITES
from rigs.protocol.catalogue import clamped_axes
from rigs.protocol.edges import OPEN, Edges
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits import SiteSet, Stitch
    from knitlab_core.knits.cell_rows import CellFabric
    from rigs.axes import Axis, Direction, FloatArray
    from rigs.protocol.catalogue import Fixture
    from rigs.protocol.specimen import SpecimenSpec


def make_specimen(spec: SpecimenSpec) -> Specimen:
    """Make a specimen as it was printed.

    Raises
    ------
    GeometryError
        If it cannot exist: strands overlap, or rows or layers do not hold each other.
    """
    counts = spec.rows, spec.loops, spec.layers
    # The plan before a test and the test itself ask for the same shape; each gets arrays of its own.
    fabric, radius, width = spec.fabric, spec.fabric.fibre_radius * spec.loop_width, spec.loop_width
    if spec.relaxed:
        from rigs.protocol.relaxed_loops import relaxed_loops  # noqa: PLC0415 (numba, for relaxed loops alone)

        fabric, width = relaxed_loops(spec)
    if spec.laid_in is not None:
        fabric = with_radius(fabric, spec.laid_in / spec.loop_width)
    made = _made(
        _bound(fabric, spec.edges),
        counts,
        spec.nodes_per_loop,
        width,
        None if spec.relaxed else spec.laid,
        periodic=spec.periodic,
        grows_to=spec.grows_to,
    )
    if spec.laid_in is not None:
        # What overlaps as laid in has a clearance below 0.
        overlap = 2.0 * (radius - spec.laid_in)
        yarn = Yarn(fibre_radius=spec.fabric.fibre_radius)
        fabric = _bound(spec.fabric, spec.edges)
        made = replace(made, fabric=fabric, yarn=yarn, radius=radius, clearance=made.clearance - overlap)
    sites = {name: nodes.copy() for name, nodes in made.sites.items()}
    return replace(made, nodes=made.nodes.copy(), arc_lengths=made.arc_lengths.copy(), sites=sites)


def _bound(fabric: Fabric, edges: Edges) -> Fabric:
    """Return a fabric with its edges chained as a specimen says."""
    if edges == OPEN:
        return fabric
    top, bottom = edges.top == "bound-off", edges.bottom == "cast-on"
    return BoundEdges(knit=cast("Stitch", fabric), top=top, bottom=bottom, slack=edges.slack)


def with_radius(fabric: Fabric, radius: float) -> Fabric:
    """Return a fabric with a yarn of another radius [loop widths]."""
    return replace(fabric, fibre_radius=radius)


@lru_cache(maxsize=1)
def _made(
    fabric: Fabric,
    counts: tuple[int, int, int],
    nodes_per_loop: int,
    loop_width: float,
    yarn: Yarn | None,
    *,
    periodic: bool,
    grows_to: float | None,
) -> Specimen:
    """Make a specimen of so many rows, loops and layers, with loops of a width [m]."""
    rows, loops, layers = counts
    if periodic:
        knit = cast("CellFabric", fabric)
        return knit_cell(
            knit,
            rows=rows,
            loops=loops,
            layers=layers,
            loop_width=loop_width,
            nodes_per_loop=nodes_per_loop,
            yarn=yarn,
            contact_radius=grows_to,
        )
    return knit_specimen(
        fabric,
        rows=rows,
        loops=loops,
        layers=layers,
        loop_width=loop_width,
        nodes_per_loop=nodes_per_loop,
        yarn=yarn,
    )


def gauge_lengths(specimen: Specimen, fixtures: Mapping[Axis, Fixture] | None = None) -> dict[Direction, float]:
    """Return the initial hook-to-hook distance of each axis: between the means of opposite boundary sites [m].

    A site is a place on the printed yarn. The node that represents it is beside the yarn, at a distance that
    grows with the size of the mesh. Along an axis whose fixtures are plates or clamps it is the gap between these; an
    axis that is not named has none, or hooks. Those of a periodic cell are what it repeats after.
    """
    if specimen.cell is not None:
        return cell_lengths(specimen.cell.vectors)
    at: dict[SiteSet, FloatArray] = {}
    for name, nodes in specimen.sites.items():
        # The fibres of a bundle hang on the same spots of the yarn.
        arc_lengths = specimen.arc_lengths[nodes % len(specimen.arc_lengths)]
        places = specimen.centreline.position(arc_lengths / specimen.loop_width)
        at[name] = specimen.loop_width * places.mean(axis=0)
    hooked = {
        FACE[axis]: float(at[far][COORDINATE[axis]] - at[near][COORDINATE[axis]])
        for axis, (near, far) in SITES.items()
        if near in at
    }
    held = fixtures or {}
    gaps = {FACE[axis]: _gap(specimen, axis, held) for axis, fixture in held.items() if fixture != "hooks"}
    return {**hooked, **gaps}


def cell_lengths(vectors: FloatArray) -> dict[Direction, float]:
    """Return the lengths along its axes of a periodic cell with some vectors (D, 3), in their unit."""
    return {axis: float(vector[COORDINATE[axis]]) for axis, vector in zip(DIRECTIONS, vectors, strict=False)}


def _gap(specimen: Specimen, axis: Axis, fixtures: Mapping[Axis, Fixture]) -> float:
    """Return the distance between the plates or the clamps of an axis [m]."""
    if fixtures[axis] == "plates":
        return plate_nodes(specimen).gap
    return clamp_nodes(specimen, FACE[axis], clamped_axes(fixtures)).gap


def _breadth(specimen: Specimen, axis: Direction) -> float:
    """Return how broad the yarn of a specimen is along an axis, its size where nothing holds it [m]."""
    along = specimen.centreline.position(specimen.arc_lengths / specimen.loop_width)[:, COORDINATE[axis]]
    return float(np.ptp(along)) * specimen.loop_width + 2.0 * specimen.radius


def size_of(specimen: Specimen, *, thickness: float, fixtures: Mapping[Axis, Fixture] | None = None) -> SpecimenSize:
    """Return the extents of a specimen; a planar one has the thickness that is agreed [m]."""
    lengths = gauge_lengths(specimen, fixtures)
    if specimen.fabric.straight:
        # Its section is round: two sides of a square of the same area represent it.
        side = math.sqrt(math.pi) * specimen.fabric.fibre_radius * specimen.loop_width
        return SpecimenSize(
            extents={**lengths, "W": side, "P": side}, fibre_radius=specimen.radius, convention="specimen"
        )
    free: tuple[Direction, ...] = tuple(axis for axis in ("C", "W") if axis not in lengths)
    return SpecimenSize(
        extents={"P": thickness, **lengths, **{axis: _breadth(specimen, axis) for axis in free}},
        fibre_radius=specimen.radius,
        convention="specimen" if "P" in lengths else "unit",
    )

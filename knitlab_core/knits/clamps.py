"""Find the nodes of a planar knit that the jaws of clamps hold."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.arrays import IndexArray  # noqa: TC001 - a NamedTuple's fields are read at run time
from knitlab_core.axes import COORDINATE
from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fibres import fibre_sites

if TYPE_CHECKING:
    from collections.abc import Collection

    from knitlab_core.axes import Axis
    from knitlab_core.knits.fabric import Counts, Fabric
    from knitlab_core.knits.specimen import Specimen


class Clamps(NamedTuple):
    """Nodes that two clamps hold, and the distance between the clamps."""

    lower: IndexArray
    """Nodes in the jaws on the negative side, ascending."""
    upper: IndexArray
    """Nodes in the jaws on the positive side, ascending."""
    gap: float
    """Distance of the clamps' inner edges [m]: the length of the fabric that is free to stretch."""


def clamp_nodes(specimen: Specimen, axis: Axis, clamped: Collection[Axis] = ()) -> Clamps:
    """Return the nodes in the jaws of both clamps of an axis: all yarn over the outermost stitches, as it was laid in.

    Parameters
    ----------
    specimen : Specimen
        A planar knit.
    axis : Axis
        Along which the clamps pull.
    clamped : collection of Axis
        All axes that have clamps. Stitches at a corner, where two of them cross, are in none: jaws end there.

    Raises
    ------
    SpecificationError
        If clamps cannot hold the knit, or would leave no stitch free.
    """
    faces = clamp_faces(specimen.fabric, specimen.counts, {axis, *clamped})
    unit = specimen.loop_width
    at = specimen.centreline.position(specimen.arc_lengths / unit)
    free = np.ones(len(at), dtype=np.bool_)
    for other in faces.keys() - {axis}:
        low, high = faces[other]
        free &= (at[:, COORDINATE[other]] > low) & (at[:, COORDINATE[other]] < high)
    along, (low, high) = at[:, COORDINATE[axis]], faces[axis]
    # The fibres of a bundle are in the jaws on the same spots of the yarn.
    count, fibres = len(at), len(specimen.strands)
    lower, upper = (
        fibre_sites(np.flatnonzero(inside & free), nodes=count, fibres=fibres).T.ravel()
        for inside in (along <= low, along >= high)
    )
    return Clamps(lower=lower, upper=upper, gap=unit * (high - low))


def clamp_faces(fabric: Fabric, counts: Counts, axes: Collection[Axis]) -> dict[Axis, tuple[float, float]]:
    """Return where the inner edges of clamps are along some axes [loop widths].

    Raises
    ------
    SpecificationError
        If clamps cannot hold the knit, or would leave no stitch free.
    """
    faces = fabric.clamp_faces(counts)
    if not faces.keys() >= set(axes):
        raise SpecificationError("grips", "clamps", "hooks: clamps hold the edge stitches of a planar knit")
    found = {axis: faces[axis] for axis in axes}
    if any(high <= low for low, high in found.values()):
        found_here = f"clamps on {counts.rows} rows of {counts.loops} loops"
        allowed = "3 or more along each axis that is clamped: the outermost of each edge are in the jaws"
        raise SpecificationError("grips", found_here, allowed)
    return found

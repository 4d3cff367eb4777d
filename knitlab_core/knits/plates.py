"""Find the nodes of a volumetric knit that its load plates are printed around."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.arrays import IndexArray  # noqa: TC001 - a NamedTuple's fields are read at run time
from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fibres import fibre_sites
from knitlab_core.knits.loop_shape import is_positive

if TYPE_CHECKING:
    from knitlab_core.knits.specimen import Specimen


class Plates(NamedTuple):
    """Nodes that two plates clamp, and the gap between the plates."""

    lower: IndexArray
    """Nodes inside the plate at the pile- face, ascending."""
    upper: IndexArray
    """Nodes inside the plate at the pile+ face, ascending."""
    gap: float
    """Distance of the plates' inner faces [m]: the height of the knit that can stretch."""


def plate_nodes(specimen: Specimen, *, depth: float | None = None) -> Plates:
    """Return the nodes inside two plates, each printed around all yarn beyond its inner face.

    The lower plate's inner face is ``depth`` above the feet of the bottom layer's pile loops. These feet are on
    the base line of the rows, so wale loops, which are below it, and turn-arounds of the bottom layer are inside as
    a whole. The upper plate's is ``depth`` below the heads of the top layer's pile loops and holds only them.

    Parameters
    ----------
    specimen : Specimen
        A volumetric specimen as printed.
    depth : float, optional
        How far plates reach over feet and heads [m]; by default a fibre radius past the spots where hooks would hold
        them, ``r + (H_p/2)(1 - cos 0.35)``.

    Returns
    -------
    Plates
        Every node whose spot on the yarn is in a plate; where nodes are does not depend on the mesh.

    Raises
    ------
    SpecificationError
        If the specimen is planar, or the depth not above 0 and below half the knit's height.
    """
    room, unit = specimen.fabric.plate_room(specimen.counts), specimen.loop_width
    if room is None:
        found = "a knit whose pile loops are not known" if "P" in specimen.fabric.axes else "a planar knit"
        raise SpecificationError("specimen.knit", found, "a volumetric knit: plates hold pile loops")
    depth = unit * room.reach if depth is None else depth
    height = unit * room.height
    if not is_positive(depth) or depth >= 0.5 * height:
        raise SpecificationError("plates.depth", depth, f"a length above 0 and below {0.5 * height:.4g} m")
    z = unit * specimen.centreline.position(specimen.arc_lengths / unit)[:, 2]
    # The fibres of a bundle are inside on the same spots of the yarn.
    count, fibres = len(z), len(specimen.strands)
    lower, upper = (
        fibre_sites(np.flatnonzero(inside), nodes=count, fibres=fibres).T.ravel()
        for inside in (z <= depth, z >= height - depth)
    )
    return Plates(lower=lower, upper=upper, gap=height - 2.0 * depth)

"""Axes of a rig and of a knit, and the types of arrays in this wing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from knitlab_core import axes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core import arrays
    from knitlab_core.knits import SiteSet

    # For type checkers alone: the command line names axes without NumPy.
    FloatArray: TypeAlias = arrays.FloatArray
    IntArray: TypeAlias = arrays.IndexArray

Axis: TypeAlias = axes.Axis

AXES: Final[tuple[Axis, ...]] = ("C", "W", "P")
"""Directions of a knit: course x, wale y, pile z."""

COORDINATE: Final[Mapping[Axis, int]] = axes.COORDINATE
"""Coordinate that an axis drives."""

SITES: Final[Mapping[Axis, tuple[SiteSet, SiteSet]]] = {
    "C": ("course-", "course+"),
    "W": ("wale-", "wale+"),
    "P": ("pile-", "pile+"),
}
"""Boundary sites on either side of the centre, along each axis."""

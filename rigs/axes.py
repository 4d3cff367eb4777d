"""Axes of a rig and of a knit, and the types of arrays in this wing.

An axis moves a face of the specimen along a direction. That of a stretch has the name of both, ``C``; that of a shear
names the face first, ``WC``: the face across the wale goes along the course, as the indices of a stress do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from knitlab_core import axes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core import arrays
    from knitlab_core.knits import SiteSet

    # For type checkers alone: the command line names axes without NumPy.
    FloatArray: TypeAlias = arrays.FloatArray
    IntArray: TypeAlias = arrays.IndexArray

Direction: TypeAlias = axes.Axis
"""Course x, wale y, or pile z."""

Axis: TypeAlias = Literal["C", "W", "P", "WC", "PC", "PW"]
"""Stretch along a direction, or shear of a face along another."""

DIRECTIONS: Final[tuple[Direction, ...]] = ("C", "W", "P")
"""Directions of a knit, which are its axes of stretch."""

SHEARS: Final[tuple[Axis, ...]] = ("WC", "PC", "PW")
"""Axes of shear: faces go along the directions before their own; a cell that leant the other way too could turn."""

AXES: Final[tuple[Axis, ...]] = (*DIRECTIONS, *SHEARS)
"""All axes that a rig may drive."""

FACE: Final[Mapping[Axis, Direction]] = {"C": "C", "W": "W", "P": "P", "WC": "W", "PC": "P", "PW": "P"}
"""Direction across the face that an axis moves; the specimen's extent along it is the gauge length of the axis."""

COORDINATE: Final[Mapping[Axis, int]] = {"C": 0, "W": 1, "P": 2, "WC": 0, "PC": 0, "PW": 1}
"""Coordinate that an axis drives."""


def spans(axis: Axis) -> set[Direction]:
    """Return the directions that a specimen must have faces across for an axis to drive it.

    Examples
    --------
    >>> spans("C"), spans("WC") == {"W", "C"}
    ({'C'}, True)
    """
    return {FACE[axis], DIRECTIONS[COORDINATE[axis]]}


SITES: Final[Mapping[Axis, tuple[SiteSet, SiteSet]]] = {
    "C": ("course-", "course+"),
    "W": ("wale-", "wale+"),
    "P": ("pile-", "pile+"),
}
"""Boundary sites on either side of the centre, along each axis of stretch."""

"""Fabric of a user's own centreline: points along one yarn, some of them boundary sites."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, get_args

import numpy as np

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.curve import curve_through
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn
from knitlab_core.knits.loop_shape import LARGEST, check_number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.fabric import Clasps, Counts, LoopBudget, Pin, PlateRoom

SITE_SETS: Final[tuple[SiteSet, ...]] = get_args(SiteSet)
FEWEST_POINTS: Final = 8
MOST_POINTS: Final = 10_000

_FACES: Final[Mapping[Axis, tuple[SiteSet, SiteSet]]] = {
    "C": ("course-", "course+"),
    "W": ("wale-", "wale+"),
    "P": ("pile-", "pile+"),
}
_ALONG: Final[Mapping[str, tuple[int, ...]]] = {"course": (1, 2), "wale": (0, 2), "pile": (0, 1)}
"""Coordinates by which the sites of an edge or face are put in order."""

_FARTHEST: Final = 1e4
_SAME_PLACE: Final = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnCentreline:
    """Knit along given points, in the order of the yarn; a `Fabric`.

    What is not known of it is left out: no clasp numbers, no arc-length budget, no wires through its loops, no plates.
    Whether its loops hold each other is not checked.

    Parameters
    ----------
    points : tuple of three floats each
        8 to 10,000 points on one contiguous yarn [loop widths]; a smooth curve is laid through them (`Curve`).
    sites : tuple of (int, SiteSet)
        Which points, counted from 0, are boundary sites; every face that has sites needs its opposite.
    fibre_radius : float
        ``r`` [loop widths].

    Raises
    ------
    SpecificationError
        Naming the number of a point, counted from 1, or a face without its opposite.
    """

    points: tuple[tuple[float, float, float], ...]
    sites: tuple[tuple[int, SiteSet], ...]
    fibre_radius: float

    def __post_init__(self) -> None:
        check_number("fibre_radius", self.fibre_radius, most=LARGEST["fibre_radius"])
        if not FEWEST_POINTS <= len(self.points) <= MOST_POINTS:
            allowed = f"{FEWEST_POINTS} to {MOST_POINTS} points on one yarn"
            raise SpecificationError("centreline", f"{len(self.points)} points", allowed)
        for number, point in enumerate(self.points, 1):
            if not all(math.isfinite(x) and abs(x) <= _FARTHEST for x in point):
                raise SpecificationError(
                    "centreline", f"point {number} at {point}", "finite numbers up to 1e4 loop widths"
                )
        apart = np.linalg.norm(np.diff(np.array(self.points), axis=0), axis=-1)
        if apart.min() <= _SAME_PLACE:
            found = f"points {int(apart.argmin()) + 1} and {int(apart.argmin()) + 2} in one place"
            raise SpecificationError("centreline", found, "points that are apart from the next")
        self._check_sites()

    def _check_sites(self) -> None:
        """Refuse sites that are no points, points that are two sites, and faces without an opposite."""
        numbers = [number for number, _ in self.sites]
        if len(set(numbers)) < len(numbers) or not all(0 <= number < len(self.points) for number in numbers):
            raise SpecificationError("centreline", "sites that are no points", "each site a point of its own")
        named = {face for _, face in self.sites}
        if named - set(SITE_SETS):
            raise SpecificationError("centreline", f"site {min(named - set(SITE_SETS))}", " or ".join(SITE_SETS))
        lonely = sorted(face for pair in _FACES.values() for face in pair if len(named & set(pair)) == 1)
        missing = [face for face in lonely if face not in named]
        if missing or not named:
            found = f"no site {missing[0]}" if missing else "no sites"
            raise SpecificationError("centreline", found, "sites on opposite faces, such as course- and course+")

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes across which it has sites."""
        named = {face for _, face in self.sites}
        return tuple(axis for axis, pair in _FACES.items() if pair[0] in named)

    @property
    def straight(self) -> bool:
        """Return False: hooks hold it as they hold a knit."""
        return False

    @property
    def description(self) -> str:
        """Return what a table calls it."""
        return f"a centreline of {len(self.points)} points"

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return nothing: its loops are not known."""
        return {}

    def loop_length(self, counts: Counts) -> float:
        """Return the yarn length over the number of loops that it is said to have [loop widths]."""
        return curve_through(self.points).length / math.prod(counts)

    def centreline(self, counts: Counts) -> Centreline:  # noqa: ARG002 (its points are all there is)
        """Return the yarn with its sites, those of an edge in the order of their places along it."""
        curve = curve_through(self.points)
        sites: list[Site] = []
        for face in SITE_SETS:
            coordinates = _ALONG[face[:-1]]
            of_face = [number for number, named in self.sites if named == face]
            of_face.sort(key=lambda number: tuple(self.points[number][i] for i in coordinates))
            sites += [
                Site(set=face, row=0, loop=loop, arc_length=float(curve.lengths[number]))
                for loop, number in enumerate(of_face)
            ]
        return Centreline(pieces=(curve,), sites=tuple(sites))

    def middle(self, counts: Counts) -> FloatArray:  # noqa: ARG002 (its points are all there is)
        """Return the point (3,) midway between the means of opposite sites, elsewhere of its extent [loop widths]."""
        points = np.array(self.points)
        middle: FloatArray = 0.5 * (points.min(axis=0) + points.max(axis=0))
        for coordinate, pair in enumerate(_FACES.values()):
            means = [points[[n for n, named in self.sites if named == face], coordinate] for face in pair]
            if means[0].size:
                middle[coordinate] = 0.5 * (means[0].mean() + means[1].mean())
        return middle

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:  # noqa: ARG002 (they are not known)
        """Return nothing: which stretches are loops is not known."""
        return {}

    def check_held(self, counts: Counts) -> None:
        """Take it to be knitted: which stretches are loops is not known."""

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:  # noqa: ARG002 (as above)
        """Return the least distance between surfaces of strands; the whole yarn is searched [loop widths]."""
        try:
            return check_fibres(line, Yarn(fibre_radius=self.fibre_radius), loop_width=loop_width).between
        except GeometryError as error:
            raise GeometryError("specimen.knit", error.found, error.expected) from error

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:  # noqa: ARG002 (as above)
        """Return nothing: which stretches are loops is not known."""
        return {}

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:  # noqa: ARG002 (as above)
        """Return None: which stretches are stitches is not known."""
        return None

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:  # noqa: ARG002 (as above)
        """Return nothing: where its stitches are is not known."""
        return {}

    def plate_room(self, counts: Counts) -> PlateRoom | None:  # noqa: ARG002 (as above)
        """Return None: its pile loops are not known."""
        return None

"""Lay a straight filament: not a knit, but what a rig is proved with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.centreline import Centreline, Site
from knitlab_core.knits.stitch import is_positive

if TYPE_CHECKING:
    from knitlab_core.knits.stitch import FloatArray

LARGEST_RADIUS: Final = 0.1
"""Largest radius of a filament, in its lengths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Filament:
    """Hold the shape of a straight filament; its length takes the place of a loop's width.

    Parameters
    ----------
    fibre_radius : float
        Its radius [lengths].

    Raises
    ------
    SpecificationError
        If the radius is not finite, not positive or beyond `LARGEST_RADIUS`.
    """

    fibre_radius: float

    def __post_init__(self) -> None:
        if not is_positive(self.fibre_radius) or self.fibre_radius > LARGEST_RADIUS:
            allowed = f"a diameter above 0 and at most {2.0 * LARGEST_RADIUS:g} of its length"
            raise SpecificationError("filament", f"{2.0 * self.fibre_radius:.4g} of its length", allowed)

    @property
    def side(self) -> float:
        """Return the side of the square that has the area of its cross-section [lengths]."""
        return math.sqrt(math.pi) * self.fibre_radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Straight:
    """Run straight along the course, one length."""

    @property
    def length(self) -> float:
        """Return the arc length [lengths]."""
        return 1.0

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [lengths]."""
        points: FloatArray = np.outer(s, [1.0, 0.0, 0.0])
        return points

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        return np.tile([1.0, 0.0, 0.0], (len(s), 1))

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/length]."""
        return np.zeros((len(s), 3))

    def place(self, s: float) -> str:
        """Name the spot."""
        return f"{s:.0%} of the filament"


def filament_line() -> Centreline:
    """Return the centreline of a filament, an end a site."""
    sites = (
        Site(set="course-", row=0, loop=0, arc_length=0.0),
        Site(set="course+", row=0, loop=0, arc_length=1.0),
    )
    return Centreline(pieces=(Straight(),), sites=sites)

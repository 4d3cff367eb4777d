"""Straight filament: no knit, but a specimen to prove a rig with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.centreline import Centreline, Site
from knitlab_core.knits.loop_shape import is_positive

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import SiteSet
    from knitlab_core.knits.fabric import Clasps, Counts, LoopBudget, Pin, PlateRoom

LARGEST_RADIUS: Final = 0.1
"""Largest radius of a filament, in its lengths."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Filament:
    """Shape of a straight filament; its length takes the place of a loop's width.

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
    def axes(self) -> tuple[Axis, ...]:
        """Return the course, along which it is laid."""
        return ("C",)

    @property
    def straight(self) -> bool:
        """Return True."""
        return True

    @property
    def description(self) -> str:
        """Return what a table calls it."""
        return "no knit: a straight filament"

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return nothing: it has no loops for wires."""
        return {}

    def loop_length(self, counts: Counts) -> float:  # noqa: ARG002 (there is one)
        """Return its length [lengths]."""
        return 1.0

    def centreline(self, counts: Counts) -> Centreline:
        """Return its centreline, each end a site."""
        if counts != (1, 1, 1):
            raise SpecificationError("specimen.loops", list(counts), "[1, 1]: a filament is no knit")
        sites = (
            Site(set="course-", row=0, loop=0, arc_length=0.0),
            Site(set="course+", row=0, loop=0, arc_length=1.0),
        )
        return Centreline(pieces=(Straight(),), sites=sites)

    def middle(self, counts: Counts) -> FloatArray:  # noqa: ARG002 (there is one)
        """Return its middle (3,) [lengths]."""
        return np.array([0.5, 0.0, 0.0])

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:  # noqa: ARG002 (it has no loops)
        """Return nothing: it has no loops."""
        return {}

    def check_held(self, counts: Counts) -> None:
        """Return no clasps."""

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:  # noqa: ARG002 (straight)
        """Return its own length: nothing is beside it [lengths]."""
        return 1.0

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:  # noqa: ARG002 (it has no loops)
        """Return nothing: it has no loops."""
        return {}

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:  # noqa: ARG002 (it has no loops)
        """Return None: it has no stitches."""
        return None

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:  # noqa: ARG002 (it has no loops)
        """Return nothing: it has no stitches, and its ends are held in any case."""
        return {}

    def plate_room(self, counts: Counts) -> PlateRoom | None:  # noqa: ARG002 (it has no loops)
        """Return None: it has no loops."""
        return None


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
        """Return the place as text."""
        return f"{s:.0%} of the filament"

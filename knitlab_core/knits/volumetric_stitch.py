"""Volumetric knit, the fabric of two loops per stitch, and its sets of numbers that have a name."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import GeometryError
from knitlab_core.knits.arclength import yarn_per_loop
from knitlab_core.knits.fabric import PlateRoom
from knitlab_core.knits.planar import HOOK_ANGLE, stitch_clasp
from knitlab_core.knits.stitch import planar_budget
from knitlab_core.knits.volumetric import (
    check_volumetric_clearance,
    volumetric,
    volumetric_clasps,
    volumetric_middle,
    wale_leg,
)
from knitlab_core.knits.volumetric_shape import VolumetricShape

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.fabric import Clasps, Counts, LoopBudget, Pin


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumetricStitch(VolumetricShape):
    """Knit many layers with one yarn: a `Fabric` whose parameters are those of `VolumetricShape`."""

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return course, wale and pile."""
        return ("C", "W", "P")

    @property
    def straight(self) -> bool:
        """Return False: it has loops."""
        return False

    @property
    def description(self) -> str:
        """Return what a table calls it."""
        return "a stitch given by its values"

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return nothing: no wires hold its loops."""
        return {}

    def loop_length(self, counts: Counts) -> float:  # noqa: ARG002 (every stitch is as long)
        """Return the mean yarn length of wale and pile loop [loop widths]."""
        return 0.5 * (yarn_per_loop(self.wale_loop) + yarn_per_loop(self.pile_loop))

    def centreline(self, counts: Counts) -> Centreline:
        """Return the yarn with its sites."""
        return volumetric(self, rows=counts.rows, loops=counts.loops, layers=counts.layers)

    def middle(self, counts: Counts) -> FloatArray:
        """Return the point (3,) midway between the means of opposite faces' sites [loop widths]."""
        return volumetric_middle(self, counts.rows, counts.loops, counts.layers)

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:
        """Return the clasps of wale loops, (layers, rows - 1, loops), and of pile loops, (layers - 1, rows, loops)."""
        return volumetric_clasps(self, line, rows=counts.rows, loops=counts.loops, layers=counts.layers)

    def check_held(self, counts: Counts) -> None:
        """Refuse rows or layers that do not hold each other."""
        for count, loop, joined in ((counts.rows, self.wale_loop, "rows"), (counts.layers, self.pile_loop, "layers")):
            if count > 1 and stitch_clasp(loop) == 0:
                allowed = f"spacings, heights and a depth with which loops hold the next of the {joined}"
                raise GeometryError("specimen.knit", f"{joined} that do not hold each other", allowed)

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:
        """Return the least distance between surfaces of strands; the whole yarn is searched [loop widths]."""
        approach = check_volumetric_clearance(self, line, middle=self.middle(counts), loop_width=loop_width)
        return approach.distance - 2.0 * self.fibre_radius

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:
        """Return the arc-length budgets of wale and pile loops, as planar ones."""
        return {"W": planar_budget(self.wale_loop, fibre_radius), "P": planar_budget(self.pile_loop, fibre_radius)}

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:
        """Return the arc length of the middle of the leg at +x of a stitch's wale loop [loop widths]."""
        return wale_leg(self, line, pin, rows=counts.rows, loops=counts.loops)

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:  # noqa: ARG002 (planar knits alone)
        """Return nothing: clamps hold planar knits."""
        return {}

    def plate_room(self, counts: Counts) -> PlateRoom | None:
        """Return the room of plates around pile loops.

        They reach a fibre radius past the spots where hooks would hold these: ``r + (H_p/2)(1 - cos 0.35)``.
        """
        return PlateRoom(
            height=(counts.layers - 1) * self.layer_spacing + self.pile_height,
            reach=self.fibre_radius + 0.5 * self.pile_height * (1.0 - math.cos(HOOK_ANGLE)),
        )


NAMED_VOLUMETRIC_STITCHES: Final[Mapping[str, VolumetricStitch]] = MappingProxyType(
    {
        "volumetric-default": VolumetricStitch(
            curvature=1.5,
            wale_height=1.6,
            pile_height=1.6,
            depth=0.25,
            row_spacing=1.10,
            layer_spacing=1.25,
            fibre_radius=0.050,
        ),
    }
)
"""Volumetric stitches by name."""

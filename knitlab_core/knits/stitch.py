"""Planar stockinette, the fabric of one loop, and its sets of numbers that have a name."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import GeometryError
from knitlab_core.knits.arclength import arc_table
from knitlab_core.knits.clearance import check_clearance
from knitlab_core.knits.fabric import LoopBudget
from knitlab_core.knits.loop_shape import LoopShape, locking_strain
from knitlab_core.knits.pieces import Row, Turn
from knitlab_core.knits.planar import HOOK_ANGLE, arc_length_at, knit_middle, planar_clasps, planar_line, stitch_clasp

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.fabric import Clasps, Counts, Pin, PlateRoom
    from knitlab_core.knits.planar import PlanarRow


@dataclass(frozen=True, slots=True, kw_only=True)
class Stitch(LoopShape):
    """Knit planar stockinette: every row Eq. 1 of the paper, rows joined by semicircles in the plane of the feet.

    A `Fabric`. Its parameters are those of `LoopShape`. The first row's first foot is at (-1/2, -h, d). A planar
    stitch with other rows or turns derives from it.
    """

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return course and wale."""
        return ("C", "W")

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
        """Return the arc length from sites to apices: of heads and sinkers, and of turn-arounds [loop widths]."""
        beside = float(arc_table(self).arc_length(np.array([HOOK_ANGLE]))[0])
        half_turn = 0.25 * np.pi * self.row_spacing
        return {"wale-": beside, "wale+": beside, "course-": half_turn, "course+": half_turn}

    @property
    def front(self) -> float:
        """Return -z of what is farthest in front: the legs [loop widths]."""
        return self.depth

    @property
    def gap(self) -> float:
        """Return the distance of strands one in front of the other in a chained edge [loop widths]."""
        return 0.14

    @property
    def shapes(self) -> tuple[LoopShape, ...]:
        """Return its one loop."""
        return (self,)

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; even ones run along +x, odd ones back."""
        return Row(stitch=self, row=number, loops=loops)

    def turn(self, number: int, loops: int) -> Turn:
        """Return the turn-around from a row to the next: diameter w, in the plane z = d of the feet."""
        side = -1 if number % 2 else 1
        x, y = loops - 0.5 if side > 0 else -0.5, (number + 0.5) * self.row_spacing - self.height
        return Turn(
            centre=(x, y, self.depth),
            radius=0.5 * self.row_spacing,
            side=side,
            across=(0.0, 1.0, 0.0),
            joins=f"from row {number} to row {number + 1}",
        )

    def loop_length(self, counts: Counts) -> float:  # noqa: ARG002 (every loop is as long)
        """Return the yarn length of one loop [loop widths]."""
        return arc_table(self).loop_length

    def centreline(self, counts: Counts) -> Centreline:
        """Return the yarn with its sites."""
        return planar_line(self, rows=counts.rows, loops=counts.loops)

    def middle(self, counts: Counts) -> FloatArray:
        """Return the point (3,) midway between opposite edges [loop widths]."""
        return knit_middle(self, counts.rows, counts.loops)

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:
        """Return the clasps between rows, (rows - 1, loops)."""
        return {"rows": planar_clasps(self, line, rows=counts.rows, loops=counts.loops)}

    def check_held(self, counts: Counts) -> None:
        """Refuse rows that do not hold each other."""
        if counts.rows > 1 and stitch_clasp(self) == 0:
            allowed = "a row spacing, height and depth with which each loop holds the next row's"
            raise GeometryError("specimen.knit", "rows that do not hold each other", allowed)

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:  # noqa: ARG002 (rows repeat)
        """Return the least distance between surfaces of strands [loop widths]."""
        approach = check_clearance(self, rows=counts.rows, loops=counts.loops, loop_width=loop_width)
        return approach.distance - 2.0 * self.fibre_radius

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:
        """Return the arc-length budget of its loops, which reach along the wale."""
        return {"W": planar_budget(self, fibre_radius)}

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:  # noqa: ARG002 (rows are known)
        """Return the arc length of the middle of a stitch's leg at +x [loop widths]."""
        return float(arc_length_at(self, counts.loops, pin.row, np.array([np.pi * (2 * pin.loop + 0.5)]))[0])

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:
        """Return the middles between the outermost stitches and the next, where heads hold the feet beyond."""
        return {"C": (0.5, counts.loops - 1.5), "W": (0.5 * self.row_spacing, (counts.rows - 1.5) * self.row_spacing)}

    def plate_room(self, counts: Counts) -> PlateRoom | None:  # noqa: ARG002 (whatever they are)
        """Return None: it has no loops along the pile."""
        return None


NAMED_STITCHES: Final[Mapping[str, Stitch]] = MappingProxyType(
    {
        "stockinette-default": Stitch(curvature=1.5, height=0.80, depth=0.25, row_spacing=0.86, fibre_radius=0.050),
        "plain-knit": Stitch(curvature=1.5, height=0.637, depth=0.159, row_spacing=0.716, fibre_radius=0.050),
        "G_B": Stitch(curvature=1.5, height=1.0, depth=0.25, row_spacing=1.06, fibre_radius=0.050),
        "paper-fit": Stitch(curvature=1.55, height=0.61, depth=0.25, row_spacing=0.67, fibre_radius=0.0395),
    }
)
"""Stitches by name: the default, Crane's plain knit (2023), a taller one, and a fit to the paper (decision 0039)."""


def planar_budget(loop: LoopShape, fibre_radius: float) -> LoopBudget:
    """Return the budget of a planar loop whose strands have a radius of their own where they cross [loop widths]."""
    locking = locking_strain(loop, arc_table(loop).loop_length, fibre_radius)
    return LoopBudget(
        locking=locking, share=2.0 * loop.row_spacing, fibre_radius=fibre_radius, error=loop.locking_error
    )

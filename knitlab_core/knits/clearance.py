"""Check that the yarn of a stitch does not overlap itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import GeometryError
from knitlab_core.knits.arclength import arc_table, tightest_bend
from knitlab_core.knits.distance import Approach, closest_approach
from knitlab_core.knits.planar import knit_middle, planar_line

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.centreline import Centreline
    from knitlab_core.knits.loop_shape import LoopShape
    from knitlab_core.knits.planar import PlanarKnit


def check_clearance(knit: PlanarKnit, *, rows: int, loops: int, loop_width: float) -> Approach:
    """Return where strands come closest, or refuse a knit whose yarn overlaps itself.

    Rows repeat, and two of them farther apart than 2h + w along the wale are farther apart than neighbours, so
    the first few rows hold the closest pair of any number of rows.

    Parameters
    ----------
    knit : PlanarKnit
        The stitch.
    rows, loops : int
        Counts along wale and course.
    loop_width : float
        For the message alone [m].

    Returns
    -------
    Approach
        Distance and arc lengths [loop widths].

    Raises
    ------
    GeometryError
        Naming the two places: row, loop, arc length and position in mm from the knit's centre.
    """
    bend = max(gentle_bend(shape, loop_width) for shape in knit.shapes)
    if rows > 1:
        bend = max(bend, 1.0 / knit.turn(0, loops).radius)
    enough = math.floor(2.0 * knit.shapes[0].height / knit.row_spacing) + 4
    probe = planar_line(knit, rows=min(rows, enough), loops=loops)
    return clear_of_itself(
        probe, bend, radius=knit.fibre_radius, middle=knit_middle(knit, rows, loops), loop_width=loop_width
    )


def gentle_bend(stitch: LoopShape, loop_width: float) -> float:
    """Return the largest curvature of a loop [1/loop width], or refuse a loop that bends tighter than its fibre."""
    bend, at_parameter = tightest_bend(stitch)
    if bend * stitch.fibre_radius >= 1.0:
        table = arc_table(stitch)
        place = 0.5 * table.loop_length + float(table.arc_length(np.array([at_parameter]))[0])
        found = f"a bend of radius {1e3 * loop_width / bend:.4g} mm at arc length {1e3 * loop_width * place:.4g} mm"
        allowed = f"bends of a radius above the fibre's, {1e3 * loop_width * stitch.fibre_radius:.4g} mm"
        raise GeometryError("specimen.knit", f"{found}, in every loop", allowed)
    return bend


def clear_of_itself(
    centreline: Centreline, bend: float, *, radius: float, middle: FloatArray, loop_width: float
) -> Approach:
    """Return the closest approach of a yarn with bends of at most ``bend``, or refuse it if strands overlap."""
    approach = closest_approach(centreline, largest_curvature=bend)
    if approach.distance <= 2.0 * radius:
        s = np.array([approach.first, approach.second])
        places = zip(s, centreline.position(s) - middle, strict=True)
        named = " and ".join(_named(centreline, spot, 1e3 * loop_width * point, loop_width) for spot, point in places)
        found = f"strands {1e3 * loop_width * approach.distance:.4g} mm apart at {named}"
        allowed = f"centrelines more than 2 r = {2e3 * loop_width * radius:.4g} mm apart"
        raise GeometryError("specimen.knit", found, allowed)
    return approach


def _named(centreline: Centreline, s: float, point_mm: FloatArray, loop_width: float) -> str:
    x, y, z = point_mm
    return f"{centreline.place(s)} (arc length {1e3 * loop_width * s:.4g} mm, at {x:.4g}, {y:.4g}, {z:.4g} mm)"

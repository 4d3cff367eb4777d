"""Refuse a stitch whose yarn would overlap itself, and say where."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import GeometryError
from knitlab_core.knits.arclength import tightest_bend
from knitlab_core.knits.distance import Approach, closest_approach
from knitlab_core.knits.pieces import Row
from knitlab_core.knits.stockinette import knit_middle, stockinette

if TYPE_CHECKING:
    from knitlab_core.knits.centreline import Centreline
    from knitlab_core.knits.stitch import FloatArray, Stitch


def check_clearance(stitch: Stitch, *, rows: int, loops: int, loop_width: float) -> Approach:
    """Return where strands come closest, or refuse a knit whose yarn overlaps itself.

    Rows repeat, and two of them farther apart than 2h + w along the wale are farther apart than neighbours, so
    the first few rows hold the closest pair of any number of rows.

    Parameters
    ----------
    stitch : Stitch
        The loop.
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
    bend, at_parameter = tightest_bend(stitch)
    if bend * stitch.fibre_radius >= 1.0:
        place = Row(stitch=stitch, row=0, loops=loops).arc_length(np.array([at_parameter]))
        found = f"a bend of radius {1e3 * loop_width / bend:.4g} mm at arc length {1e3 * loop_width * place[0]:.4g} mm"
        allowed = f"bends of a radius above the fibre's, {1e3 * loop_width * stitch.fibre_radius:.4g} mm"
        raise GeometryError("specimen.knit", f"{found}, in every loop", allowed)
    if rows > 1:
        bend = max(bend, 2.0 / stitch.row_spacing)
    enough = math.floor(2.0 * stitch.height / stitch.row_spacing) + 4
    probe = stockinette(stitch, rows=min(rows, enough), loops=loops)
    approach = closest_approach(probe, largest_curvature=bend)
    if approach.distance <= 2.0 * stitch.fibre_radius:
        s = np.array([approach.first, approach.second])
        places = zip(s, probe.position(s) - knit_middle(stitch, rows, loops), strict=True)
        named = " and ".join(_named(probe, spot, 1e3 * loop_width * point, loop_width) for spot, point in places)
        found = f"strands {1e3 * loop_width * approach.distance:.4g} mm apart at {named}"
        allowed = f"centrelines more than 2 r = {2e3 * loop_width * stitch.fibre_radius:.4g} mm apart"
        raise GeometryError("specimen.knit", found, allowed)
    return approach


def _named(centreline: Centreline, s: float, point_mm: FloatArray, loop_width: float) -> str:
    x, y, z = point_mm
    return f"{centreline.place(s)} (arc length {1e3 * loop_width * s:.4g} mm, at {x:.4g}, {y:.4g}, {z:.4g} mm)"

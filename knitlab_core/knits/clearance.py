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
    from knitlab_core.knits.volumetric_stitch import VolumetricStitch


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
    bend = _gentle_bend(stitch, loop_width)
    if rows > 1:
        bend = max(bend, 2.0 / stitch.row_spacing)
    enough = math.floor(2.0 * stitch.height / stitch.row_spacing) + 4
    probe = stockinette(stitch, rows=min(rows, enough), loops=loops)
    return _clear_of_itself(
        probe, bend, radius=stitch.fibre_radius, middle=knit_middle(stitch, rows, loops), loop_width=loop_width
    )


def check_volumetric_clearance(
    stitch: VolumetricStitch, centreline: Centreline, *, middle: FloatArray, loop_width: float
) -> Approach:
    """Return where the strands of a volumetric knit come closest, or refuse it if its yarn overlaps itself.

    The whole yarn is searched: layers alternate and turn-arounds stand at both sides, which a part would miss.

    Parameters
    ----------
    stitch : VolumetricStitch
        The stitch.
    centreline : Centreline
        The knit.
    middle : FloatArray
        The point (3,) that becomes the origin [loop widths]; for the message alone.
    loop_width : float
        For the message alone [m].

    Returns
    -------
    Approach
        Distance and arc lengths [loop widths].

    Raises
    ------
    GeometryError
        Naming the two places: layer, row, stitch, arc length and position in mm from the knit's centre.
    """
    loops = max(_gentle_bend(loop, loop_width) for loop in (stitch.wale_loop, stitch.pile_loop))
    bend = max(loops, 2.0 / stitch.row_spacing, 2.0 / stitch.layer_spacing)
    return _clear_of_itself(centreline, bend, radius=stitch.fibre_radius, middle=middle, loop_width=loop_width)


def _gentle_bend(stitch: Stitch, loop_width: float) -> float:
    """Return the largest curvature of a loop [1/loop width], or refuse a loop that bends tighter than its fibre."""
    bend, at_parameter = tightest_bend(stitch)
    if bend * stitch.fibre_radius >= 1.0:
        place = Row(stitch=stitch, row=0, loops=1).arc_length(np.array([at_parameter]))
        found = f"a bend of radius {1e3 * loop_width / bend:.4g} mm at arc length {1e3 * loop_width * place[0]:.4g} mm"
        allowed = f"bends of a radius above the fibre's, {1e3 * loop_width * stitch.fibre_radius:.4g} mm"
        raise GeometryError("specimen.knit", f"{found}, in every loop", allowed)
    return bend


def _clear_of_itself(
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

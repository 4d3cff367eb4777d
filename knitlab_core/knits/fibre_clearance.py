"""Check that a yarn of fibres does not overlap: fibre with fibre inside the yarn, and yarn with yarn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import GeometryError
from knitlab_core.knits.distance import closest_approach
from knitlab_core.knits.fibres import fibre_strands

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.centreline import Centreline
    from knitlab_core.knits.fibres import Yarn

_BEND_STEP: Final = 0.0025
"""Distance of the spots at which curvature is looked up [loop widths]."""

_FIBRE_STEP: Final = 0.5
"""Distance of the spots between which fibres are compared [fibre radii]."""

_FAR: Final = 1e6
"""Squared distance beyond a fibre's ends [loop widths^2]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FibreClearance:
    """Least gaps between surfaces [loop widths].

    Parameters
    ----------
    inside : float
        Between neighbouring fibres of the yarn; infinite for one fibre.
    between : float
        Between the tubes that hold all fibres, where the yarn meets itself; infinite if it does not.
    """

    inside: float
    between: float


def check_fibres(centreline: Centreline, yarn: Yarn, *, loop_width: float) -> FibreClearance:
    """Return how far fibres are apart, or refuse a yarn whose fibres overlap.

    Parameters
    ----------
    centreline : Centreline
        The yarn's middle, of any knit.
    yarn : Yarn
        Its fibres.
    loop_width : float
        For the message alone [m].

    Raises
    ------
    GeometryError
        Naming the places: bends tighter than the outer radius, yarn nearer to itself than twice that, or
        neighbouring fibres nearer than two radii.
    """
    outer = yarn.outer_radius
    curvature, tightest = _tightest_bend(centreline)
    if curvature * outer >= 1.0:
        found = f"a bend of radius {1e3 * loop_width / curvature:.4g} mm at {_spot(centreline, tightest, loop_width)}"
        raise GeometryError(
            "specimen.yarn", found, f"bends of a radius above R + r = {1e3 * loop_width * outer:.4g} mm"
        )
    between = math.inf
    if curvature > 0.0:
        pair = closest_approach(centreline, largest_curvature=curvature)
        between = pair.distance - 2.0 * outer
        if between <= 0.0:
            places = " and ".join(_spot(centreline, s, loop_width) for s in (pair.first, pair.second))
            found = f"yarns {1e3 * loop_width * pair.distance:.4g} mm apart at {places}"
            allowed = f"centrelines more than 2 (R + r) = {2e3 * loop_width * outer:.4g} mm apart"
            raise GeometryError("specimen.yarn", found, allowed)
    inside = math.inf
    if yarn.fibres > 1:
        distance, place = _neighbour_distance(centreline, yarn)
        inside = distance - 2.0 * yarn.fibre_radius
        if inside <= 0.0:
            found = f"fibres {1e3 * loop_width * distance:.4g} mm apart at {_spot(centreline, place, loop_width)}"
            allowed = f"fibres more than 2 r = {2e3 * loop_width * yarn.fibre_radius:.4g} mm apart"
            raise GeometryError("specimen.yarn", found, allowed)
    return FibreClearance(inside=inside, between=between)


def _tightest_bend(centreline: Centreline) -> tuple[float, float]:
    """Return the largest curvature of a centreline [1/loop width] and its arc length [loop widths]."""
    s = np.linspace(0.0, centreline.length, math.ceil(centreline.length / _BEND_STEP) + 1)
    curvature = np.linalg.norm(centreline.curvature(s), axis=-1)
    worst = int(np.argmax(curvature))
    return float(curvature[worst]), float(s[worst])


def _neighbour_distance(centreline: Centreline, yarn: Yarn) -> tuple[float, float]:
    """Return the least distance of neighbouring fibres' centres, and the arc length it is found at.

    Each spot of a fibre is compared with the spots of the next one within a fibre distance of yarn; between
    spots the squared distance is taken as a parabola.
    """
    step = _FIBRE_STEP * yarn.fibre_radius
    s = np.linspace(0.0, centreline.length, math.ceil(centreline.length / step) + 1)
    reach = math.ceil((yarn.straight_gap + 2.0 * yarn.fibre_radius) / float(s[1])) + 2
    strands = fibre_strands(centreline, s, yarn)
    pairs = zip(strands, strands[1:] + strands[:1], strict=True)
    nearest = [_least_squared(first, second, reach) for first, second in pairs]
    squared = np.min(nearest, axis=0)
    worst = int(np.argmin(squared))
    return math.sqrt(float(squared[worst])), float(s[worst])


def _least_squared(first: FloatArray, second: FloatArray, reach: int) -> FloatArray:
    """Return the squared distance (m,) from each point of one curve to the other, up to `reach` points on."""
    padded = np.pad(second, ((reach, reach), (0, 0)), constant_values=math.sqrt(_FAR))
    count = len(first)
    before = at = np.full(count, _FAR)
    least = at
    for shift in range(2 * reach + 1):
        after = np.sum((padded[shift : shift + count] - first) ** 2, axis=-1)
        bend = before + after - 2.0 * at
        lowest = (at <= before) & (at <= after) & (np.maximum(before, after) < 0.5 * _FAR) & (bend > 0.0)
        drop = np.where(lowest, (after - before) ** 2 / (8.0 * np.where(lowest, bend, 1.0)), 0.0)
        least = np.minimum(least, at - drop)
        before, at = at, after
    return least


def _spot(centreline: Centreline, s: float, loop_width: float) -> str:
    x, y, z = 1e3 * loop_width * centreline.position(np.array([s]))[0]
    return f"{centreline.place(s)} (arc length {1e3 * loop_width * s:.4g} mm, at {x:.4g}, {y:.4g}, {z:.4g} mm)"

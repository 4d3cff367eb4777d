"""Find where a yarn comes closest to itself.

Two points of one curve are always near when little yarn is between them. Where the curvature is at most
kappa, the distance from a point grows along the yarn for the next pi/kappa and is then 2/kappa or more (Schur's
comparison with the circle). So only pairs at least pi/kappa apart are searched, and a yarn of radius r is
clear of itself exactly if r kappa < 1 and their least distance is above 2 r.

References
----------
Litherland, Simon, Durumeric and Rawdon, "Thickness of knots", Topology and its Applications 91 (1999).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.near_points import pairs_within

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.centreline import Centreline

MOST_SAMPLES: Final = 2_000_000
_SAMPLES_PER_BEND: Final = 4
_MOST_STEPS: Final = 30
_TOLERANCE: Final = 1e-12
_TIE: Final = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Approach:
    """Pair of spots on the yarn, and their distance.

    Parameters
    ----------
    distance : float
        Centre to centre [loop widths]; infinite if the yarn is too short to meet itself.
    first, second : float
        Their arc lengths [loop widths].
    """

    distance: float
    first: float
    second: float


def closest_approach(centreline: Centreline, *, largest_curvature: float) -> Approach:
    """Return the closest pair of spots with at least pi/kappa of yarn between them.

    The yarn is sampled four times per radius of its tightest bend. The sample pairs that can hold the least
    distance, by the triangle inequality, and are lowest among their neighbours are refined by Newton's method
    on the squared distance.

    Parameters
    ----------
    centreline : Centreline
        The yarn.
    largest_curvature : float
        The largest curvature it has, kappa [1/loop width].

    Returns
    -------
    Approach
        Distance and arc lengths, to rounding; of several equal ones the first along the yarn.

    Raises
    ------
    SpecificationError
        If the yarn would need more than 2 million samples.
    """
    apart = math.pi / largest_curvature
    if centreline.length <= apart:
        return Approach(distance=math.inf, first=0.0, second=centreline.length)
    count = math.ceil(centreline.length * largest_curvature * _SAMPLES_PER_BEND) + 1
    if count > MOST_SAMPLES:
        allowed = f"a knit whose yarn has at most {MOST_SAMPLES} samples to be checked for overlap"
        raise SpecificationError("specimen.knit", f"{count} samples", allowed)
    s = np.linspace(0.0, centreline.length, count)
    points = centreline.position(s)
    pairs = _lowest_of_neighbours(points, _candidates(points, s, apart))
    first, second = _refine(centreline, s[pairs[:, 0]], s[pairs[:, 1]], apart, step=float(s[1]))
    distance = _distance(centreline, first, second)
    best = int(np.argmax(distance <= distance.min() + _TIE))
    return Approach(distance=float(distance[best]), first=float(first[best]), second=float(second[best]))


def _candidates(points: FloatArray, s: FloatArray, apart: float) -> IndexArray:
    """Return sample pairs (k, 2) within one sample spacing of the least distance of samples."""
    spacing = float(s[1])
    reach = 2.0 * spacing
    while True:
        pairs = pairs_within(points, reach)
        pairs = pairs[s[pairs[:, 1]] - s[pairs[:, 0]] >= apart]
        if pairs.size:
            distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=-1)
            enough = float(distance.min()) + spacing
            if enough <= reach:
                chosen: IndexArray = pairs[distance <= enough]
                in_order: IndexArray = chosen[np.lexsort((chosen[:, 1], chosen[:, 0]))]
                return in_order
            reach = enough * (1.0 + 1e-9)
        else:
            reach *= 2.0


def _lowest_of_neighbours(points: FloatArray, pairs: IndexArray) -> IndexArray:
    """Keep the pairs (k, 2) that are no farther apart than the eight pairs of samples around them.

    Of a wave, whose strands are nearest where least yarn is between them, that is none: the nearest pair is kept.
    """
    own = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=-1)
    lowest = np.ones(own.size, dtype=np.bool_)
    for shift in itertools.product((-1, 0, 1), repeat=2):
        near = np.clip(pairs + shift, 0, len(points) - 1)
        lowest &= own <= np.linalg.norm(points[near[:, 0]] - points[near[:, 1]], axis=-1) + _TIE
    if not lowest.any():
        lowest[np.argmin(own)] = True
    return pairs[lowest]


def _refine(
    centreline: Centreline, first: FloatArray, second: FloatArray, apart: float, *, step: float
) -> tuple[FloatArray, FloatArray]:
    """Move each pair down to its local least distance; a pair that gets nearer than `apart` stays put."""
    p, q = first, second
    for _ in range(_MOST_STEPS):
        move_p, move_q = _newton_step(centreline, p, q)
        p_next = np.clip(p + np.clip(move_p, -step, step), 0.0, centreline.length)
        q_next = np.clip(q + np.clip(move_q, -step, step), 0.0, centreline.length)
        moved = max(float(np.abs(p_next - p).max()), float(np.abs(q_next - q).max()))
        p, q = p_next, q_next
        if moved <= _TOLERANCE * centreline.length:
            break
    better = (q - p >= apart) & (_distance(centreline, p, q) <= _distance(centreline, first, second))
    return np.where(better, p, first), np.where(better, q, second)


def _newton_step(centreline: Centreline, p: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the step on half the squared distance; Gauss-Newton's where the Hessian is not positive."""
    chord = centreline.position(p) - centreline.position(q)
    at_p, at_q = centreline.tangent(p), centreline.tangent(q)
    slope_p, slope_q = _dot(chord, at_p), -_dot(chord, at_q)
    h_pp = 1.0 + _dot(chord, centreline.curvature(p))
    h_qq = 1.0 - _dot(chord, centreline.curvature(q))
    h_pq = -_dot(at_p, at_q)
    positive = (h_pp > 0.0) & (h_pp * h_qq - h_pq**2 > 1e-9)
    # The small surplus keeps Gauss-Newton solvable where the strands are parallel.
    h_pp, h_qq = np.where(positive, h_pp, 1.0 + 1e-3), np.where(positive, h_qq, 1.0 + 1e-3)
    determinant = h_pp * h_qq - h_pq**2
    return (h_pq * slope_q - h_qq * slope_p) / determinant, (h_pq * slope_p - h_pp * slope_q) / determinant


def _distance(centreline: Centreline, p: FloatArray, q: FloatArray) -> FloatArray:
    distance: FloatArray = np.linalg.norm(centreline.position(p) - centreline.position(q), axis=-1)
    return distance


def _dot(left: FloatArray, right: FloatArray) -> FloatArray:
    product: FloatArray = np.sum(left * right, axis=-1)
    return product

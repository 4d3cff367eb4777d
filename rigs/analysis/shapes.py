"""What shapes of a knit tell: contraction across the pull, stretch of the yarn, angles of the loops' legs."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray

MIDDLE: Final = 0.2
"""Share of a specimen's length about its middle where its width is taken."""

LEAST_LEG: Final = 0.5
"""Share of the median leg's height below which a rise of the yarn is no leg but a part of a turn."""


def poisson_ratio(axial: FloatArray, transverse: FloatArray) -> FloatArray:
    """Return ν = -ε_t / ε_a [1], (n,), from the strains along and across the pull (n,); ``nan`` at no strain.

    The ratio of total strains, so that ν(ε) is that of a specimen as a whole (ISO 527-1:2019, 3.13, has it of strains
    within the linear part).
    """
    strained = np.abs(axial) > 1e-6
    return np.where(strained, -transverse / np.where(strained, axial, 1.0), np.nan)


def middle_width(nodes: FloatArray, along: int, across: int, share: float = MIDDLE) -> float:
    """Return the width of a knit at the middle of its length [m]: the extent across of what is nearest to the middle.

    Parameters
    ----------
    nodes : FloatArray, shape (N, 3)
        Nodes [m].
    along, across : int
        Coordinates of the pull and of the width.
    share : float
        Share of the length that counts [1].
    """
    place = nodes[:, along]
    middle, reach = 0.5 * (place.max() + place.min()), 0.5 * share * np.ptp(place)
    return float(np.ptp(nodes[np.abs(place - middle) <= reach, across]))


def yarn_elongation(nodes: FloatArray, axial_strain: FloatArray, strands: Sequence[int]) -> float:
    """Return ΔL/L₀ of the yarn [1]: L = Σ l, L₀ = Σ l / (1 + ε) over its edges.

    An edge of length l strained by ε was l / (1 + ε) long; broken edges do not count.

    Parameters
    ----------
    nodes : FloatArray, shape (N, 3)
        Nodes of all strands, one strand after the other [m].
    axial_strain : FloatArray, shape (E,)
        Axial strain of the edges, strand by strand [1]; ``nan`` where the fibre is broken.
    strands : sequence of int
        Nodes of each strand.
    """
    lengths = np.concatenate([np.linalg.norm(np.diff(part, axis=0), axis=1) for part in parts(nodes, strands)])
    whole = np.isfinite(axial_strain)
    rest = float(np.sum(lengths[whole] / (1.0 + axial_strain[whole])))
    return float(np.sum(lengths[whole])) / rest - 1.0 if rest > 0.0 else float("nan")


def parts(nodes: FloatArray, strands: Sequence[int]) -> list[FloatArray]:
    """Return the nodes (N, 3) strand by strand, given how many each has."""
    return np.split(nodes, np.cumsum(strands)[:-1])


def legs(strand: FloatArray, course: int = 0, wale: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return angle and straightness of the legs of a planar knit's loops.

    A leg is the yarn between two turns of its wale coordinate, the foot and the head of a loop. The angle is that of
    its middle half (by height) to the wale, in the plane of course and wale: 0 where the leg is upright, positive where
    the loop widens towards its head. Straightness is chord over length of the middle half: 1 of a straight leg.

    Parameters
    ----------
    strand : FloatArray, shape (n, 3)
        Nodes along the yarn [m].
    course, wale : int
        Their coordinates.

    Returns
    -------
    angle : FloatArray, shape (m,)
        Angles [rad], in the order along the yarn.
    straightness : FloatArray, shape (m,)
        [1].
    """
    height = strand[:, wale]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(height))) != 0) + 1
    spans = [(int(a), int(b)) for a, b in pairwise(turns)]
    rises = np.array([abs(height[b] - height[a]) for a, b in spans])
    angles, straight = [], []
    least = LEAST_LEG * float(np.median(rises)) if len(rises) else 0.0
    for (a, b), rise in zip(spans, rises, strict=True):
        nodes = strand[a : b + 1] if height[b] > height[a] else strand[b : a - 1 if a else None : -1]
        middle = _middle_half(nodes, wale)
        if rise < least or len(middle) < 2:
            continue
        chord = middle[-1] - middle[0]
        # A leg on the yarn's way to a head is on that side of it from which the yarn comes.
        side = np.sign(strand[b, course] - strand[a, course]) * (-1.0 if height[b] > height[a] else 1.0)
        angles.append(np.arctan2(side * chord[course], chord[wale]))
        straight.append(np.linalg.norm(chord) / np.sum(np.linalg.norm(np.diff(middle, axis=0), axis=1)))
    return np.array(angles), np.array(straight)


def _middle_half(leg: FloatArray, wale: int) -> FloatArray:
    """Return the points of a rising leg between a quarter and three quarters of its height, ends interpolated."""
    height = np.maximum.accumulate(leg[:, wale])
    low, high = height[0], height[-1]
    at = np.linspace(low + 0.25 * (high - low), low + 0.75 * (high - low), 33)
    unique, first = np.unique(height, return_index=True)
    return np.stack([np.interp(at, unique, leg[first, k]) for k in range(leg.shape[1])], axis=1)

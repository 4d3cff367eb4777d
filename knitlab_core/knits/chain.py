"""Chained edge of a planar knit: a bound-off last row, or a cast-on below the first one.

The yarn comes through each loop of the edge from the back, goes along its front to the next one, around what comes out
of that, and back the same way. So each loop of the chain passes through a loop of the edge and through the loop of the
chain before; the yarn's end is drawn through the last one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.angles import cosine, sine
from knitlab_core.errors import SpecificationError
from knitlab_core.knits.curve import Curve, curve_through

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

LEGS: Final = 0.13
"""Most of half the distance of two legs [loop widths]."""

TIGHT, OVER = 0.33, 0.30
"""Half the width of a loop of a tight chain, and how far a loop reaches beyond the middle of the next edge loop [loop
widths]."""

_WIDEST: Final = 1.0
"""Largest half width of a loop of a chain [loop widths]."""

_WIDTH_DECIMALS: Final = 4

_TURN_POINTS: Final = 8
_MARKS: Final = (0, 2, 8, 14)
"""Points of a chain's loop that `Chain.marks` are of."""


class EdgeShape(NamedTuple):
    """What a chain has to know of the edge that it binds [loop widths].

    `loops`: how many; `spacing`: of rows; `height`, `depth`: of a loop of the edge, from the base line of its row;
    `front`: -z of what is farthest in front; `gap`: distance of strands one in front of the other; `first`: course
    distance from the end of the row, where the chain begins, to the middle of the first loop that it binds; `start`:
    wale coordinate of that end; `bulge`: half the width of a loop of the chain, which sets how much yarn it has.
    """

    loops: int
    spacing: float
    height: float
    depth: float
    front: float
    gap: float
    first: float
    start: float
    bulge: float = TIGHT


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chain:
    """Run from the end of a row through the loops of its edge, and through the last loop of the chain. A `Piece`.

    Parameters
    ----------
    curve : Curve
        The yarn [loop widths].
    words : str
        What edge it is.
    marks : FloatArray
        (n + 1, 4) arc lengths of each loop of the chain, in the order of the edge's loops: where it begins between two
        edge loops, one leg, its head, the other leg. The last row is the end drawn through the last loop: its begin
        and its leg, then twice the end of the yarn.
    """

    curve: Curve
    words: str
    marks: FloatArray

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return self.curve.length

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        return self.curve.position(s)

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        return self.curve.tangent(s)

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width]."""
        return self.curve.curvature(s)

    def place(self, s: float) -> str:
        """Return the edge and the nearest loop of its chain as text, counted from 0 as the chain is made."""
        return f"{self.words} edge, stitch {int(np.argmin(np.abs(self.marks[:, 2] - s)))}"


@lru_cache(maxsize=16)
def chain_along(
    edge: EdgeShape, *, words: str, mirrored: bool, upside_down: bool, origin: tuple[float, float]
) -> Chain:
    """Return the chain along an edge.

    Parameters
    ----------
    edge : EdgeShape
        The edge.
    words : str
        What it is called.
    mirrored : bool
        It is worked along -x.
    upside_down : bool
        The edge is the lower one: its loops are sinkers, and the yarn runs from the chain to the knit.
    origin : (x, y)
        Where the row ends that the chain goes on from, and the base line of that row [loop widths].
    """
    points, number = _points(edge)
    signs = np.array([-1.0 if mirrored else 1.0, -1.0 if upside_down else 1.0, 1.0])
    placed = points * signs + [*origin, 0.0]
    if upside_down:
        placed = placed[::-1]
    curve = curve_through(tuple((x, y, z) for x, y, z in placed.tolist()))
    lengths = curve.lengths[::-1] if upside_down else curve.lengths
    return Chain(curve=curve, words=words, marks=lengths[number])


@lru_cache(maxsize=8)
def loosened(edge: EdgeShape, slack: float) -> EdgeShape:
    """Return an edge whose chain has more yarn in a stitch than one that is drawn tight, by a share of it [1].

    Raises
    ------
    SpecificationError
        If loops of the chain would be wider than a row of two loops.
    """
    if slack == 0.0:
        return edge
    from scipy.optimize import brentq  # noqa: PLC0415 (slow to import, and for slack edges alone)

    tight = _stitch_length(edge)

    def missing(bulge: float) -> float:
        return (1.0 + slack) * tight - _stitch_length(edge._replace(bulge=bulge))

    if missing(_WIDEST) > 0.0:
        most = _stitch_length(edge._replace(bulge=_WIDEST)) / tight - 1.0
        raise SpecificationError("edges.slack", f"{slack:.4g}", f"from 0 to {most:.0%} with this stitch")
    return edge._replace(bulge=round(float(brentq(missing, TIGHT, _WIDEST, xtol=1e-6)), _WIDTH_DECIMALS))


def _stitch_length(edge: EdgeShape) -> float:
    """Return the mean yarn length of a stitch of a chain [loop widths]."""
    chain = chain_along(edge, words="chained", mirrored=False, upside_down=False, origin=(0.0, 0.0))
    return float(np.diff(chain.marks[:, 0]).mean())


def _points(edge: EdgeShape) -> tuple[FloatArray, FloatArray]:
    """Return points of the yarn (k, 3) from the end of a row at x = 0, worked along +x, and which of them are marks."""
    hole, legs = edge.height - 0.5 * edge.spacing, min(LEGS, edge.spacing / 6.0)
    front, gap = edge.front + edge.gap, edge.gap
    loop = _loop(legs, edge.depth, front, front + 1.35 * gap, edge.bulge)
    middles = edge.first + np.arange(edge.loops + 1.0)
    each = np.concatenate([loop + np.array([x, hole, 0.0]) for x in middles[:-1]])
    end = loop[:5] + np.array([middles[-1], hole, 0.0])
    tail = end[-1] + np.array([[0.3, 0.0, 0.0], [0.6, 0.0, 0.0]])
    turn = _turn(edge, hole)
    points = np.concatenate([turn, each, end, tail])
    first = len(turn) + len(loop) * np.arange(edge.loops + 1)
    number = first[:, None] + np.array(_MARKS)
    number[-1, 2:] = len(points) - 1
    return points, number


def _turn(edge: EdgeShape, hole: float) -> FloatArray:
    """Return points from the end of the row to the height of the holes, a half circle and what is straight after it."""
    angle = np.pi * np.arange(_TURN_POINTS) / _TURN_POINTS
    radius, middle = 0.5 * (hole - edge.start), 0.5 * (hole + edge.start)
    round_it = np.stack(
        [-abs(radius) * sine(angle), middle - radius * cosine(angle), np.full_like(angle, edge.depth)], axis=-1
    )
    way = np.arange(0.0, edge.first - 0.6, 0.25)
    return np.concatenate([round_it, np.stack([way, np.full_like(way, hole), np.full_like(way, edge.depth)], axis=-1)])


def _loop(legs: float, behind: float, front: float, crest: float, bulge: float) -> FloatArray:
    """Return points (16, 3) of a loop of a chain about the middle of the edge loop that it comes through.

    It begins at z = `behind`, half way from the loop before; its legs are at z = -`crest` where they cross the head
    before, and its own head is at z = -`front`. It is 2 `bulge` wide.
    """
    through = 0.5 * (behind - crest)
    out = np.array(
        [
            (0.13, -1.15 * legs, -0.9 * crest),
            (0.36, -0.5 * (legs + bulge), -crest),
            (0.62, -bulge, -0.5 * (crest + front)),
            (0.88, -bulge, -front),
            (1.0 + 0.7 * OVER, -0.7 * bulge, -front),
        ]
    )
    first = [(-0.5, 0.0, behind), (-0.17, -0.6 * legs, 0.9 * behind), (0.0, -legs, through)]
    last = [(-0.04, legs, through), (0.17, 0.7 * legs, 0.95 * behind)]
    back = out[::-1] * [1.0, -1.0, 1.0]
    return np.concatenate([first, out, [(1.0 + OVER, 0.0, -front)], back, last])

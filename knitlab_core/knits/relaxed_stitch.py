"""Stockinette with the loops of a periodic cell at rest: what a specimen of a real yarn is made of.

Real yarn overlaps where a stitch is drawn, so a periodic cell of it is relaxed first. Its mean loop, repeated, is
the rows of a specimen with edges, which has the pitch of the fabric at rest before anything is solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from knitlab_core.knits.curve import Curve, curve_through
from knitlab_core.knits.distance import closest_approach
from knitlab_core.knits.planar import HOOK_ANGLE
from knitlab_core.knits.stitch import Stitch

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import Centreline, SiteSet
    from knitlab_core.knits.fabric import Counts, LoopBudget
    from knitlab_core.knits.planar import PlanarRow

Point: TypeAlias = tuple[float, float, float]

_DECIMALS: Final = 9
_SAMPLES: Final = 257


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxedRow:
    """Run through a row of relaxed loops; the parameter t grows evenly along the yarn, by 2 pi a loop.

    Parameters
    ----------
    curve : Curve
        Three loops, of which the middle one repeats [loop widths].
    lift : float
        Wale coordinate of its base line [loop widths].
    number, loops : int
        Number of the row, from 0; odd ones run backwards. Number of loops.
    """

    curve: Curve
    lift: float
    number: int
    loops: int

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return self.loops * self._loop_length

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""
        return -1 if self.number % 2 else 1

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to each parameter, (n,) -> (n,) [loop widths]."""
        along: FloatArray = (np.asarray(t) + np.pi) / (2.0 * np.pi) * self._loop_length
        return along if self.direction > 0 else self.length - along

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        loop, within = self._within(s)
        moved = np.stack([loop, np.full_like(loop, self.lift), np.zeros_like(loop)], axis=-1)
        points: FloatArray = self.curve.position(within) + moved
        return points

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        tangent: FloatArray = self.direction * self.curve.tangent(self._within(s)[1])
        return tangent

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width], the same in both directions."""
        return self.curve.curvature(self._within(s)[1])

    def place(self, s: float) -> str:
        """Return row and loop as text, counted from 0."""
        return f"row {self.number}, loop {int(self._within(np.array([s]))[0][0])}"

    @property
    def _loop_length(self) -> float:
        return self.curve.length / 3.0

    def _within(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the loop of each arc length, from 0, and where it is on the curve, each (n,)."""
        along = np.asarray(s, dtype=np.float64)
        along = along if self.direction > 0 else self.length - along
        loop = np.clip(np.floor(along / self._loop_length), 0, self.loops - 1)
        return loop, along - (loop - 1.0) * self._loop_length


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxedStitch(Stitch):
    """Knit stockinette of relaxed loops. A `Fabric` whose unit, the loop width, is that of the fabric at rest.

    Height, depth and row spacing are those of the relaxed loop, its feet at (-1/2, -h, d); strands may overlap.

    Parameters
    ----------
    points : tuple of points
        The loop from foot to foot, evenly along the yarn and symmetric to its wale, without the last foot
        [loop widths].
    """

    points: tuple[Point, ...]

    @property
    def description(self) -> str:
        """Return what a table calls it."""
        return "stockinette of relaxed loops"

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return the arc length from sites to apices: of heads and sinkers, and of turn-arounds [loop widths]."""
        beside = HOOK_ANGLE / (2.0 * np.pi) * self.yarn_per_loop
        half_turn = 0.25 * np.pi * self.row_spacing
        return {"wale-": beside, "wale+": beside, "course-": half_turn, "course+": half_turn}

    @property
    def front(self) -> float:
        """Return -z of what is farthest in front: the legs [loop widths]."""
        return -min(z for _, _, z in self.points)

    @property
    def gap(self) -> float:
        """Return the distance of strands one in front of the other in a chained edge [loop widths]."""
        return 0.2

    @property
    def curve(self) -> Curve:
        """Return the loop between its neighbours: differences at its feet are as inside a row."""
        at = np.array(self.points)
        along = np.array([1.0, 0.0, 0.0])
        tiled = np.concatenate([at - along, at, at + along, at[:1] + 2.0 * along])
        return curve_through(tuple((x, y, z) for x, y, z in tiled.tolist()))

    @property
    def yarn_per_loop(self) -> float:
        """Return the yarn length of one loop [loop widths]."""
        return self.curve.length / 3.0

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; even ones run along +x, odd ones back."""
        return RelaxedRow(curve=self.curve, lift=number * self.row_spacing, number=number, loops=loops)

    def loop_length(self, counts: Counts) -> float:  # noqa: ARG002 (every loop is as long)
        """Return the yarn length of one loop [loop widths]."""
        return self.yarn_per_loop

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:  # noqa: ARG002 (no refusal)
        """Return the least distance between surfaces of strands, below zero where they press on each other."""
        s = np.linspace(0.0, self.curve.length, _SAMPLES)
        bend = float(np.linalg.norm(self.curve.curvature(s), axis=-1).max())
        apart = closest_approach(line, largest_curvature=max(bend, 2.0 / self.row_spacing))
        return apart.distance - 2.0 * self.fibre_radius

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:  # noqa: ARG002 (no estimate)
        """Return nothing: the estimate is of strands that do not press on each other."""
        return {}


def relaxed_stitch(
    drawn: Stitch, nodes: FloatArray, vectors: FloatArray, counts: Counts, radius: float
) -> tuple[RelaxedStitch, float]:
    """Return stockinette whose loop is the mean of those of a relaxed cell, and its loop width [m].

    Parameters
    ----------
    drawn : Stitch
        The stockinette that was relaxed.
    nodes : FloatArray
        Nodes of the cell at rest (N, 3), row by row, each with the first two of the next period [m].
    vectors : FloatArray
        What it repeats after at rest, (2, 3) [m].
    counts : Counts
        Its rows and loops; odd rows run back.
    radius : float
        Radius at which strands touch [m].
    """
    width = float(vectors[0, 0]) / counts.loops
    rows = enumerate(np.split(nodes / width, counts.rows))
    loops = [loop for number, row in rows for loop in _loops_of(row[:-2], counts.loops, -1 if number % 2 else 1)]
    mean: FloatArray = np.mean(loops, axis=0)
    mean[:, 1] -= 0.5 * (mean[0, 1] + mean[len(mean) // 2, 1])
    mean[:, 2] -= 0.5 * (mean[:, 2].max() + mean[:, 2].min())
    points = np.round(mean, _DECIMALS)
    stitch = RelaxedStitch(
        curvature=drawn.curvature,
        height=float(-points[0, 1]),
        depth=float(points[0, 2]),
        row_spacing=round(float(vectors[1, 1]) / counts.rows / width, _DECIMALS),
        fibre_radius=round(radius / width, _DECIMALS),
        points=tuple((x, y, z) for x, y, z in points.tolist()),
    )
    return stitch, width


def _loops_of(nodes: FloatArray, loops: int, direction: int) -> list[FloatArray]:
    """Return the points (n, 3) of every loop of a relaxed row and of its mirror image, about its wale."""
    period = np.array([float(direction * loops), 0.0, 0.0])
    before, after = np.roll(nodes, 1, axis=0), np.roll(nodes, -1, axis=0)
    before[0] -= period
    after[-1] += period
    points = 0.125 * (before + after) + 0.75 * nodes
    points = np.concatenate([points, points[:1] + period])[::direction]
    each = (len(points) - 1) // loops
    found = []
    for loop in range(loops):
        one = points[loop * each : (loop + 1) * each + 1]
        one = one - [0.5 * (one[0, 0] + one[-1, 0]), one[:, 1].mean(), one[:, 2].mean()]
        found += [one[:-1], (one[::-1] * [-1.0, 1.0, 1.0])[:-1]]
    return found

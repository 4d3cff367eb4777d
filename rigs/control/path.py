"""Equilibria along a straight path of the axes, with the fibres that break on it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.rupture import OVERSHOOT, reach_rupture
from knitlab_core.equilibrium.snap_location import with_snap_counted
from knitlab_core.equilibrium.snap_through import jumps_between
from knitlab_core.equilibrium.step_control import Pace
from knitlab_core.errors import ConvergenceError
from rigs.control.resume_point import START, PathPosition
from rigs.machines.rig import most_strained, pose, without_edge

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options, Report
    from knitlab_core.equilibrium.rupture import Spot
    from rigs.axes import Axis, FloatArray
    from rigs.control.resume_point import Displacement
    from rigs.machines.rig import Rig

MOST_BREAKS: Final = 100
"""Fibres that may break one after the other with the carriages where they are; beyond, the specimen is torn."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathPoint:
    """One equilibrium on a path.

    Attributes
    ----------
    share : float
        Its share of the path [1].
    displacement : Mapping
        Displacements of the axes [m].
    state, report
        The specimen's state, and how its search went.
    rig : Rig
        The rig there; another one after a fibre broke.
    broken : Spot or None
        Where a fibre breaks at this equilibrium.
    final : bool
        Whether the test ends with that break.
    place : PathPosition or None
        Position from which the path can be resumed; None where a fibre breaks, or right before strands snap.
    peaks : tuple of PathPoint
        The equilibria right before the specimen jumped on the path to this one, without the one at its start.
    jumps : tuple of float
        Shares of the path at which it jumped, that at its start too [1].
    """

    share: float
    displacement: Displacement
    state: State
    report: Report
    rig: Rig
    broken: Spot | None = None
    final: bool = False
    place: PathPosition | None = None
    peaks: tuple[PathPoint, ...] = ()
    jumps: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisPath:
    """Straight path of the axes: its ends [m], its time [s], and the settings of its march.

    Attributes
    ----------
    start, goal : Mapping
        Displacements at its begin and its end [m].
    longest : float
        Longest step, as a share of the path.
    duration : float
        Time it takes, at an even pace [s]; it matters only to yarn that relaxes.
    options : Options or None
        How hard the solver tries.
    go_on : bool
        Whether it goes on after a fibre broke.
    """

    start: Displacement
    goal: Displacement
    longest: float
    duration: float
    options: Options | None
    go_on: bool

    def target(self, rig: Rig, share: float) -> FloatArray:
        """Return the target (N, 4) of what is held [r] at a share of the path."""
        return pose(rig, between(self.start, self.goal, share))


def between(start: Displacement, end: Displacement, share: float) -> dict[Axis, float]:
    """Return the displacements at a share of a path; exact at both ends, and for an axis that does not move."""
    if share == 1.0:
        return dict(end)
    return {axis: start[axis] + share * (end[axis] - start[axis]) for axis in end}


def with_jumps(start: State, steps: Sequence[PathPoint]) -> PathPoint:
    """Return the last point of a path with the jumps of the specimen on it; several at one displacement are one."""
    states = [start, *(step.state for step in steps)]
    shares = [0.0, *(step.share for step in steps)]
    before = [
        number
        for number, (state, after) in enumerate(pairwise(states))
        if jumps_between(state, after) and not (number and shares[number] == shares[number - 1])
    ]
    peaks = tuple(steps[number - 1] for number in before if number)
    return replace(steps[-1], peaks=peaks, jumps=tuple(shares[number] for number in before))


def follow(rig: Rig, state: State, axis_path: AxisPath, place: PathPosition = START) -> Iterator[PathPoint]:
    """Yield the equilibria on a path, or those after a position on it.

    Where a fibre breaks, the equilibrium at which it does is one of them, and so is the one after it at the same
    place, where there is one; a test that does not go on ends with it.
    """
    while place.share < 1.0:
        broken, at = None, place.share
        for step in _whole(rig, state, axis_path, place):
            if _breaks(rig, step.state):
                broken = _cut_short(rig, state, axis_path, at, step)
                break
            state, at = step.state, step.share
            yield step
        if broken is None:
            return
        after = _after(broken, axis_path)
        yield replace(broken, final=after is None)
        if after is None:
            return
        yield after
        if after.final:
            return
        rig, state, place = after.rig, after.state, PathPosition(begin=after.share)


def _whole(rig: Rig, state: State, axis_path: AxisPath, place: PathPosition) -> Iterator[PathPoint]:
    """Yield the equilibria from a position on a path to its end, as if nothing broke."""
    left, pace = 1.0 - place.begin, Pace(at=place.at, step=place.step)

    path = march(
        rig.work,
        state,
        lambda share: axis_path.target(rig, replace(place, at=share).share),
        longest=min(1.0, axis_path.longest / left),
        options=axis_path.options,
        duration=left * axis_path.duration,
        pace=pace,
    )
    for at, reached, report in path:
        here = PathPosition(begin=place.begin, at=at, step=pace.step)
        yield PathPoint(
            share=here.share,
            displacement=between(axis_path.start, axis_path.goal, here.share),
            state=reached,
            report=report,
            rig=rig,
            place=here if pace.resumable else None,
        )


def _breaks(rig: Rig, state: State) -> bool:
    """Return whether a fibre is strained to its limit, or beyond."""
    return rig.breaks_at is not None and most_strained(rig, state).strain >= rig.breaks_at


def _cut_short(rig: Rig, before: State, axis_path: AxisPath, begin: float, step: PathPoint) -> PathPoint:
    """Return the equilibrium of a step at which the first fibre reaches its limit.

    Where it is not found, the step is taken whole: a knit that snaps passes the limit without reaching it. So is a
    step on which a fused point breaks, which cannot be made again.
    """
    limit, work = rig.breaks_at or 0.0, rig.work
    whole = replace(step, broken=most_strained(rig, step.state), place=None)
    bonds_broke = bool((before.bonds.hold != step.state.bonds.hold).any())
    if bonds_broke or most_strained(rig, before).strain >= limit * (1.0 - OVERSHOOT):
        return whole
    length = step.share - begin
    span = length * axis_path.duration

    def path(share: float) -> FloatArray:
        return axis_path.target(rig, begin + share * length)

    share, found, _, report = reach_rupture(
        work,
        before,
        path,
        limit=limit,
        radius=rig.fibre_reach,
        options=axis_path.options,
        duration=span,
        end=(step.state, step.report),
    )
    if found is None or report is None:
        return whole
    at = begin + share * length
    return PathPoint(
        share=at,
        displacement=between(axis_path.start, axis_path.goal, at),
        state=found,
        report=report,
        rig=rig,
        broken=most_strained(rig, found),
    )


def _after(broken: PathPoint, axis_path: AxisPath) -> PathPoint | None:
    """Return the equilibrium after a fibre broke; None if none is found.

    If the test goes on, fibres that this break overstrains break too; if not, it ends with this one.
    """
    rig, state = broken.rig, broken.state
    try:
        for _ in range(MOST_BREAKS):
            rig, state = without_edge(rig, state, most_strained(rig, state).edge, axis_path.options)
            if not (axis_path.go_on and _breaks(rig, state)):
                break
        else:
            return None
    except ConvergenceError:
        return None
    settled, report = advance(rig.work, state, axis_path.target(rig, broken.share), axis_path.options)
    if settled is None:
        return None
    return PathPoint(
        share=broken.share,
        displacement=broken.displacement,
        state=with_snap_counted(state, settled, report),
        report=report,
        rig=rig,
        broken=None if axis_path.go_on else broken.broken,
        final=not axis_path.go_on,
        place=PathPosition(begin=broken.share) if axis_path.go_on else None,
    )

"""Steer the axes row by row where their places must be searched for, or a force says where they stop.

It serves preloads, forces that are controlled, axes that give way, machines that do, and steps that end at a force.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Final

from knitlab_core.equilibrium.stopwatch import Cost
from rigs.endings import TOLERANCE, Ending
from rigs.helm import helm_of
from rigs.motion import PRELOAD_REACH

if TYPE_CHECKING:
    from collections.abc import Generator

    from rigs.bench import Bench
    from rigs.endings import Watch
    from rigs.helm import Helm
    from rigs.motion import Stroke
    from rigs.record import Equilibrium, Frame
    from rigs.servo import Settled

MOST_REFINEMENTS: Final = 40

CLOSE: Final = 1e-3
"""Share of a stroke that is not worth a row of its own."""

SLOWEST_PACE: Final = 1e-3
"""Shortest share of such a stroke from row to row."""


def steer(
    bench: Bench, stroke: Stroke, watch: Watch, marks: list[float], images: list[float]
) -> Generator[Equilibrium | Frame, None, Ending | None]:
    """Go through a stroke row by row.

    An axis of a preload that has met its force stays where it is while the others go on, as with a stop switch: what
    it carries in the end is no longer controlled.

    Parameters
    ----------
    bench, stroke, watch
        The test under way, the stroke, and what may end its step.
    marks, images : list of float
        Shares of the stroke at which there must be a row, and at which a picture is taken of it, each rising.

    Yields
    ------
    Equilibrium or Frame
        Every row on the way; none lies beyond a stop.

    Returns
    -------
    Ending or None
        A limit, if the reach of a preload or an instrument's range is used up before; what ended the step otherwise.
    """
    helm = helm_of(bench, stroke, watch)
    last, ending = watch.cut(bench.memory, bench.cursor.begun)
    caught_up = True
    if helm.share > 0.0 and any(abs(image - helm.share) <= 1e-9 for image in images):
        # A test that goes on from this row took its picture after it.
        yield bench.pictured(bench.memory.image_tag)
    while not helm.stop():
        if helm.share >= last and caught_up:
            return _short(helm) if stroke.stop_force is not None and ending is None else ending
        ahead = [mark for mark in (*marks, *images, last) if mark > helm.share + 1e-9] or [last]
        # A step that ends just short of a mark goes on to it: a way that begins beside its place is a little longer.
        aim, mark = helm.share + helm.pace, min(ahead)
        settled, share = _approach(helm, mark if aim > mark - CLOSE else aim)
        caught_up = settled.met
        share = share if caught_up else _lag(helm, settled, share)
        over = yield from _peaks(helm, settled, share)
        if over is not None:
            return over
        _learn(helm, settled, share)
        helm.share = share
        bench.time = helm.time(share)
        helm.note()
        before = bench.displacement
        row = bench.accept(settled.step, stroke, settled.crosshead)
        pictured = any(abs(image - share) <= 1e-9 for image in images)
        marked = any(abs(mark - share) <= 1e-9 for mark in marks)
        # Where the stroke ends a frame is kept in any case.
        between_ends = stroke.phase != "Hold" and share < last - 1e-9
        if between_ends and not pictured and (marked or bench.passes_frame(before)):
            yield bench.frame()
        yield row
        over = bench.over() or watch.met(bench.controller, bench.memory, bench.crosshead)
        if pictured:
            yield bench.pictured(bench.memory.image_tag)
        if over is not None:
            return over
    return None


def _peaks(helm: Helm, settled: Settled, share: float) -> Generator[Equilibrium, None, Ending | None]:
    """Yield the rows right before the specimen jumps on the way to a share; return what ends the test at one.

    A jump comes when the crosshead of the axis that goes farthest is where it was then. Between two jumps of one way
    several axes are not in balance with what is asked of them: of these ways the first peak alone is a row.
    """
    bench, stroke, begin = helm.bench, helm.stroke, helm.share
    start = bench.crosshead
    far = max(bench.rig.grips, key=lambda axis: abs(settled.crosshead[axis] - start[axis]) / bench.rig.gauges[axis])
    way = settled.crosshead[far] - start[far]
    peaks = settled.step.peaks
    for peak in peaks if len(bench.rig.grips) == 1 else peaks[:1]:
        crosshead = helm.crosshead(peak, share)
        gone = (crosshead[far] - start[far]) / way if way != 0.0 else peak.share
        helm.share = max(helm.share, begin + min(max(gone, 0.0), 1.0) * (share - begin))
        bench.time = helm.time(helm.share)
        # From here nothing can go on: the row after the jump is found from the row before this one.
        # Its cost counts with the row after it.
        yield bench.accept(replace(peak, place=None, cost=Cost()), stroke, crosshead)
        over = bench.over()
        if over is not None:
            return over
    return None


def _approach(helm: Helm, share: float) -> tuple[Settled, float]:
    """Return the equilibrium at a share, or before it where a force ends the way or the knit strains too much.

    A fibre that ends the test by breaking ends it there.
    """
    begin, bench = helm.share, helm.bench
    found = helm.settle(share)
    while helm.open_ended and found.met and share - begin > 2.0 * SLOWEST_PACE:
        if bench.strain(bench.crosshead, found.crosshead) <= 1.5 * bench.increment:
            break
        share = begin + 0.5 * (share - begin)
        helm.pace = share - begin
        found = _with_cost(helm.settle(share), found)
    over = helm.excess(found, share)
    if over <= TOLERANCE or not found.met:
        return found, share
    low, high, under = begin, share, _before(helm)
    for _ in range(MOST_REFINEMENTS):
        # Regula falsi, kept from either end: the force is nought while the knit is slack.
        share = low + (high - low) * min(max(under / (under - over), 0.1), 0.9)
        found = _with_cost(helm.settle(share), found)
        value = helm.excess(found, share)
        if abs(value) <= TOLERANCE or (found.step.final and value < 0.0):
            break
        if value > 0.0:
            high, over = share, value
        else:
            low, under = share, value
    return found, share


def _before(helm: Helm) -> float:
    """Return by what share something is short of ending the way where the bench stands."""
    bench, stroke = helm.bench, helm.stroke
    passed = helm.watch.excess(bench.memory, bench.memory.shown, bench.crosshead)
    going = [axis for axis in stroke.named if axis not in helm.stopped]
    short = [] if stroke.stop_force is None else [bench.memory.shown[axis] / stroke.stop_force - 1.0 for axis in going]
    value = max([passed, *short])
    return min(value, -TOLERANCE) if value > -inf else -1.0


def _with_cost(found: Settled, before: Settled) -> Settled:
    """Return an equilibrium with the cost of the trial before added to its own."""
    return replace(found, step=replace(found.step, cost=found.step.cost + before.step.cost))


def _lag(helm: Helm, settled: Settled, share: float) -> float:
    """Return the share at which axes that went as far as they may arrive there at their highest speed."""
    bench, duration = helm.bench, helm.stroke.duration
    time = max(
        abs(at - bench.crosshead[axis]) / bench.rig.trains[axis].fastest for axis, at in settled.crosshead.items()
    )
    room = share - helm.share
    if room <= 0.0 or time > room * duration:
        helm.late += time - room * duration
        return share
    return helm.share + time / duration


def _learn(helm: Helm, settled: Settled, share: float) -> None:
    """Keep what helps the search at the next row, and its pace."""
    bench, way = helm.bench, share - helm.share
    travel = settled.step.displacement
    if settled.met and way > 0.0:
        helm.trend = {axis: (travel[axis] - at) / way for axis, at in bench.displacement.items()}
    else:
        helm.trend = {}
    helm.slope = settled.slope if settled.slope.size else None
    if helm.open_ended and bench.strain(bench.crosshead, settled.crosshead) < 0.5 * bench.increment:
        helm.pace = min(2.0 * helm.pace, 0.25)


def _short(helm: Helm) -> Ending:
    """Return the ending of a test whose preload was not met."""
    force, shown = helm.stroke.stop_force or 0.0, helm.bench.memory.shown
    short = ", ".join(
        f"axis {axis} carries {shown[axis]:.3g} N" for axis in helm.stroke.named if axis not in helm.stopped
    )
    reach = f"preload of {force:g} N not met within a strain of {PRELOAD_REACH:g}"
    return Ending(end="limit", message=f"{reach}: {short}", test=True)

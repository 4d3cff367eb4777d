"""Force control: the axes move from row to row to displacements that are searched for, or stop at a force.

It serves preloads, forces that are controlled, axes that give way, machines that do, and steps that end at a force.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import ConvergenceError
from rigs.control.lost_control import lost_control
from rigs.control.setpoint_search import REACH, breaks
from rigs.control.setpoints import setpoints_of
from rigs.control.stop_criteria import TOLERANCE, StopReason
from rigs.machines.rig import read
from rigs.protocol.strokes import PRELOAD_REACH

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from rigs.control.session import Session
    from rigs.control.setpoint_search import ControlledPoint
    from rigs.control.setpoints import Setpoints
    from rigs.control.stop_criteria import StopCriteria
    from rigs.protocol.strokes import Stroke
    from rigs.record import Equilibrium, Frame

MOST_REFINEMENTS: Final = 40

CLOSE: Final = 1e-3
"""Marks that are nearer to each other than this share of a stroke have one row."""

LONGEST: Final = 1.5
"""Longest travel of an axis from row to row in a stroke under a controlled force, in largest strain increments."""

FARTHEST: Final = 20.0
"""Longest jump of machines and of axes without a controller, in largest strain increments."""

FEW: Final = 12
"""Most trials after a fibre broke under a controlled force; fibres that take over its load do so within them."""

AFTER_JUMP: Final = 1.0 / 16.0
"""Part of the way to the next row by which a row comes after a jump of the specimen; half the way to the next jump."""

MOST_FAILURES: Final = 3
"""Most failures of the solver on the way to the next row."""


def control_force(
    session: Session, stroke: Stroke, criteria: StopCriteria, marks: list[float], images: list[float]
) -> Generator[Equilibrium | Frame, None, StopReason | None]:
    """Make a stroke under force control, row by row.

    An axis of a preload that has met its force stays where it is while the others go on, as with a stop switch: what
    it carries in the end is no longer controlled.

    Parameters
    ----------
    session, stroke, criteria
        The test under way, the stroke, and what may end its step.
    marks, images : list of float
        Shares of the stroke at which there must be a row, and at which a picture is taken of it, each rising.

    Yields
    ------
    Equilibrium or Frame
        Every row of the stroke; none is beyond a stop.

    Returns
    -------
    StopReason or None
        A limit, if the reach of a preload or an instrument's range is used up before; what ended the step otherwise.
    """
    setpoints = setpoints_of(session, stroke, criteria)
    last, ending = criteria.cut(session.memory, session.cursor.begun)
    if setpoints.share > 0.0 and any(abs(image - setpoints.share) <= 1e-9 for image in images):
        # A test that goes on from this row took its picture after it.
        yield session.pictured(session.memory.image_tag)
    while not setpoints.stop():
        if setpoints.share >= last:
            return _short(setpoints) if stroke.stop_force is not None and ending is None else ending
        ahead = [mark for mark in (0.0, *marks, *images, last) if mark > setpoints.share + 1e-9] or [last]
        # A step that ends just short of a mark goes on to it.
        aim, mark = setpoints.share + setpoints.pace, min(ahead)
        settled, share = _approach(setpoints, mark if aim > mark - CLOSE else aim)
        if not settled.met:
            return lost_control(setpoints, settled, share)
        before = session.displacement
        over = yield from _peaks(setpoints, settled, share)
        if over is not None:
            return over
        row = setpoints.accept(settled, share, before)
        pictured = any(abs(image - share) <= 1e-9 for image in images)
        marked = any(abs(mark - share) <= 1e-9 for mark in marks)
        # Where the stroke ends a frame is kept in any case.
        between_ends = stroke.phase != "Hold" and share < last - 1e-9
        if between_ends and not pictured and (marked or session.passes_frame(before)):
            yield session.frame()
        yield row
        over = session.over() or criteria.met(session.controller, session.memory, session.crosshead)
        if pictured:
            yield session.pictured(session.memory.image_tag)
        if over is not None:
            return over
    return None


def _peaks(
    setpoints: Setpoints, settled: ControlledPoint, share: float
) -> Generator[Equilibrium, None, StopReason | None]:
    """Yield the rows right before the specimen jumps before a share; return what ends the test at one.

    A jump comes when a controlled force is what it was then, or else when the crosshead of the axis that goes farthest
    is where it was.
    """
    session, stroke = setpoints.session, setpoints.stroke
    begun, start, peaks = setpoints.time(setpoints.share), session.crosshead, settled.step.peaks
    carried = read(session.rig, session.state).force
    rising = [axis for axis, (first, last) in stroke.force.items() if first != last and setpoints.share >= 0.0]
    far = max(session.rig.grips, key=lambda axis: abs(settled.crosshead[axis] - start[axis]) / session.rig.gauges[axis])
    for peak in peaks:
        crosshead = setpoints.crosshead(peak, share)
        if rising:
            ends = (read(step.rig, step.state).force[rising[0]] for step in (peak, settled.step))
            progress = _share_of(carried[rising[0]], *ends, otherwise=peak.share)
        else:
            progress = _share_of(start[far], crosshead[far], settled.crosshead[far], otherwise=peak.share)
        session.time = max(session.time, begun + progress * settled.duration)
        # No test resumes here: the row after the jump is found from the row before this one.
        yield session.accept(replace(peak, place=None), stroke, crosshead)
        over = session.over()
        if over is not None:
            return over
    return None


def _share_of(first: float, now: float, last: float, *, otherwise: float) -> float:
    """Return the share at which a value is between its first and its last [1]."""
    return min(max((now - first) / (last - first), 0.0), 1.0) if last != first else otherwise


def _approach(setpoints: Setpoints, share: float) -> tuple[ControlledPoint, float]:
    """Return the equilibrium at a share, or before it where a force ends the step or the knit strains too much.

    A fibre that ends the test by breaking ends it there.
    """
    found, share = _within_reach(setpoints, share)
    over = setpoints.excess(found, share)
    if over <= TOLERANCE or not found.met:
        return found, share
    low, high, under = setpoints.share, share, _before(setpoints)
    for _ in range(MOST_REFINEMENTS):
        # Regula falsi, kept from either end: the force is zero while the knit is slack.
        share = low + (high - low) * min(max(under / (under - over), 0.1), 0.9)
        found = setpoints.settle(share)
        value = setpoints.excess(found, share)
        if found.met and (abs(value) <= TOLERANCE or (found.step.final and value < 0.0)):
            break
        if value > 0.0 or not found.met:
            high, over = share, max(value, TOLERANCE)
        else:
            low, under = share, value
    return found, share


def _within_reach(setpoints: Setpoints, share: float) -> tuple[ControlledPoint, float]:
    """Return the equilibrium at a share, or so far before it that axes may go there from row to row.

    Where they must travel too far, or what is asked is not met, the share is halved; where the specimen jumps on the
    way, it ends soon after the first jump. It is not met where even the shortest has no such equilibrium; machines and
    axes without a controller go as far as they jump.
    """
    begin, finest, session = setpoints.share, setpoints.finest(), setpoints.session
    controlled, limited = setpoints.stroke.force, setpoints.open_ended or setpoints.share < 0.0
    failures = 0
    while True:
        shortest, found, part = share - begin <= 1.01 * finest, None, None
        try:
            found = setpoints.settle(share, FARTHEST if shortest else REACH, unbroken=bool(controlled))
            if shortest and not found.met and controlled and breaks(session, found.step):
                taken_over = setpoints.settle(share, most=FEW)
                found = taken_over if taken_over.met else found
        except ConvergenceError:
            failures += 1
            if shortest or failures > MOST_FAILURES:
                raise
        if found is not None:
            strains = session.strains(session.displacement, found.step.displacement)
            far = any(
                strain > LONGEST * session.increment
                for axis, strain in strains.items()
                if limited and (axis in controlled or not shortest)
            )
            # Under a controlled force a break that ends the test may be beyond the setpoint.
            if found.met and not far and (shortest or not (controlled and found.step.final)):
                part = _after_jump(found.step.jumps, alone=not controlled)
                if shortest or part is None:
                    return found, share
            elif shortest:
                return replace(found, met=False), share
        share = max(begin + (part or 0.5) * (share - begin), begin + finest)
        if part is None:
            setpoints.pace, setpoints.shortened = share - begin, True


def _after_jump(jumps: Sequence[float], *, alone: bool) -> float | None:
    """Return the part of a way on which the specimen jumps that ends after the first jump; None where it is all of it.

    Of a jump `alone` the row after it is close as well. A controlled force is lost in it, and regained later.
    """
    if not jumps:
        return None
    first, second = jumps[0], jumps[1] if len(jumps) > 1 else 1.0
    if len(jumps) == 1 and not (alone and 1.0 - first > 2.0 * AFTER_JUMP):
        return None
    return first + min(AFTER_JUMP, 0.5 * (second - first))


def _before(setpoints: Setpoints) -> float:
    """Return by what share the nearest criterion is short of its level in the current state."""
    session, stroke = setpoints.session, setpoints.stroke
    passed = setpoints.criteria.excess(session.memory, session.memory.shown, session.crosshead)
    going = [axis for axis in stroke.named if axis not in setpoints.stopped]
    short = (
        [] if stroke.stop_force is None else [session.memory.shown[axis] / stroke.stop_force - 1.0 for axis in going]
    )
    value = max([passed, *short])
    return min(value, -TOLERANCE) if value > -inf else -1.0


def _short(setpoints: Setpoints) -> StopReason:
    """Return the ending of a test whose preload was not met."""
    force, shown = setpoints.stroke.stop_force or 0.0, setpoints.session.memory.shown
    short = ", ".join(
        f"axis {axis} carries {shown[axis]:.3g} N" for axis in setpoints.stroke.named if axis not in setpoints.stopped
    )
    reach = f"preload of {force:g} N not met within a strain of {PRELOAD_REACH:g}"
    return StopReason(end="limit", message=f"{reach}: {short}", test=True)

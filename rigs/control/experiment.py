"""Run of a test: setpoint, pose, equilibrium, forces on the carriages, one row of the record.

`perform` yields events as they happen and opens no files; its caller writes them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

from knitlab_core.equilibrium.march import Failure
from knitlab_core.errors import ConvergenceError
from rigs.control.checkpoint import Checkpoint
from rigs.control.controller import controller_of
from rigs.control.displacement_control import control_displacement, hold, hold_marks, image_shares, inner_marks
from rigs.control.force_control import control_force
from rigs.control.planner import Planner
from rigs.control.resume_point import ResumePoint
from rigs.control.session import Session
from rigs.control.stop_criteria import StopReason, stop_criteria_of
from rigs.instruments.zeros import Zeroing
from rigs.machines.rig import place_of
from rigs.protocol.strokes import Stroke
from rigs.protocol.unrolled import unrolled
from rigs.record import Equilibrium, Frame, Outcome
from rigs.step_record import StepRecord

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Iterator

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from rigs.control.stop_criteria import StopCriteria
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.step import Pictures
    from rigs.protocol.unrolled import UnrolledStep


@dataclass(frozen=True, slots=True)
class Waiting:
    """A test waits: its steps so far are done, and the next is not known yet."""


Event: TypeAlias = Equilibrium | Checkpoint | Frame | Zeroing | StepRecord | Waiting | Outcome


def perform(
    rig: Rig, state: State, protocol: Protocol, *, options: Options | None = None, cursor: ResumePoint | None = None
) -> Iterator[Event]:
    """Run a protocol on a mounted specimen.

    Parameters
    ----------
    rig : Rig
        The rig with the specimen on it.
    state : State
        The specimen as mounted.
    protocol : Protocol
        The test.
    options : Options, optional
        How hard the solver tries.
    cursor : ResumePoint, optional
        Where to resume the test, with the rig and the state there; by default it begins.

    Yields
    ------
    Equilibrium, Checkpoint, Frame, Zeroing, StepRecord or Outcome
        Rows and shapes in the order of time, and each zeroing when it happens; the one outcome comes last. A step is
        recorded when it begins, as if it were aborted, and when it ends. A limit that trips and an equilibrium that is
        not found are outcomes: what was yielded before stays. A checkpoint follows every row from which the test can
        go on.
    """
    planner = Planner(protocol=protocol, gauges=rig.gauges)
    session = session_of(rig, state, planner, options=options, cursor=cursor)
    yield from perform_steps(session, planner, unrolled(protocol.steps))


def session_of(
    rig: Rig, state: State, planner: Planner, *, options: Options | None = None, cursor: ResumePoint | None = None
) -> Session:
    """Return the session of a test that begins, or resumes; the parameters are those of `perform`."""
    protocol = planner.protocol
    controller = controller_of(rig, seed=protocol.log.seed, noise=protocol.log.noise)
    return Session(
        rig=rig,
        state=state,
        controller=controller,
        increment=protocol.max_strain_increment,
        options=options,
        go_on=protocol.specimen.rupture == "go on",
        cursor=ResumePoint(memory=controller.begin(planner.begin())) if cursor is None else cursor,
    )


def perform_steps(session: Session, planner: Planner, leaves: Iterable[UnrolledStep | None]) -> Iterator[Event]:
    """Do steps one after the other and yield what `perform` does.

    Where `leaves` gives None the next step is not known yet: a `Waiting` is yielded, and it is asked again.
    """
    try:
        outcome = yield from _with_checkpoints(session, _carry_out(session, planner, leaves))
    except ConvergenceError as error:
        outcome = Outcome(end="diverged", message=_account(session, error))
    if outcome.end != "target":
        yield session.frame()
    yield replace(outcome, unfinished=session.uncounted())


def _with_checkpoints(session: Session, events: Generator[Event, None, Outcome]) -> Generator[Event, None, Outcome]:
    """Add a checkpoint after every row from which the test can go on."""
    while True:
        try:
            event = next(events)
        except StopIteration as end:
            outcome: Outcome = end.value
            return outcome
        yield event
        if isinstance(event, Equilibrium):
            checkpoint = session.checkpoint()
            if checkpoint is not None:
                yield checkpoint


def _carry_out(
    session: Session, planner: Planner, leaves: Iterable[UnrolledStep | None]
) -> Generator[Event, None, Outcome]:
    """Do the steps that are left; return how the test ended."""
    if session.last is None:
        still = Stroke(start=session.crosshead, end=session.crosshead, duration=0.0, phase="Zero", cycle=1, force={})
        yield session.accept(session.reach(session.displacement), still, session.crosshead)
        yield session.frame()
        if session.parted():
            return Outcome(end="unravelled", message=f"nothing to test as mounted: {session.parted()}")
    done = Outcome(end="target")
    for leaf in leaves:
        if leaf is None:
            yield Waiting()
            continue
        if leaf.number < session.cursor.leaf:
            continue
        ending = yield from _do_step(session, planner, leaf)
        if ending is not None and ending.test:
            return Outcome(end=ending.end, message=ending.message)
        if ending is not None and ending.end in {"rupture", "slipped"} and leaf.step.to_rupture:
            done = Outcome(end=ending.end, message=ending.message)
    if done.end == "target" and session.parted():
        return Outcome(end="unravelled", message=session.parted())
    return done


def _do_step(session: Session, planner: Planner, leaf: UnrolledStep) -> Generator[Event, None, StopReason | None]:
    """Do one step, or what is left of it; return how it ended if not at its target."""
    begins = leaf.number > session.cursor.leaf or session.cursor.readings is None
    if begins:
        session.remember(session.controller.start_step(session.memory, session.time))
        session.cursor = replace(session.cursor, leaf=leaf.number, stroke=0, readings=None)
    record = StepRecord(
        number=leaf.number,
        place=leaf.place,
        tag=leaf.step.tag,
        start=session.memory.since,
        time=session.time,
        end="abort",
    )
    if begins:
        yield record
    if leaf.step.pictures is not None:
        yield from _picture(session, leaf.step.pictures, leaf.step.tag)
    try:
        ending = yield from _do_strokes(session, planner, leaf)
    except ConvergenceError as error:
        yield replace(record, time=session.time, end="diverged", message=_account(session, error))
        raise
    if ending is None and leaf.step.to_rupture:
        ending = StopReason(end="limit", message="no rupture on the way")
    done = StopReason(end="target", message="") if ending is None else ending
    yield replace(record, time=session.time, end=done.end, message=done.message)
    return ending


def _do_strokes(session: Session, planner: Planner, leaf: UnrolledStep) -> Generator[Event, None, StopReason | None]:
    """Do the strokes of a step that are left; return what ended it, if anything did."""
    for index in range(session.cursor.stroke, leaf.step.stroke_count):
        if index > session.cursor.stroke:
            session.cursor = replace(session.cursor, stroke=index, readings=None)
        under_way = session.cursor.readings
        readings = under_way or session.readings()
        stroke = planner.stroke(leaf, index, session.memory.history, readings)
        if stroke is None:
            continue
        criteria = stop_criteria_of(leaf, stroke, session.memory.history.gauges)
        ending = None
        if under_way is None:
            if index == 0 and (met := criteria.met_before(session.memory, session.crosshead)) is not None:
                return met
            session.begin(readings)
        else:
            ending = criteria.met(session.controller, session.memory, session.crosshead)
        if ending is None:
            ending = yield from _do(session, stroke, criteria, leaf.place)
        else:
            # The row from which the test is resumed was the step's last.
            yield session.frame()
        after = session.memory.history.after(stroke, session.readings())
        session.remember(replace(session.memory, history=after))
        if ending is not None:
            return ending
    return None


def _picture(session: Session, pictures: Pictures, tag: str | None) -> Iterator[Event]:
    """Take a picture, or begin or end a series of them."""
    if pictures != "one":
        every = None if pictures == "off" else pictures
        session.remember(replace(session.memory, every=every, image_since=session.time, image_tag=tag))
    if pictures != "off":
        yield session.pictured(tag)


def _do(
    session: Session, stroke: Stroke, criteria: StopCriteria, place: str
) -> Generator[Event, None, StopReason | None]:
    """Do one stroke of the step at a place in the protocol; return what ended the step, if anything did."""
    if stroke.phase == "Zero":
        # A specimen that does not move keeps its equilibrium: there is nothing to solve.
        if session.last is not None and session.last.phase != "Zero":
            yield session.stand(stroke)
        if "force" in stroke.channels:
            session.remember(session.controller.zero(session.memory))
        yield _zeroing(session, stroke, place)
        return None
    tripped = _too_fast(session, stroke)
    if tripped is not None:
        return tripped
    elastic = session.rig.work.model.relaxation is None
    straight = all(train.rigid for train in session.rig.trains.values()) and not (stroke.force or stroke.free)
    if stroke.phase == "Hold" and (elastic or straight):
        return (yield from hold(session, stroke, criteria))
    seeks = stroke.stop_force is not None or (criteria.until is not None and criteria.until.force is not None)
    if straight and not seeks:
        return (yield from control_displacement(session, stroke, criteria))
    marks = hold_marks(session, stroke) if stroke.phase == "Hold" else inner_marks(stroke, session.rig.gauges)
    ending = yield from control_force(
        session, stroke, criteria, marks, image_shares(stroke, session.memory, session.cursor.begun)
    )
    if ending is None or not ending.test:
        yield session.frame()
    return ending


def _zeroing(session: Session, stroke: Stroke, place: str) -> Zeroing:
    """Return the zeroing of a stroke, with the state of the axes at that moment."""
    force = dict.fromkeys(session.rig.grips, 0.0) if session.last is None else session.last.force
    return Zeroing(
        time=session.time,
        kinds=frozenset(stroke.channels),
        place=place,
        travel=dict(session.crosshead),
        force=dict(force),
        gauges=dict(stroke.gauges or session.memory.history.gauges),
    )


def _too_fast(session: Session, stroke: Stroke) -> StopReason | None:
    """Return the ending of a test whose machine has no such speed."""
    for axis, train in session.rig.trains.items():
        travel = abs(stroke.end[axis] - stroke.start[axis])
        speed = travel / stroke.duration if stroke.duration > 0.0 else 0.0
        if speed > train.fastest * (1.0 + 1e-9):
            has = f"speed: axis {axis} would move at {1e3 * speed:.4g} mm/s, limit {1e3 * train.fastest:.4g} mm/s"
            return StopReason(end="limit", message=has, test=True)
    return None


def _account(session: Session, error: ConvergenceError) -> str:
    """Return the strains of the axes and the place on the yarn at which no equilibrium was found."""
    failure = error.report
    if not isinstance(failure, Failure):
        return str(error)
    report = failure.report
    x, y, z = (1e3 * coordinate for coordinate in failure.position)
    return (
        f"no equilibrium beyond {session.whereabouts()}: after {report.iterations} iterations at the shortest step "
        f"{report.residual:.1e} of the mean fixture force is left at node {report.node} "
        f"(x {x:.2f}, y {y:.2f}, z {z:.2f} mm), {place_of(session.rig, report.node)} of the yarn"
    )

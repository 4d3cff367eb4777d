"""Run a test: set-point, pose, equilibrium, what the carriages feel, one row of the record.

`perform` yields what happens as it happens and knows no files; whoever iterates writes it down.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from knitlab_core.equilibrium.march import Failure
from knitlab_core.errors import ConvergenceError
from rigs.bench import Bench
from rigs.checkpoint import Checkpoint
from rigs.controller import controller_of
from rigs.cursor import Cursor
from rigs.drive import drive, hold, hold_marks, image_shares, inner_marks
from rigs.endings import Ending, watch_of
from rigs.instruments import Zeroing
from rigs.leaves import leaves
from rigs.motion import Planner, Stroke
from rigs.record import Equilibrium, Frame, Outcome
from rigs.rig import place_of
from rigs.steer import steer
from rigs.step_record import StepRecord
from rigs.steps import Image, UntilRupture

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from rigs.endings import Watch
    from rigs.leaves import Leaf
    from rigs.protocol import Protocol
    from rigs.rig import Rig

Event: TypeAlias = Equilibrium | Checkpoint | Frame | Zeroing | StepRecord | Outcome


def perform(
    rig: Rig, state: State, protocol: Protocol, *, options: Options | None = None, cursor: Cursor | None = None
) -> Iterator[Event]:
    """Carry out a protocol on a mounted specimen.

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
    cursor : Cursor, optional
        Where the test stands that is to go on, with the rig and the state there; by default it begins.

    Yields
    ------
    Equilibrium, Checkpoint, Frame, Zeroing, StepRecord or Outcome
        Rows and shapes in the order of time, and each zeroing when it happens; the one outcome comes last. A step is
        recorded when it begins, as if it were aborted, and when it ends. A limit that trips and an equilibrium that is
        not found are outcomes: what was yielded before stands. A checkpoint follows every row from which the test can
        go on.
    """
    planner = Planner(protocol=protocol, gauges=rig.gauges)
    controller = controller_of(rig, seed=protocol.log.seed, noise=protocol.log.noise)
    bench = Bench(
        rig=rig,
        state=state,
        controller=controller,
        increment=protocol.max_strain_increment,
        options=options,
        go_on=protocol.specimen.rupture == "go on",
        cursor=Cursor(memory=controller.begin(planner.begin())) if cursor is None else cursor,
    )
    try:
        outcome = yield from _with_checkpoints(bench, _carry_out(bench, planner))
    except ConvergenceError as error:
        outcome = Outcome(end="diverged", message=_account(bench, error))
    if outcome.end != "target":
        yield bench.frame()
    yield replace(outcome, unfinished=bench.uncounted())


def _with_checkpoints(bench: Bench, events: Generator[Event, None, Outcome]) -> Generator[Event, None, Outcome]:
    """Add a checkpoint after every row from which the test can go on."""
    while True:
        try:
            event = next(events)
        except StopIteration as end:
            outcome: Outcome = end.value
            return outcome
        yield event
        if isinstance(event, Equilibrium):
            checkpoint = bench.checkpoint()
            if checkpoint is not None:
                yield checkpoint


def _carry_out(bench: Bench, planner: Planner) -> Generator[Event, None, Outcome]:
    """Do every step of a protocol that is left; return how the test ended."""
    if bench.last is None:
        still = Stroke(start=bench.crosshead, end=bench.crosshead, duration=0.0, phase="Zero", cycle=1, force={})
        yield bench.accept(bench.reach(bench.displacement), still, bench.crosshead)
        yield bench.frame()
    done = Outcome(end="target")
    for leaf in leaves(planner.protocol.steps):
        if leaf.number < bench.cursor.leaf:
            continue
        ending = yield from _do_step(bench, planner, leaf)
        if ending is not None and ending.test:
            return Outcome(end=ending.end, message=ending.message)
        if ending is not None and ending.end in {"rupture", "slipped"} and isinstance(leaf.step, UntilRupture):
            done = Outcome(end=ending.end, message=ending.message)
    return done


def _do_step(bench: Bench, planner: Planner, leaf: Leaf) -> Generator[Event, None, Ending | None]:
    """Do one step, or what is left of it; return how it ended if not at its target."""
    begins = leaf.number > bench.cursor.leaf or bench.cursor.sight is None
    if begins:
        bench.remember(bench.controller.start_step(bench.memory, bench.time))
        bench.cursor = replace(bench.cursor, leaf=leaf.number, stroke=0, sight=None)
    record = StepRecord(
        number=leaf.number, place=leaf.place, tag=leaf.tag, start=bench.memory.since, time=bench.time, end="abort"
    )
    if begins:
        yield record
    if isinstance(leaf.step, Image):
        yield from _picture(bench, leaf.step)
    try:
        ending = yield from _do_strokes(bench, planner, leaf)
    except ConvergenceError as error:
        yield replace(record, time=bench.time, end="diverged", message=_account(bench, error))
        raise
    if ending is None and isinstance(leaf.step, UntilRupture):
        ending = Ending(end="limit", message="no rupture on the way")
    done = Ending(end="target", message="") if ending is None else ending
    yield replace(record, time=bench.time, end=done.end, message=done.message)
    return ending


def _do_strokes(bench: Bench, planner: Planner, leaf: Leaf) -> Generator[Event, None, Ending | None]:
    """Do the strokes of a step that are left; return what ended it, if anything did."""
    for index in range(bench.cursor.stroke, leaf.strokes):
        if index > bench.cursor.stroke:
            bench.cursor = replace(bench.cursor, stroke=index, sight=None)
        under_way = bench.cursor.sight
        sight = under_way or bench.sight()
        stroke = planner.stroke(leaf, index, bench.memory.course, sight)
        if stroke is None:
            continue
        watch = watch_of(leaf, stroke, bench.rig.gauges)
        ending = None
        if under_way is None:
            if index == 0 and (met := watch.met_before(bench.memory, bench.crosshead)) is not None:
                return met
            bench.begin(sight)
        else:
            ending = watch.met(bench.controller, bench.memory, bench.crosshead)
        if ending is None:
            ending = yield from _do(bench, stroke, watch)
        else:
            # The row that the test goes on from was the step's last.
            yield bench.frame()
        after = bench.memory.course.after(stroke, bench.sight())
        bench.remember(replace(bench.memory, course=after))
        if ending is not None:
            return ending
    return None


def _picture(bench: Bench, step: Image) -> Iterator[Event]:
    """Take a picture, or begin or end a series of them."""
    if step.every is not None:
        every = None if step.every == "off" else step.every
        bench.remember(replace(bench.memory, every=every, image_since=bench.time, image_tag=step.tag))
    if step.every != "off":
        yield bench.pictured(step.tag)


def _do(bench: Bench, stroke: Stroke, watch: Watch) -> Generator[Event, None, Ending | None]:
    """Do one stroke; return what ended its step, if anything did."""
    if stroke.phase == "Zero":
        # A specimen that stands still keeps its equilibrium: nothing to solve, nothing to drift.
        if bench.last is not None and bench.last.phase != "Zero":
            yield bench.stand(stroke)
        if "force" in stroke.channels:
            bench.remember(bench.controller.zero(bench.memory))
        yield Zeroing(time=bench.time, kinds=frozenset(stroke.channels))
        return None
    tripped = _too_fast(bench, stroke)
    if tripped is not None:
        return tripped
    elastic = bench.rig.work.model.relaxation is None
    straight = all(train.rigid for train in bench.rig.trains.values()) and not (stroke.force or stroke.free)
    if stroke.phase == "Hold" and (elastic or straight):
        return (yield from hold(bench, stroke, watch))
    seeks = stroke.stop_force is not None or (watch.until is not None and watch.until.force is not None)
    if straight and not seeks:
        return (yield from drive(bench, stroke, watch))
    marks = hold_marks(bench, stroke) if stroke.phase == "Hold" else inner_marks(stroke, bench.rig.gauges)
    ending = yield from steer(bench, stroke, watch, marks, image_shares(stroke, bench.memory, bench.cursor.begun))
    if ending is None or not ending.test:
        yield bench.frame()
    return ending


def _too_fast(bench: Bench, stroke: Stroke) -> Ending | None:
    """Return the ending of a test whose machine has no such speed."""
    for axis, train in bench.rig.trains.items():
        way = abs(stroke.end[axis] - stroke.start[axis])
        speed = way / stroke.duration if stroke.duration > 0.0 else 0.0
        if speed > train.fastest * (1.0 + 1e-9):
            has = f"speed: axis {axis} would move at {1e3 * speed:.4g} mm/s, limit {1e3 * train.fastest:.4g} mm/s"
            return Ending(end="limit", message=has, test=True)
    return None


def _account(bench: Bench, error: ConvergenceError) -> str:
    """Say where the axes stood and where on the yarn, in the words of a knitter, no equilibrium was found."""
    failure = error.report
    if not isinstance(failure, Failure):
        return str(error)
    report = failure.report
    x, y, z = (1e3 * coordinate for coordinate in failure.position)
    return (
        f"no equilibrium beyond {bench.whereabouts()}: after {report.iterations} iterations at the shortest step "
        f"{report.residual:.1e} of the mean fixture force is left at node {report.node} "
        f"(x {x:.2f}, y {y:.2f}, z {z:.2f} mm), {place_of(bench.rig, report.node)} of the yarn"
    )

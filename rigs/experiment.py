"""Run a test: set-point, pose, equilibrium, what the carriages feel, one row of the record.

`perform` yields what happens as it happens and knows no files; whoever iterates writes it down.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil, floor
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from knitlab_core.equilibrium.march import Failure
from knitlab_core.errors import ConvergenceError
from knitlab_core.rods.relaxation import hold_steps
from rigs.bench import Bench
from rigs.checkpoint import Checkpoint
from rigs.cursor import END, Cursor
from rigs.instruments import Zeroing
from rigs.motion import strokes
from rigs.preload import preload
from rigs.record import Equilibrium, Frame, Outcome
from rigs.rig import place_of
from rigs.way import between

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from rigs.cursor import Displacement
    from rigs.motion import Stroke
    from rigs.protocol import Protocol
    from rigs.rig import Rig
    from rigs.steps import Axis

Plan: TypeAlias = "Generator[Stroke, Displacement | None, None]"
Event: TypeAlias = Equilibrium | Checkpoint | Frame | Zeroing | Outcome

FRAME_MARK: Final = 0.2
"""A frame is kept wherever an axis passes a whole multiple of this strain, and where a stroke ends."""


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
    Equilibrium, Checkpoint, Frame, Zeroing or Outcome
        Rows and shapes in the order of time, and each zeroing when it happens; the one outcome comes last. A limit
        that trips and an equilibrium that is not found are outcomes: what was yielded before stands. A checkpoint
        follows every row from which the test can go on.
    """
    bench = Bench(
        rig=rig,
        state=state,
        options=options,
        go_on=protocol.specimen.rupture == "go on",
        cursor=Cursor() if cursor is None else cursor,
    )
    try:
        outcome = yield from _with_checkpoints(bench, _carry_out(bench, protocol))
    except ConvergenceError as error:
        outcome = Outcome(end="diverged", message=_account(bench, error))
    if outcome.end != "target":
        yield bench.frame()
    yield outcome


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


def _carry_out(bench: Bench, protocol: Protocol) -> Generator[Event, None, Outcome]:
    """Do every stroke of a protocol that is left; return how it ended."""
    plan = strokes(protocol, bench.rig.gauges)
    stroke = _under_way(plan, bench.cursor)
    if bench.cursor.stroke == 0:
        (mounted,) = bench.march_to(bench.displacement, longest=1.0)
        yield bench.accept(mounted, "Zero", 1, None)
        yield bench.frame()
        bench.begin()
    while stroke is not None:
        ended = yield from _do(bench, stroke, protocol.max_strain_increment)
        if ended is not None:
            return ended
        bench.finish(stroke)
        stroke = _next(plan, bench.displacement)
        bench.begin()
    return Outcome(end="target")


def _under_way(plan: Plan, cursor: Cursor) -> Stroke | None:
    """Return the stroke of a plan that is under way, or the first; None if there is none."""
    stroke = next(plan, None)
    for number in range(1, cursor.stroke):
        if stroke is not None:
            stroke = _next(plan, cursor.reached.get(number, stroke.end))
    return stroke


def _next(plan: Plan, reached: Displacement) -> Stroke | None:
    """Return the next stroke, after one that ended at `reached`; None if that was the last."""
    try:
        return plan.send(reached)
    except StopIteration:
        return None


def _do(bench: Bench, stroke: Stroke, increment: float) -> Generator[Event, None, Outcome | None]:
    """Do one stroke; return an outcome if it ended the test."""
    ended = None
    match stroke.phase:
        case "Zero":
            # A specimen that stands still keeps its equilibrium: nothing to solve, nothing to drift.
            if bench.last is not None and bench.last.phase != "Zero":
                yield bench.stand(stroke)
            yield Zeroing(time=bench.time, kinds=frozenset(stroke.channels))
        case "Hold":
            ended = yield from _hold(bench, stroke)
        case "Preload":
            ended = yield from preload(bench, stroke, stroke.stop_force or 0.0, increment)
            if ended is None:
                yield bench.frame()
        case _:
            ended = yield from _drive(bench, stroke, increment)
    return ended


def _drive(bench: Bench, stroke: Stroke, increment: float) -> Generator[Event, None, Outcome | None]:
    """Move the axes straight to where a stroke ends, by way of the marks at which a frame is kept."""
    for low, high in bench.legs(pairwise([0.0, *_marks(stroke, bench.rig.gauges), 1.0])):
        goal = between(stroke.start, stroke.end, high)
        way = bench.strain(bench.cursor.origin, goal)
        duration = (high - low) * stroke.duration
        for step in bench.go_on_to(goal, longest=min(1.0, increment / way), duration=duration):
            bench.time = bench.cursor.begun + (low + (high - low) * step.share) * stroke.duration
            yield bench.accept(step, stroke.phase, stroke.cycle, stroke.tag)
            ended = bench.outcome()
            if ended is not None:
                return ended
        yield bench.frame()
    return None


def _hold(bench: Bench, stroke: Stroke) -> Generator[Event, None, Outcome | None]:
    """Stand still; a yarn that relaxes goes through equilibria meanwhile."""
    begun, relaxation = bench.cursor.begun, bench.rig.work.model.relaxation
    if relaxation is None:
        # A specimen that stands still keeps its equilibrium, as at a zero.
        if bench.cursor.place != END:
            bench.time = begun + stroke.duration
            yield bench.stand(stroke)
        return None
    ends = np.cumsum(hold_steps(relaxation, stroke.duration))
    for start, end in bench.legs(pairwise([0.0, *ends[:-1], stroke.duration])):
        for step in bench.go_on_to(bench.displacement, longest=1.0, duration=end - start):
            bench.time = begun + start + step.share * (end - start)
            yield bench.accept(step, stroke.phase, stroke.cycle, stroke.tag)
            ended = bench.outcome()
            if ended is not None:
                return ended
    yield bench.frame()
    return None


def _marks(stroke: Stroke, gauges: Mapping[Axis, float]) -> list[float]:
    """Return the shares of a stroke, between its ends, at which an axis passes a marked strain."""
    shares: list[float] = []
    for axis, length in gauges.items():
        first, last = (way[axis] / (FRAME_MARK * length) for way in (stroke.start, stroke.end))
        if first == last:
            continue
        passed = range(ceil(min(first, last)), floor(max(first, last)) + 1)
        shares += [(mark - first) / (last - first) for mark in passed]
    inner = sorted(share for share in shares if 1e-6 < share < 1.0 - 1e-6)
    # Axes that pass a mark together differ by rounding.
    return [share for before, share in pairwise([0.0, *inner]) if share - before > 1e-6]


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

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
    from rigs.motion import Stroke
    from rigs.protocol import Protocol
    from rigs.rig import Rig
    from rigs.steps import Axis

Event: TypeAlias = Equilibrium | Frame | Zeroing | Outcome

FRAME_MARK: Final = 0.2
"""A frame is kept wherever an axis passes a whole multiple of this strain, and where a stroke ends."""

FRAME_SPACING: Final = 0.025
"""Between these marks, frames are as many equilibria that are there anyway as keep them about this strain apart."""

MOST_FRAMES: Final = 60
"""Largest number of such frames on a stroke."""


def perform(rig: Rig, state: State, protocol: Protocol, *, options: Options | None = None) -> Iterator[Event]:
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

    Yields
    ------
    Equilibrium, Frame, Zeroing or Outcome
        Rows and shapes in the order of time, and each zeroing when it happens; the one outcome comes last. A limit
        that trips and an equilibrium that is not found are outcomes: what was yielded before stands.
    """
    bench = Bench(rig=rig, state=state, options=options, go_on=protocol.specimen.rupture == "go on")
    try:
        outcome = yield from _carry_out(bench, protocol)
    except ConvergenceError as error:
        outcome = Outcome(end="diverged", message=_account(bench, error))
    if outcome.end != "target":
        yield bench.frame()
    yield outcome


def _carry_out(bench: Bench, protocol: Protocol) -> Generator[Event, None, Outcome]:
    """Do every stroke of a protocol; return how it ended."""
    (mounted,) = bench.march_to(bench.displacement, longest=1.0)
    yield bench.accept(mounted, "Zero", 1, None)
    yield bench.frame()
    plan = strokes(protocol, bench.rig.gauges)
    stroke = next(plan, None)
    while stroke is not None:
        ended = yield from _do(bench, stroke, protocol.max_strain_increment)
        if ended is not None:
            return ended
        try:
            stroke = plan.send(bench.displacement)
        except StopIteration:
            stroke = None
    return Outcome(end="target")


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
    begun = bench.time
    for low, high in pairwise([0.0, *_marks(stroke, bench.rig.gauges), 1.0]):
        goal = between(stroke.start, stroke.end, high)
        way = bench.strain(bench.displacement, goal)
        duration = (high - low) * stroke.duration
        for step in bench.march_to(goal, longest=min(1.0, increment / way), duration=duration):
            before = bench.displacement
            bench.time = begun + (low + (high - low) * step.share) * stroke.duration
            row = bench.accept(step, stroke.phase, stroke.cycle, stroke.tag)
            ended = bench.outcome()
            # Before its row: a test that is taken up again after the row has the frame.
            if ended is None and step.share < 1.0 and _passes_frame(stroke, bench, before):
                yield bench.frame()
            yield row
            if ended is not None:
                return ended
        yield bench.frame()
    return None


def _hold(bench: Bench, stroke: Stroke) -> Generator[Event, None, Outcome | None]:
    """Stand still; a yarn that relaxes goes through equilibria meanwhile."""
    begun, relaxation = bench.time, bench.rig.work.model.relaxation
    if relaxation is None:
        # A specimen that stands still keeps its equilibrium, as at a zero.
        bench.time = begun + stroke.duration
        yield bench.stand(stroke)
        return None
    ends = np.cumsum(hold_steps(relaxation, stroke.duration))
    for start, end in pairwise([0.0, *ends[:-1], stroke.duration]):
        for step in bench.march_to(bench.displacement, longest=1.0, duration=end - start):
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


def _passes_frame(stroke: Stroke, bench: Bench, before: Mapping[Axis, float]) -> bool:
    """Tell whether the axis that strains most came by one of the places, evenly spaced on a stroke, of a frame."""
    strains = {axis: (stroke.end[axis] - stroke.start[axis]) / length for axis, length in bench.rig.gauges.items()}
    axis = max(strains, key=lambda one: abs(strains[one]))
    count = min(MOST_FRAMES, ceil(abs(strains[axis]) / FRAME_SPACING))
    way = stroke.end[axis] - stroke.start[axis]
    was, now = (floor(count * (at[axis] - stroke.start[axis]) / way) for at in (before, bench.displacement))
    return was < now


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

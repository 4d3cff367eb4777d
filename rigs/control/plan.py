"""Plan of a protocol before any physics: its strokes, time and rows of the log, as far as they are known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from rigs.control.log_rate import planned_samples
from rigs.control.planner import Planner
from rigs.protocol.strokes import Readings
from rigs.protocol.unrolled import unrolled

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.strokes import History, Stroke
    from rigs.protocol.unrolled import UnrolledStep

MAX_ROWS: Final = 10_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """Step with its planned strokes.

    Attributes
    ----------
    leaf : UnrolledStep
        The step.
    strokes : sequence of Stroke
        Its strokes.
    duration : float
        How long it takes at most [s].
    """

    leaf: UnrolledStep
    strokes: Sequence[Stroke]
    duration: float


def planned_steps(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> list[Planned]:
    """Return every step as far as it is known beforehand.

    A preload is taken to meet its force at once, though its duration counts with all of its reach; axes that give way
    are taken to stay, and a load cell to show what was last asked of it.

    Raises
    ------
    SpecificationError
        If hooks would pass through each other.
    """
    planner = Planner(protocol=protocol, gauges=gauge_lengths)
    history = planner.begin()
    readings = Readings(displacement=dict(history.origin), force=dict.fromkeys(gauge_lengths, 0.0))
    planned = []
    for leaf in unrolled(protocol.steps):
        step, history, readings = planned_step(planner, leaf, history, readings)
        planned.append(step)
    return planned


def planned_step(
    planner: Planner, leaf: UnrolledStep, history: History, readings: Readings
) -> tuple[Planned, History, Readings]:
    """Return a step as far as it is known beforehand, with what it leaves to the next; see `planned_steps`."""
    made, duration = [], 0.0
    for index in range(leaf.step.stroke_count):
        stroke = planner.stroke(leaf, index, history, readings)
        if stroke is None:
            continue
        made.append(stroke)
        duration += stroke.duration
        met = dict.fromkeys(stroke.named, stroke.stop_force) if stroke.stop_force is not None else {}
        shown = {axis: last for axis, (_, last) in stroke.force.items()}
        readings = Readings(
            displacement=stroke.start if stroke.stop_force is not None else stroke.end,
            force={
                **readings.force,
                **shown,
                **met,
                **(dict.fromkeys(readings.force, 0.0) if _tares(stroke) else {}),
            },
        )
        history = history.after(stroke, readings)
    until = leaf.step.until
    if until is not None and until.time is not None:
        duration = min(duration, until.time)
    return Planned(leaf=leaf, strokes=made, duration=duration), history, readings


def planned_duration(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> float:
    """Return how long the steps take [s]; a preload counts with all of its reach."""
    return math.fsum(step.duration for step in planned_steps(protocol, gauge_lengths))


def planned_rows(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> int:
    """Return how many rows the log will have: one at the start, then one each tick of its clock; events not counted.

    Raises
    ------
    SpecificationError
        If they are more than `MAX_ROWS`.
    """
    steps = planned_steps(protocol, gauge_lengths)
    ticks = planned_samples(protocol, [(step.leaf, step.strokes, step.duration) for step in steps])
    # Rounding in the sum of durations must not lose the row of the last tick.
    rows = math.floor(ticks * (1 + 1e-12)) + 1
    if rows > MAX_ROWS:
        rate = f"{protocol.log.rate:g} Hz, which makes {rows} rows with what the steps say"
        raise SpecificationError("log.rate", rate, f"a rate that makes {MAX_ROWS} rows or fewer")
    return rows


def planned_images(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> int:
    """Return how many pictures are asked for."""
    every, since, count = None, 0.0, 0
    for step in planned_steps(protocol, gauge_lengths):
        pictures = step.leaf.step.pictures
        if pictures is not None:
            every, since = (pictures if isinstance(pictures, float) else None), 0.0
            count += pictures != "off"
        elif every is not None:
            since += step.duration
            count, since = count + int(since / every), since % every
    return count


def _tares(stroke: Stroke) -> bool:
    return "force" in stroke.channels

"""Turn the steps of a protocol into strokes: what each driven axis does, and for how long.

A displacement is the change of the hook-to-hook length of an axis since the specimen was mounted [m].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from knitlab_core.errors import SpecificationError
from rigs.catalogue import CATALOGUE
from rigs.protocol import Axis, Channel, Cycle, Hold, Preload, Protocol, Ramp, Repeat, Step, Target, Zero

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Iterator, Mapping

    from rigs.record import Phase

Move: TypeAlias = Zero | Preload | Ramp | Hold

# A preload that has not met its force after this strain has met its limit.
PRELOAD_REACH = 0.5
MAX_ROWS = 10_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """Describe one straight move of the axes.

    Parameters
    ----------
    start, end : Mapping
        Displacement of each axis [m].
    duration : float
        Time it takes [s].
    phase : {'Zero', 'Preload', 'Stretch', 'Recover', 'Hold'}
        What it is to the specimen.
    cycle : int
        Number of the set it belongs to, from 1; a stretch after a recovery opens the next [1].
    tag : str or None
        The step's tag.
    stop_force : float or None
        An axis that moves stops where it carries this force [N].
    channels : tuple of str
        Channels to tare (phase 'Zero').
    """

    start: Mapping[Axis, float]
    end: Mapping[Axis, float]
    duration: float
    phase: Phase
    cycle: int
    tag: str | None = None
    stop_force: float | None = None
    channels: tuple[Channel, ...] = ()


def strokes(
    protocol: Protocol, gauge_lengths: Mapping[Axis, float]
) -> Generator[Stroke, Mapping[Axis, float] | None, None]:
    """Yield the strokes of a protocol in order.

    Axes driven together arrive together; the rate is that of the axis with the longest way. A ramp to where
    the axes already stand makes no stroke.

    Parameters
    ----------
    protocol : Protocol
        The test.
    gauge_lengths : Mapping
        Initial hook-to-hook distance of each axis [m]; strain = displacement / gauge length.

    Yields
    ------
    Stroke
        The next move. Send the displacements [m] really reached, or nothing when its end was.
    """
    here: dict[Axis, float] = dict.fromkeys(protocol.axes, 0.0)
    origin = dict(here)
    cycle, recovered = 1, False
    for move in moves(protocol.steps):
        end = _destination(move, here, origin, gauge_lengths)
        if isinstance(move, Ramp) and _still(here, end, gauge_lengths):
            continue
        phase = _phase(move, here, end)
        if recovered and phase in {"Stretch", "Preload"}:
            cycle, recovered = cycle + 1, False
        recovered = recovered or phase == "Recover"
        reached = yield Stroke(
            start=dict(here),
            end=end,
            duration=_duration(move, here, end, protocol),
            phase=phase,
            cycle=cycle,
            tag=None if isinstance(move, Zero) else move.tag,
            stop_force=move.force if isinstance(move, Preload) else None,
            channels=move.channels if isinstance(move, Zero) else (),
        )
        here = dict(end if reached is None else reached)
        if isinstance(move, Zero) and "displacement" in move.channels:
            origin = dict(here)


def moves(steps: Iterable[Step]) -> Iterator[Move]:
    """Yield the steps with repeats and cycles counted out: a cycle is a ramp up and a ramp down."""
    for step in steps:
        match step:
            case Repeat():
                for _ in range(step.n):
                    yield from moves(step.steps)
            case Cycle():
                for _ in range(step.n):
                    for strain in (step.upper, step.lower):
                        target = Target(kind="strain", value=strain)
                        yield Ramp(axes=step.axes, to=target, rate=step.rate, tag=step.tag)
            case _:
                yield step


def planned_strokes(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> list[Stroke]:
    """Return the strokes as far as they are known beforehand: a preload is taken to meet its force at once.

    Its duration still counts with all of its reach.
    """
    planned: list[Stroke] = []
    plan = strokes(protocol, gauge_lengths)
    stroke = next(plan, None)
    while stroke is not None:
        planned.append(stroke)
        try:
            stroke = plan.send(stroke.start if stroke.phase == "Preload" else stroke.end)
        except StopIteration:
            stroke = None
    return planned


def planned_duration(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> float:
    """Return how long the strokes take [s]; a preload counts with all of its reach."""
    return math.fsum(stroke.duration for stroke in planned_strokes(protocol, gauge_lengths))


def planned_rows(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> int:
    """Return how many rows the log will have: one at the start, then one each tick of its clock.

    Raises
    ------
    SpecificationError
        If they are more than `MAX_ROWS`.
    """
    ticks = planned_duration(protocol, gauge_lengths) * protocol.log.rate
    # Rounding in the sum of durations must not lose the row of the last tick.
    rows = math.floor(ticks * (1 + 1e-12)) + 1
    if rows > MAX_ROWS:
        rate = f"{protocol.log.rate:g} Hz, which makes {rows} rows"
        raise SpecificationError("log.rate", rate, f"a rate that makes {MAX_ROWS} rows or fewer")
    return rows


def _destination(
    move: Move, here: Mapping[Axis, float], origin: Mapping[Axis, float], gauge_lengths: Mapping[Axis, float]
) -> dict[Axis, float]:
    """Return the displacement of every axis at the end of a move; axes not driven stay [m]."""
    end = dict(here)
    match move:
        case Preload():
            for axis in move.axes:
                end[axis] = here[axis] + PRELOAD_REACH * gauge_lengths[axis]
        case Ramp():
            for axis in move.axes:
                scale = gauge_lengths[axis] if move.to.kind == "strain" else 1.0
                end[axis] = origin[axis] + move.to.value * scale
                if end[axis] <= -gauge_lengths[axis]:
                    found = f"{end[axis]:g} m on axis {axis}"
                    raise SpecificationError("steps", found, f"a displacement above {-gauge_lengths[axis]:g} m")
        case _:
            pass
    return end


def _still(here: Mapping[Axis, float], end: Mapping[Axis, float], gauge_lengths: Mapping[Axis, float]) -> bool:
    """Tell whether no axis has a way to go, rounding apart."""
    return all(abs(end[axis] - here[axis]) <= 1e-12 * gauge_lengths[axis] for axis in end)


def _farthest(here: Mapping[Axis, float], end: Mapping[Axis, float]) -> Axis:
    """Return the axis that goes farthest."""
    return max(end, key=lambda axis: abs(end[axis] - here[axis]))


def _longest_way(here: Mapping[Axis, float], end: Mapping[Axis, float]) -> float:
    """Return the signed way of the axis that goes farthest [m]."""
    axis = _farthest(here, end)
    return end[axis] - here[axis]


def _phase(move: Move, here: Mapping[Axis, float], end: Mapping[Axis, float]) -> Phase:
    """Return what a move is to the specimen."""
    match move:
        case Zero():
            return "Zero"
        case Preload():
            return "Preload"
        case Hold():
            return "Hold"
        case Ramp():
            return "Stretch" if _longest_way(here, end) > 0.0 else "Recover"


def _duration(move: Move, here: Mapping[Axis, float], end: Mapping[Axis, float], protocol: Protocol) -> float:
    """Return the time a move takes [s]."""
    match move:
        case Zero():
            return 0.0
        case Hold():
            return move.duration
        case Preload() | Ramp():
            # Where two grips move apart, a pair's length changes twice as fast as one of them moves.
            drive = CATALOGUE[protocol.rig].drives[_farthest(here, end)]
            pair_rate = move.rate * (1 if protocol.speed_ref == "pair" else drive.moving)
            return abs(_longest_way(here, end)) / pair_rate

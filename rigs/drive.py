"""Move rigid axes straight, or stand still: the strokes whose equilibria need no search for the axes' places."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, floor
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.rods.relaxation import hold_steps
from rigs.cursor import END
from rigs.way import between

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Mapping

    from rigs.bench import Bench
    from rigs.controller import Memory
    from rigs.endings import Ending, Watch
    from rigs.motion import Stroke
    from rigs.record import Equilibrium, Frame
    from rigs.targets import Axis
    from rigs.way import Step

FRAME_MARK: Final = 0.2
"""A frame is kept wherever an axis passes a whole multiple of this strain, and where a stroke ends."""

NEAR: Final = 1e-6
"""Marks of a stroke that are as near to each other as this share of it are one ..."""

BESIDE: Final = 1e-3
"""... and as this one where the places of the axes are searched for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """Hold a part of a stroke from mark to mark, as shares of it, and whether a picture is taken at its end."""

    low: float
    high: float
    pictured: bool


def drive(bench: Bench, stroke: Stroke, watch: Watch) -> Generator[Equilibrium | Frame, None, Ending | None]:
    """Move the axes straight to where a stroke ends, by way of the marks at which a frame is kept."""
    begun = bench.cursor.begun
    last, ending = watch.cut(bench.memory, begun)
    marks = strain_marks(stroke, bench.rig.gauges)
    for leg in bench.legs(legs_of(marks, image_shares(stroke, bench.memory, begun), last)):
        goal = between(stroke.start, stroke.end, leg.high)
        way = bench.strain(bench.cursor.origin, goal)
        duration = (leg.high - leg.low) * stroke.duration
        for step in bench.go_on_to(goal, longest=min(1.0, bench.increment / max(way, 1e-15)), duration=duration):
            bench.time = begun + (leg.low + (leg.high - leg.low) * step.share) * stroke.duration
            before = bench.displacement
            row = bench.accept(step, stroke, step.displacement)
            # Before its row: a test that is taken up again after the row has the frame.
            if step.share < 1.0 and bench.passes_frame(before):
                yield bench.frame()
            yield row
            over = bench.over() or watch.met(bench.controller, bench.memory, bench.crosshead)
            if over is not None:
                if not over.test:
                    yield bench.frame()
                return over
        if leg.pictured:
            yield bench.pictured(bench.memory.image_tag)
        else:
            yield bench.frame()
    return ending


def hold(bench: Bench, stroke: Stroke, watch: Watch) -> Generator[Equilibrium | Frame, None, Ending | None]:
    """Stand still; a yarn that relaxes goes through equilibria meanwhile."""
    begun, relaxation = bench.cursor.begun, bench.rig.work.model.relaxation
    last, ending = watch.cut(bench.memory, begun)
    marks = hold_marks(bench, stroke)
    for leg in bench.legs(legs_of(marks, image_shares(stroke, bench.memory, begun), last)):
        duration = (leg.high - leg.low) * stroke.duration
        rows: Iterable[Step | None] = bench.go_on_to(bench.displacement, longest=1.0, duration=duration)
        if relaxation is None:
            # A specimen that stands still keeps its equilibrium, as at a zero.
            rows = [] if bench.cursor.place == END else [None]
        for step in rows:
            share = 1.0 if step is None else step.share
            bench.time = begun + leg.low * stroke.duration + share * duration
            yield bench.stand(stroke) if step is None else bench.accept(step, stroke, bench.crosshead)
            over = bench.over() or watch.met(bench.controller, bench.memory, bench.crosshead)
            if over is not None:
                return over
        if leg.pictured:
            yield bench.pictured(bench.memory.image_tag)
    if relaxation is not None:
        yield bench.frame()
    return ending


def legs_of(marks: list[float], images: list[float], last: float) -> list[Leg]:
    """Return the parts of a stroke up to a share of it, each up to the next mark."""
    ends = sorted({*(one for one in [*marks, *images] if NEAR < one < last - NEAR), last} if last > 0.0 else set())
    # Axes that pass a mark together differ by rounding.
    ends = [end for before, end in pairwise([0.0, *ends]) if end - before > NEAR or end == last]
    pictures = [any(abs(image - end) <= NEAR for image in images) for end in ends]
    return [
        Leg(low=low, high=high, pictured=pictured)
        for (low, high), pictured in zip(pairwise([0.0, *ends]), pictures, strict=True)
    ]


def image_shares(stroke: Stroke, memory: Memory, begun: float) -> list[float]:
    """Return the shares of a stroke at which pictures fall due: after its beginning, its end counted."""
    every, since = memory.every, memory.image_since
    if every is None or stroke.duration <= 0.0:
        return []
    slack = 1e-9 * max(1.0, begun + stroke.duration)
    first, last = ((time + slack - since) / every for time in (begun, begun + stroke.duration))
    return [(since + k * every - begun) / stroke.duration for k in range(floor(first) + 1, floor(last) + 1)]


def strain_marks(stroke: Stroke, gauges: Mapping[Axis, float]) -> list[float]:
    """Return the shares of a stroke at which an axis passes a marked strain."""
    shares: list[float] = []
    for axis, length in gauges.items():
        first, last = (way[axis] / (FRAME_MARK * length) for way in (stroke.start, stroke.end))
        if first != last:
            passed = range(ceil(min(first, last)), floor(max(first, last)) + 1)
            shares += [(mark - first) / (last - first) for mark in passed]
    return shares


def inner_marks(stroke: Stroke, gauges: Mapping[Axis, float]) -> list[float]:
    """Return these shares between a stroke's ends, rising; a search leaves an axis beside where it was sent."""
    inner = sorted(share for share in strain_marks(stroke, gauges) if BESIDE < share < 1.0 - BESIDE)
    return [share for before, share in pairwise([0.0, *inner]) if share - before > BESIDE]


def hold_marks(bench: Bench, stroke: Stroke) -> list[float]:
    """Return the shares of a hold between the equilibria of a yarn that relaxes."""
    relaxation = bench.rig.work.model.relaxation
    if relaxation is None:
        return []
    ends = np.cumsum(hold_steps(relaxation, stroke.duration))
    return [float(end) / stroke.duration for end in ends[:-1]]

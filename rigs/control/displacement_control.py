"""Displacement control: strokes of rigid axes, which need no search for the displacements of the axes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, floor
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.rods.relaxation import hold_steps
from rigs.control.path import between
from rigs.control.resume_point import END

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable, Mapping

    from rigs.axes import Axis
    from rigs.control.controller import Memory
    from rigs.control.path import PathPoint
    from rigs.control.session import Session
    from rigs.control.stop_criteria import StopCriteria, StopReason
    from rigs.protocol.strokes import Stroke
    from rigs.record import Equilibrium, Frame

FRAME_MARK: Final = 0.2
"""A frame is kept wherever an axis passes a whole multiple of this strain, and where a stroke ends."""

NEAR: Final = 1e-6
"""Marks of a stroke that are as near to each other as this share of it are one ..."""

BESIDE: Final = 1e-3
"""... and as this one where the displacements of the axes are searched for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """Part of a stroke from mark to mark, as shares of it, and whether a picture is taken at its end."""

    low: float
    high: float
    pictured: bool


def control_displacement(
    session: Session, stroke: Stroke, criteria: StopCriteria
) -> Generator[Equilibrium | Frame, None, StopReason | None]:
    """Move the axes straight to the end of a stroke, with rows at the marks at which a frame is kept."""
    begun = session.cursor.begun
    last, ending = criteria.cut(session.memory, begun)
    marks = strain_marks(stroke, session.rig.gauges)
    for segment in session.segments(segments_of(marks, image_shares(stroke, session.memory, begun), last)):
        goal = between(stroke.start, stroke.end, segment.high)
        strain = session.strain(session.cursor.origin, goal)
        duration = (segment.high - segment.low) * stroke.duration
        for step in session.go_on_to(goal, longest=min(1.0, session.increment / max(strain, 1e-15)), duration=duration):
            session.time = begun + (segment.low + (segment.high - segment.low) * step.share) * stroke.duration
            before = session.displacement
            row = session.accept(step, stroke, step.displacement)
            # Before its row: a test that is resumed after the row has the frame.
            if step.share < 1.0 and session.passes_frame(before):
                yield session.frame()
            yield row
            over = session.over() or criteria.met(session.controller, session.memory, session.crosshead)
            if over is not None:
                if not over.test:
                    yield session.frame()
                return over
        if segment.pictured:
            yield session.pictured(session.memory.image_tag)
        else:
            yield session.frame()
    return ending


def hold(
    session: Session, stroke: Stroke, criteria: StopCriteria
) -> Generator[Equilibrium | Frame, None, StopReason | None]:
    """Hold the displacements; yield the equilibria of a yarn that relaxes meanwhile."""
    begun, relaxation = session.cursor.begun, session.rig.work.model.relaxation
    last, ending = criteria.cut(session.memory, begun)
    marks = hold_marks(session, stroke)
    for segment in session.segments(segments_of(marks, image_shares(stroke, session.memory, begun), last)):
        duration = (segment.high - segment.low) * stroke.duration
        rows: Iterable[PathPoint | None] = session.go_on_to(session.displacement, longest=1.0, duration=duration)
        if relaxation is None:
            # A specimen that does not move keeps its equilibrium, as at a zero.
            rows = [] if session.cursor.place == END else [None]
        for step in rows:
            share = 1.0 if step is None else step.share
            session.time = begun + segment.low * stroke.duration + share * duration
            yield session.stand(stroke) if step is None else session.accept(step, stroke, session.crosshead)
            over = session.over() or criteria.met(session.controller, session.memory, session.crosshead)
            if over is not None:
                return over
        if segment.pictured:
            yield session.pictured(session.memory.image_tag)
    if relaxation is not None:
        yield session.frame()
    return ending


def segments_of(marks: list[float], images: list[float], last: float) -> list[Segment]:
    """Return the parts of a stroke up to a share of it, each up to the next mark."""
    ends = sorted({*(one for one in [*marks, *images] if NEAR < one < last - NEAR), last} if last > 0.0 else set())
    # Axes that pass a mark together differ by rounding.
    ends = [end for before, end in pairwise([0.0, *ends]) if end - before > NEAR or end == last]
    pictures = [any(abs(image - end) <= NEAR for image in images) for end in ends]
    return [
        Segment(low=low, high=high, pictured=pictured)
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
        first, last = (ends[axis] / (FRAME_MARK * length) for ends in (stroke.start, stroke.end))
        if first != last:
            passed = range(ceil(min(first, last)), floor(max(first, last)) + 1)
            shares += [(mark - first) / (last - first) for mark in passed]
    return shares


def inner_marks(stroke: Stroke, gauges: Mapping[Axis, float]) -> list[float]:
    """Return these shares between a stroke's ends, rising; a search ends beside its setpoint."""
    inner = sorted(share for share in strain_marks(stroke, gauges) if BESIDE < share < 1.0 - BESIDE)
    return [share for before, share in pairwise([0.0, *inner]) if share - before > BESIDE]


def hold_marks(session: Session, stroke: Stroke) -> list[float]:
    """Return the shares of a hold between the equilibria of a yarn that relaxes."""
    relaxation = session.rig.work.model.relaxation
    if relaxation is None:
        return []
    ends = np.cumsum(hold_steps(relaxation, stroke.duration))
    return [float(end) / stroke.duration for end in ends[:-1]]

"""Stop criteria of a step: a time, a displacement, a force or a drop, whichever is met first, ends it early.

A criterion that is met when a step begins ends it at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigs.axes import Axis
    from rigs.control.controller import Controller, Memory
    from rigs.protocol.strokes import Stroke
    from rigs.protocol.targets import Control, Side, Until
    from rigs.protocol.unrolled import UnrolledStep
    from rigs.record import End

TOLERANCE: Final = 5e-3
"""An axis stops within this share of a force or a displacement that ends its step."""

ROUNDING: Final = 1e-9
"""What is this share short of a level is there when a step begins."""

SMALL: Final = 1e-2
"""Strain below which a place is not met more finely, for all its share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StopReason:
    """End of a step before its target.

    Attributes
    ----------
    end : End
        The kind of end.
    message : str
        One line for the user.
    test : bool
        Whether the test ends with it.
    """

    end: End
    message: str
    test: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Watched:
    """Level that ends a step, with the state of an axis beside it.

    Attributes
    ----------
    axis : Axis
        The axis.
    kind : Control
        What is watched.
    passed : float
        How far the level is passed, as a share of it [1].
    level, shows : str
        The level, and what the axis shows, in words.
    """

    axis: Axis
    kind: Control
    passed: float
    level: str
    shows: str


@dataclass(frozen=True, slots=True, kw_only=True)
class StopCriteria:
    """Conditions that end the step of a stroke.

    Attributes
    ----------
    until : Until or None
        The conditions of the protocol.
    stroke : Stroke
        The stroke.
    gauges : Mapping
        Gauge length of each axis [m].
    pulls : bool
        Whether the step goes outwards as a whole, whatever this stroke does.
    """

    until: Until | None
    stroke: Stroke
    gauges: Mapping[Axis, float]
    pulls: bool = False

    def cut(self, memory: Memory, begun: float) -> tuple[float, StopReason | None]:
        """Return the share of the stroke at which a time or a place ends its step, and how; 1 and None without any.

        The place of an axis that is driven by its force is not known beforehand.
        """
        cuts: list[tuple[float, StopReason]] = []
        until, stroke = self.until, self.stroke
        if until is not None and until.time is not None and stroke.duration > 0.0:
            left = memory.since + until.time - begun
            cuts.append(
                (max(left / stroke.duration, 0.0), StopReason(end="timeout", message=f"{until.time:g} s passed"))
            )
        for axis in stroke.named:
            start, travel = stroke.start[axis], stroke.end[axis] - stroke.start[axis]
            for kind, level in self._places(axis, memory):
                text = _said(kind, level - memory.history.origin[axis], self.gauges[axis])
                towards = self._side(kind, axis) in {None, ">" if travel > 0.0 else "<"}
                if travel != 0.0 and towards and (level - start) / travel >= 0.0:
                    cuts.append(((level - start) / travel, StopReason(end="limit", message=_met(kind, axis, text))))
        share, ending = min(cuts, key=lambda cut: cut[0], default=(inf, None))
        return (share, ending) if share < 1.0 else (1.0, None)

    def excess(self, memory: Memory, shown: Mapping[Axis, float], crosshead: Mapping[Axis, float]) -> float:
        """Return by what share [1] a force, or the place of an axis driven by force, passes what ends the step.

        Parameters
        ----------
        memory : Memory
            What the controller remembers of the step.
        shown, crosshead : Mapping
            What load cells [N] and encoders [m] show at a place on the stroke.
        """
        return max((one.passed for one in self._watched(memory, shown, crosshead, self.stroke.force)), default=-inf)

    def met(self, controller: Controller, memory: Memory, crosshead: Mapping[Axis, float]) -> StopReason | None:
        """Return the ending of a step at the row that was read last, if something ends it there."""
        stroke, until = self.stroke, self.until
        drops = [drop for drop in (stroke.drop, None if until is None else until.drop) if drop is not None]
        for axis in stroke.named if drops else ():
            peak, shown = memory.peak[axis], memory.shown[axis]
            if controller.counts(axis, peak) and shown <= (1.0 - min(drops)) * peak:
                return self._dropped(axis, memory)
        for one in self._watched(memory, memory.shown, crosshead, stroke.force):
            if one.passed >= -TOLERANCE:
                return StopReason(end="limit", message=_met(one.kind, one.axis, one.level))
        return None

    def met_before(self, memory: Memory, crosshead: Mapping[Axis, float]) -> StopReason | None:
        """Return the ending of a step that begins where something ends it."""
        for one in self._watched(memory, memory.shown, crosshead, self.stroke.named):
            if one.passed >= -ROUNDING:
                side = self._side(one.kind, one.axis)
                other = "<" if side == ">" else ">"
                said = self.until is not None and self.until.side(one.kind) is not None
                hint = "" if said or side is None else f" (for the other way say '{other} {one.level}')"
                met = f"until {one.kind} {side or ''} {one.level}".replace("  ", " ")
                return StopReason(
                    end="limit", message=f"{met} was met as the step began: axis {one.axis} {one.shows}{hint}"
                )
        return None

    def _dropped(self, axis: Axis, memory: Memory) -> StopReason:
        """Return the ending of a step in which the force of an axis dropped."""
        peak, shown = memory.peak[axis], memory.shown[axis]
        fell = f"the force on axis {axis} fell by {1.0 - shown / peak:.0%} below its peak of {peak:.3g} N"
        if memory.broken > memory.broken_at_peak.get(axis, 0):
            return StopReason(end="rupture", message=fell)
        if self.stroke.end[axis] > self.stroke.start[axis]:
            return StopReason(end="slipped", message=f"{fell}, though nothing broke: loops slipped or snapped")
        return StopReason(end="limit", message=fell)

    def _watched(
        self,
        memory: Memory,
        shown: Mapping[Axis, float],
        crosshead: Mapping[Axis, float],
        placed: Iterable[Axis],
    ) -> Iterator[Watched]:
        """Yield the forces that end the step, and the places of some axes, each with how far it is passed."""
        until, stroke = self.until, self.stroke
        if until is None:
            return
        force = until.level("force")
        for axis in stroke.named if force is not None else ():
            passed = _passed(self._side("force", axis), force or 0.0, memory.first[axis], shown[axis])
            shows = f"carries {shown[axis]:.4g} N"
            yield Watched(
                axis=axis, kind="force", passed=passed / (abs(force or 0.0) or 1.0), level=f"{force:g} N", shows=shows
            )
        for axis in placed:
            origin, gauge = memory.history.origin[axis], self.gauges[axis]
            for kind, level in self._places(axis, memory):
                scale = max(abs(level - origin), SMALL * gauge)
                passed = _passed(self._side(kind, axis), level, stroke.start[axis], crosshead[axis])
                yield Watched(
                    axis=axis,
                    kind=kind,
                    passed=passed / scale,
                    level=_said(kind, level - origin, gauge),
                    shows=f"is at {_said(kind, crosshead[axis] - origin, gauge)}",
                )

    def _places(self, axis: Axis, memory: Memory) -> Iterator[tuple[Control, float]]:
        """Yield the displacements [m] of an axis that end the step."""
        if self.until is None:
            return
        strain, displacement, origin = (
            self.until.level("strain"),
            self.until.level("displacement"),
            memory.history.origin[axis],
        )
        if strain is not None:
            yield "strain", origin + strain * self.gauges[axis]
        if displacement is not None:
            yield "displacement", origin + displacement

    def _side(self, kind: Control, axis: Axis) -> Side | None:
        """Return the side of a level that ends the step; None for the one where it was not when the step began."""
        said = None if self.until is None else self.until.side(kind)
        if said is not None or self.pulls:
            return said or ">"
        first, last = self.stroke.force.get(axis, (self.stroke.start[axis], self.stroke.end[axis]))
        return None if last == first else ">" if last > first else "<"


def stop_criteria_of(leaf: UnrolledStep, stroke: Stroke, gauges: Mapping[Axis, float]) -> StopCriteria:
    """Return what may end a step in one of its strokes."""
    return StopCriteria(until=leaf.step.until, stroke=stroke, gauges=gauges, pulls=leaf.step.pulls)


def _passed(side: Side | None, level: float, first: float, now: float) -> float:
    """Return how far a value is beyond a level, on its side or as seen from where it was first."""
    above = first <= level if side is None else side == ">"
    return now - level if above else level - now


def _said(kind: Control, displacement: float, gauge: float) -> str:
    """Return a displacement since the last zero [m] as text: as a strain of a length [m], or in mm."""
    return f"{displacement / gauge:.4g}" if kind == "strain" else f"{1e3 * displacement:.4g} mm"


def _met(kind: Control, axis: Axis, level: str) -> str:
    """Return the message of a level that is met."""
    does = {"force": "carries", "strain": "is strained by", "displacement": "is displaced by"}
    return f"axis {axis} {does[kind]} {level}"

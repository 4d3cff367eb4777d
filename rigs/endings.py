"""Tell where a step ends before its target: at a time, a place, a force or a drop, whichever is met first."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigs.controller import Controller, Memory
    from rigs.motion import Stroke
    from rigs.record import End
    from rigs.targets import Axis, Until


TOLERANCE: Final = 5e-3
"""An axis stops within this share of a force that ends its way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """Say how a step ended.

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
class Watch:
    """Watch a stroke for what ends its step.

    Attributes
    ----------
    until : Until or None
        What the protocol says of it.
    stroke : Stroke
        The stroke.
    gauges : Mapping
        Initial hook-to-hook length of each axis [m].
    """

    until: Until | None
    stroke: Stroke
    gauges: Mapping[Axis, float]

    def cut(self, memory: Memory, begun: float) -> tuple[float, Ending | None]:
        """Return the share of the stroke at which a time or a place ends its step, and how; 1 and None without any.

        The place of an axis that is driven by its force is not known beforehand.
        """
        cuts: list[tuple[float, Ending]] = []
        until, stroke = self.until, self.stroke
        if until is not None and until.time is not None and stroke.duration > 0.0:
            left = memory.since + until.time - begun
            cuts.append((max(left / stroke.duration, 0.0), Ending(end="timeout", message=f"{until.time:g} s passed")))
        for axis in stroke.named:
            start, way = stroke.start[axis], stroke.end[axis] - stroke.start[axis]
            for level, says in self._levels(axis, memory):
                if way != 0.0 and (level - start) / way >= 0.0:
                    cuts.append(((level - start) / way, Ending(end="limit", message=says)))
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
        return max((excess for excess, _ in self._excesses(memory, shown, crosshead)), default=-inf)

    def met(self, controller: Controller, memory: Memory, crosshead: Mapping[Axis, float]) -> Ending | None:
        """Return the ending of a step at the row that was read last, if something ends it there."""
        stroke, until = self.stroke, self.until
        drops = [drop for drop in (stroke.drop, None if until is None else until.drop) if drop is not None]
        for axis in stroke.named if drops else ():
            peak, shown = memory.peak[axis], memory.shown[axis]
            if controller.counts(axis, peak) and shown <= (1.0 - min(drops)) * peak:
                fell = f"the force on axis {axis} fell by {1.0 - shown / peak:.0%} below its peak of {peak:.3g} N"
                return Ending(end="rupture", message=fell)
        for excess, says in self._excesses(memory, memory.shown, crosshead):
            if excess >= -TOLERANCE:
                return Ending(end="limit", message=says)
        return None

    def _excesses(
        self, memory: Memory, shown: Mapping[Axis, float], crosshead: Mapping[Axis, float]
    ) -> Iterator[tuple[float, str]]:
        """Yield by what share each of the things that end the step is passed, and what to say of it."""
        until, stroke = self.until, self.stroke
        if until is None:
            return
        if until.force is not None:
            for axis in stroke.named:
                passed = _passed(until.force, memory.first[axis], shown[axis])
                yield passed / (abs(until.force) or 1.0), f"axis {axis} carries {until.force:g} N"
        for axis in stroke.force:
            for level, says in self._levels(axis, memory):
                yield _passed(level, stroke.start[axis], crosshead[axis]) / self.gauges[axis], says

    def _levels(self, axis: Axis, memory: Memory) -> Iterator[tuple[float, str]]:
        """Yield the displacements [m] of an axis that end the step, and what to say of them."""
        until, origin = self.until, memory.course.origin[axis]
        if until is not None and until.strain is not None:
            yield origin + until.strain * self.gauges[axis], f"axis {axis} is strained by {until.strain:.4g}"
        if until is not None and until.displacement is not None:
            yield origin + until.displacement, f"axis {axis} is displaced by {1e3 * until.displacement:.4g} mm"


def _passed(level: float, first: float, now: float) -> float:
    """Return how far a value is beyond a level, as seen from where it was first."""
    return now - level if first <= level else level - now

"""Waveform step: axes that follow a table of times and levels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from rigs.protocol.bounds import require, require_all, require_label
from rigs.protocol.step import StepDefaults, require_no_cycles
from rigs.protocol.targets import Target, require_axes, require_level, require_shear, require_time

if TYPE_CHECKING:
    from rigs.axes import Axis
    from rigs.protocol.strokes import Situation, Stroke
    from rigs.protocol.targets import Control, StepLog, Until

MOST_POINTS: Final = 2000
"""Points of one waveform [1]: each is written in the record's protocol, and each piece takes an equilibrium or more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Waveform(StepDefaults):
    """Drive the axes along a line through points of time and level; each straight piece is a stroke.

    The first piece begins where the axes are.

    Attributes
    ----------
    axes : tuple of Axis
        The axes; all make the same.
    points : tuple of (float, float)
        Time since the step began [s], from 0, strictly rising; and a strain [1], length [m] or force [N] as `kind`
        says, since the last zero.
    kind : {'strain', 'displacement', 'force'}
        What is controlled.
    """

    axes: tuple[Axis, ...]
    points: tuple[tuple[float, float], ...]
    kind: Control = "strain"
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        count, most = len(self.points), f"2 to {MOST_POINTS} points"
        require_all(
            lambda: require_axes(self.axes),
            lambda: require(2 <= count <= MOST_POINTS, "points", f"{count} points", most),
            self._require_points,
            lambda: require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    def _require_points(self) -> None:
        """Raise unless times rise strictly from 0, and levels are in their range."""
        for number, (time, level) in enumerate(self.points):
            require_level(self.kind, level, f"points[{number}]")
            require_shear(self.axes, self.kind, level, f"points[{number}]")
            if number == 0:
                require(time == 0.0, "points[0]", f"{time:g} s", "0 s: the step begins there")
        for number, ((before, _), (time, _)) in enumerate(pairwise(self.points), start=1):
            require(before < time, f"points[{number}]", f"{time:g} s", f"a time above {before:g} s, that before it")
            require_time(f"points[{number}]", time)

    @property
    def stroke_count(self) -> int:
        """Return how many strokes it makes: one a piece."""
        return len(self.points) - 1

    def stroke(self, index: int, situation: Situation) -> Stroke:
        """Return the stroke to the end of a piece; a level piece holds what the one before it reached."""
        (begin, before), (end, level) = self.points[index : index + 2]
        stroke = situation.move(self.axes, Target(kind=self.kind, value=level))
        travels = bool(stroke.force) or any(
            abs(stroke.end[axis] - stroke.start[axis]) > 1e-12 * situation.gauges[axis] for axis in self.axes
        )
        if not travels or (index > 0 and level == before):
            return situation.hold(end - begin, self.axes, tuple(stroke.force))
        return situation.in_set(replace(stroke, duration=end - begin))

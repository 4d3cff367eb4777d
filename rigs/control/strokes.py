"""Turn the steps of a protocol into strokes: what each driven axis does, and for how long.

A displacement is the change of the hook-to-hook length of an axis since the specimen was mounted, as the machine's
encoder sees it [m]; a force is what the load cell shows [N]. Both are known only when a stroke begins, so a plan is
asked for one stroke after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from rigs.protocol.catalogue import CATALOGUE
from rigs.protocol.steps import Cycle, Hold, Image, Preload, Ramp, UntilRupture, Zero
from rigs.protocol.targets import MOST_STRAIN, ForceRate, StrainRate, Target

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.steps import Channel, Drive
    from rigs.protocol.unrolled import UnrolledStep
    from rigs.record import Phase

PRELOAD_REACH: Final = 0.5
"""A preload that has not met its force after this strain has met its limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """Describe one move of the axes.

    Parameters
    ----------
    start, end : Mapping
        Displacement of each axis [m]; that of an axis in `force` or `free` stays open, and `end` is its `start`.
    duration : float
        Time it takes [s].
    phase : {'Zero', 'Preload', 'Stretch', 'Recover', 'Hold'}
        What it is to the specimen.
    cycle : int
        Number of the set it belongs to, from 1 [1].
    step : int
        Turn of the step that it is part of, from 0.
    tag : str or None
        The step's tag.
    named : tuple of Axis
        The axes that the step names; `until` looks at them.
    force : Mapping
        First and last force of axes whose force is controlled [N].
    free : tuple of Axis
        Axes that give way so that they carry no force.
    follow : Axis or None
        The axis whose strain those not named make too, where that is not known beforehand.
    stop_force : float or None
        A named axis stops where it carries this force [N].
    drop : float or None
        The step ends where the force fell by this share below its peak [1].
    channels : tuple of str
        Channels to tare (phase 'Zero').
    """

    start: Mapping[Axis, float]
    end: Mapping[Axis, float]
    duration: float
    phase: Phase
    cycle: int
    step: int = 0
    tag: str | None = None
    named: tuple[Axis, ...] = ()
    force: Mapping[Axis, tuple[float, float]]
    free: tuple[Axis, ...] = ()
    follow: Axis | None = None
    stop_force: float | None = None
    drop: float | None = None
    channels: tuple[Channel, ...] = ()

    @property
    def searches(self) -> bool:
        """Return whether it goes only as far as something asks that is not known beforehand."""
        return self.stop_force is not None or self.drop is not None


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """Hold what the controller sees.

    Attributes
    ----------
    displacement : Mapping
        What the encoder of each axis shows, not zeroed [m].
    force : Mapping
        What the load cell of each axis shows on average, zeroed [N].
    """

    displacement: Mapping[Axis, float]
    force: Mapping[Axis, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """Hold what of a test so far matters to the strokes to come.

    Attributes
    ----------
    origin : Mapping
        Displacement of each axis at the last zero [m].
    cycle : int
        Number of the set, from 1.
    stretched, recovered : bool
        Whether the set has seen a stretch, and a recovery.
    free : tuple of Axis
        Axes that gave way in the last stroke; a hold leaves them so.
    """

    origin: Mapping[Axis, float]
    cycle: int = 1
    stretched: bool = False
    recovered: bool = False
    free: tuple[Axis, ...] = ()

    def after(self, stroke: Stroke, sight: Readings) -> History:
        """Return the course after a stroke."""
        return replace(
            self,
            origin=dict(sight.displacement) if "displacement" in stroke.channels else self.origin,
            cycle=stroke.cycle,
            stretched=stroke.phase == "Stretch" or (self.stretched and stroke.cycle == self.cycle),
            recovered=stroke.phase == "Recover" or (self.recovered and stroke.cycle == self.cycle),
            free=stroke.free if stroke.phase != "Zero" else self.free,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Planner:
    """Plan the strokes of a protocol on a specimen of some hook-to-hook lengths [m]."""

    protocol: Protocol
    gauges: Mapping[Axis, float]

    def begin(self) -> History:
        """Return the course of a test that begins."""
        return History(origin=dict.fromkeys(self.gauges, 0.0))

    def stroke(self, leaf: UnrolledStep, index: int, course: History, sight: Readings) -> Stroke | None:
        """Return a stroke of a step, None where it moves nothing.

        Axes driven together arrive together; the rate is that of the named axis with the longest way. A ramp to
        where the axes already stand makes no stroke.

        Parameters
        ----------
        leaf : UnrolledStep
            The step.
        index : int
            Number of the stroke in it, from 0 to `UnrolledStep.strokes`.
        course, sight
            What came before, and what the controller sees now.

        Raises
        ------
        SpecificationError
            If hooks would pass through each other.
        """
        step, here = leaf.step, dict(sight.displacement)
        still = Stroke(
            start=here,
            end=here,
            duration=0.0,
            phase="Zero",
            cycle=course.cycle,
            step=leaf.number,
            tag=leaf.tag,
            named=tuple(here),
            force={},
            free=course.free,
        )
        match step:
            case Zero():
                return replace(still, channels=step.channels)
            case Hold():
                return self._hold(step, still, sight)
            case Image():
                return None
            case Cycle():
                level = step.lower if index % 2 else step.upper
                aim = Target(kind=step.control, value=level)
                return _in_set(self._drive(step, aim, still, course, sight), course, first=index == 0)
            case _:
                return _in_set(self._drive(step, _aim(step), still, course, sight), course)

    def _hold(self, step: Hold, still: Stroke, sight: Readings) -> Stroke:
        """Return the stroke that stands still, or keeps forces."""
        named = step.axes or still.named
        kept = {axis: (sight.force[axis],) * 2 for axis in step.axes} if step.control == "force" else {}
        free = tuple(axis for axis in still.free if axis not in step.axes)
        return replace(still, phase="Hold", duration=step.duration, named=named, force=kept, free=free)

    def _drive(self, step: Drive, aim: Target | None, still: Stroke, course: History, sight: Readings) -> Stroke | None:
        """Return the stroke that drives the axes of a step to a target; None if there is no way to go."""
        here, others = still.start, [axis for axis in still.start if axis not in step.axes]
        mode = self.protocol.others
        forces: dict[Axis, tuple[float, float]] = {}
        end = dict(here)
        if aim is not None and aim.kind == "force":
            forces = {axis: (sight.force[axis], aim.value) for axis in step.axes}
        else:
            for axis in step.axes:
                end[axis] = self._destination(step, aim, axis, here[axis], course.origin[axis])
            if mode == "follow":
                lead = step.axes[0]
                strain = (end[lead] - here[lead]) / self.gauges[lead]
                end |= {axis: here[axis] + strain * self.gauges[axis] for axis in others}
        self._require_room(end)
        duration = self._duration(step, here, end, forces)
        if duration == 0.0:
            return None
        far = max(step.axes, key=lambda axis: abs(end[axis] - here[axis]))
        rises = sum(last - first for first, last in forces.values()) if forces else end[far] - here[far]
        return replace(
            still,
            end=end,
            duration=duration,
            phase="Preload" if isinstance(step, Preload) else "Stretch" if rises > 0.0 else "Recover",
            named=step.axes,
            force=forces,
            free=tuple(others) if mode == "free" else (),
            follow=step.axes[0] if mode == "follow" and forces and others else None,
            stop_force=step.force if isinstance(step, Preload) and not forces else None,
            drop=step.drop if isinstance(step, UntilRupture) else None,
        )

    def _destination(self, step: Drive, aim: Target | None, axis: Axis, here: float, origin: float) -> float:
        """Return the displacement of an axis at the end of a step [m]."""
        length = self.gauges[axis]
        if aim is None:
            return here + (PRELOAD_REACH if isinstance(step, Preload) else MOST_STRAIN) * length
        return origin + aim.value * (length if aim.kind == "strain" else 1.0)

    def _require_room(self, end: Mapping[Axis, float]) -> None:
        """Raise if hooks would pass through each other."""
        for axis, length in self.gauges.items():
            if end[axis] <= -length:
                found = f"{end[axis]:g} m on axis {axis}"
                raise SpecificationError("steps", found, f"a displacement above {-length:g} m")

    def _duration(
        self,
        step: Drive,
        here: Mapping[Axis, float],
        end: Mapping[Axis, float],
        forces: Mapping[Axis, tuple[float, float]],
    ) -> float:
        """Return the time that the named axis with the longest way takes [s]; 0 if none has any, rounding apart."""
        rate = step.rate
        if isinstance(rate, ForceRate):
            way = max(abs(last - first) for first, last in forces.values())
            return way / rate.value
        ways = {axis: abs(end[axis] - here[axis]) for axis in step.axes}
        if all(way <= 1e-12 * self.gauges[axis] for axis, way in ways.items()):
            return 0.0
        if isinstance(rate, StrainRate):
            return max(way / self.gauges[axis] for axis, way in ways.items()) / rate.value
        farthest = max(ways, key=lambda axis: ways[axis])
        # Where two grips move apart, a pair's length changes twice as fast as one of them moves.
        moving = CATALOGUE[self.protocol.rig].drives[farthest].moving
        return ways[farthest] / (rate * (1 if self.protocol.speed_ref == "pair" else moving))


def _aim(step: Drive) -> Target | None:
    """Return where a step drives its axes, None where it searches."""
    match step:
        case Ramp() | UntilRupture():
            return step.to
        case Preload():
            return Target(kind="force", value=step.force) if step.drives == "force" else None
        case Cycle():
            return None


def _in_set(stroke: Stroke | None, course: History, *, first: bool = False) -> Stroke | None:
    """Return a stroke with the number of its set: a stretch after a recovery opens one, and the `first` of cycles."""
    if stroke is None:
        return None
    opens = course.recovered and stroke.phase in {"Stretch", "Preload"}
    opens = opens or (first and stroke.phase == "Stretch" and course.stretched)
    return replace(stroke, cycle=course.cycle + opens)

"""Strokes: what each driven axis does in one part of a step, and for how long.

A displacement is the change of the hook-to-hook length of an axis since the specimen was mounted, as the machine's
encoder sees it [m]; a force is what the load cell shows [N]. Both are known only when a stroke begins, so a step is
asked for one stroke after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from rigs.axes import FACE, SHEARS
from rigs.protocol.targets import MOST_SHEAR, MOST_STRAIN, ForceRate, StrainRate, require_room

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis
    from rigs.protocol.catalogue import Others
    from rigs.protocol.targets import Channel, GaugeLength, Rate, Target
    from rigs.record import Phase

PRELOAD_REACH: Final = 0.5
"""A preload that has not met its force after this strain has met its limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """One move of the axes.

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
        Index of the step that it is part of, from 0.
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
    gauge_length : GaugeLength or None
        Which gauge length holds from then on; None for the one before (phase 'Zero').
    gauges : Mapping
        That gauge length of each axis [m]; empty for those before.
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
    gauge_length: GaugeLength | None = None
    gauges: Mapping[Axis, float] = field(default_factory=dict)

    @property
    def searches(self) -> bool:
        """Return whether its end is a force or a drop that is met at a displacement not known beforehand."""
        return self.stop_force is not None or self.drop is not None


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """What the controller sees.

    Attributes
    ----------
    displacement : Mapping
        What the encoder of each axis shows, not zeroed [m].
    force : Mapping
        What the load cell of each axis shows on average, zeroed [N].
    opening : Mapping
        Change of the distance between the hooks themselves [m]; it is the displacement unless the machine gives way.
    """

    displacement: Mapping[Axis, float]
    force: Mapping[Axis, float]
    opening: Mapping[Axis, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.opening:
            object.__setattr__(self, "opening", dict(self.displacement))


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """What of a test so far matters to the strokes to come.

    Attributes
    ----------
    origin : Mapping
        Displacement of each axis at the last zero [m].
    gauges : Mapping
        Gauge length of each axis [m], by which its travel from there is strain.
    cycle : int
        Number of the set, from 1.
    stretched, recovered : bool
        Whether the set has seen a stretch, and a recovery.
    free : tuple of Axis
        Axes that gave way in the last stroke; a hold leaves them so.
    """

    origin: Mapping[Axis, float]
    gauges: Mapping[Axis, float]
    cycle: int = 1
    stretched: bool = False
    recovered: bool = False
    free: tuple[Axis, ...] = ()

    def after(self, stroke: Stroke, readings: Readings) -> History:
        """Return the history after a stroke."""
        return replace(
            self,
            origin=dict(readings.displacement) if "displacement" in stroke.channels else self.origin,
            gauges=stroke.gauges or self.gauges,
            cycle=stroke.cycle,
            stretched=stroke.phase == "Stretch" or (self.stretched and stroke.cycle == self.cycle),
            recovered=stroke.phase == "Recover" or (self.recovered and stroke.cycle == self.cycle),
            free=stroke.free if stroke.phase != "Zero" else self.free,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What a step is told to make its next stroke.

    Attributes
    ----------
    printed : Mapping
        Hook-to-hook length of each axis as printed [m].
    gears : Mapping
        Change of each axis' hook-to-hook length over the travel that a rate in m/s is said of [1].
    others : {'hold', 'free', 'follow'}
        What axes do that a step does not name.
    history, readings
        What came before, and what the controller sees now.
    """

    printed: Mapping[Axis, float]
    gears: Mapping[Axis, float]
    others: Others
    history: History
    readings: Readings

    @property
    def gauges(self) -> Mapping[Axis, float]:
        """Return the gauge length of each axis [m], by which its travel is strain."""
        return self.history.gauges

    def zero(self, channels: tuple[Channel, ...], gauge_length: GaugeLength | None) -> Stroke:
        """Return the stroke in which channels are tared and a gauge length may be taken."""
        gauges = dict(self.printed) if gauge_length is not None else {}
        if gauge_length == "here":
            # Of a shear it is the length across its face, which only grows where an axis drives it.
            gauges = {axis: length + self.readings.opening.get(FACE[axis], 0.0) for axis, length in gauges.items()}
        return replace(self.still(), channels=channels, gauge_length=gauge_length, gauges=gauges)

    def still(self) -> Stroke:
        """Return the stroke of phase 'Zero' in which no axis moves and no time passes."""
        here, history = dict(self.readings.displacement), self.history
        return Stroke(
            start=here,
            end=here,
            duration=0.0,
            phase="Zero",
            cycle=history.cycle,
            named=tuple(here),
            force={},
            free=history.free,
        )

    def hold(self, duration: float, axes: Sequence[Axis] = (), forced: Sequence[Axis] = ()) -> Stroke:
        """Return a stroke of some time [s] in which displacements stay, or the forces of the `forced` axes.

        Named axes are held; others that gave way before go on to do so.
        """
        still = self.still()
        return replace(
            still,
            phase="Hold",
            duration=duration,
            named=tuple(axes) or still.named,
            force={axis: (self.readings.force[axis],) * 2 for axis in forced},
            free=tuple(axis for axis in still.free if axis not in axes),
        )

    def move(self, axes: tuple[Axis, ...], aim: Target | None, *, reach: float = MOST_STRAIN) -> Stroke:
        """Return the stroke of some axes to a target; its `duration` is 0 and for the caller to set.

        Parameters
        ----------
        axes : tuple of Axis
            The axes that the step names.
        aim : Target or None
            Where they go; None to go on by the strain `reach` [1].
        reach : float
            Strain of a stroke without a target.

        Raises
        ------
        SpecificationError
            If hooks would pass through each other, or a cell would be sheared too far.
        """
        here, still = self.readings.displacement, self.still()
        others = [axis for axis in still.start if axis not in axes]
        forces: dict[Axis, tuple[float, float]] = {}
        end = dict(here)
        if aim is not None and aim.kind == "force":
            forces = {axis: (self.readings.force[axis], aim.value) for axis in axes}
        else:
            for axis in axes:
                end[axis] = self._destination(axis, aim, reach)
            if self.others == "follow":
                lead = axes[0]
                strain = (end[lead] - here[lead]) / self.gauges[lead]
                end |= {axis: here[axis] + strain * self.gauges[axis] for axis in others}
        for axis, length in self.printed.items():
            require_room(axis, end[axis], length)
        farthest = max(axes, key=lambda axis: abs(end[axis] - here[axis]))
        rises = sum(last - first for first, last in forces.values()) if forces else end[farthest] - here[farthest]
        return replace(
            still,
            end=end,
            phase="Stretch" if rises > 0.0 else "Recover",
            named=axes,
            force=forces,
            free=tuple(others) if self.others == "free" else (),
            follow=axes[0] if self.others == "follow" and forces and others else None,
        )

    def drive(
        self, axes: tuple[Axis, ...], rate: Rate, aim: Target | None, *, reach: float = MOST_STRAIN
    ) -> Stroke | None:
        """Return the stroke of some axes to a target at a rate; None if they are there.

        Axes driven together arrive together; the rate is that of the named axis with the longest travel. Parameters
        and errors are those of `move`.
        """
        stroke = self.move(axes, aim, reach=reach)
        duration = self._duration(stroke, rate)
        return None if duration == 0.0 else replace(stroke, duration=duration)

    def in_set(self, stroke: Stroke, *, first: bool = False) -> Stroke:
        """Return a stroke with the number of its set: a stretch after a recovery opens one, so does a `first` cycle."""
        history = self.history
        opens = history.recovered and stroke.phase in {"Stretch", "Preload"}
        opens = opens or (first and stroke.phase == "Stretch" and history.stretched)
        return replace(stroke, cycle=history.cycle + opens)

    def _destination(self, axis: Axis, aim: Target | None, reach: float) -> float:
        """Return the displacement of an axis at the end of a stroke [m]."""
        length = self.gauges[axis]
        if aim is None:
            going = self.readings.displacement[axis] + reach * length
            return min(going, MOST_SHEAR * self.printed[axis]) if axis in SHEARS else going
        return self.history.origin[axis] + aim.value * (length if aim.kind == "strain" else 1.0)

    def _duration(self, stroke: Stroke, rate: Rate) -> float:
        """Return the time that the named axis with the longest travel takes [s]; 0 if none travels, rounding apart."""
        if isinstance(rate, ForceRate):
            return max(abs(last - first) for first, last in stroke.force.values()) / rate.value
        travels = {axis: abs(stroke.end[axis] - stroke.start[axis]) for axis in stroke.named}
        if all(travel <= 1e-12 * self.gauges[axis] for axis, travel in travels.items()):
            return 0.0
        if isinstance(rate, StrainRate):
            return max(travel / self.gauges[axis] for axis, travel in travels.items()) / rate.value
        farthest = max(travels, key=lambda axis: travels[axis])
        return travels[farthest] / (rate * self.gears[farthest])

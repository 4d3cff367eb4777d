"""Steps of a protocol: what is done to a specimen; SI floats throughout."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final, Literal

from rigs.axes import AXES, Axis
from rigs.protocol.bounds import require, require_all, require_label
from rigs.protocol.step import Step, StepDefaults, require_no_cycles
from rigs.protocol.strokes import PRELOAD_REACH
from rigs.protocol.targets import (
    Channel,
    Control,
    GaugeLength,
    Rate,
    StepLog,
    Target,
    Until,
    require_axes,
    require_controlled,
    require_drop,
    require_level,
    require_rate,
    require_shear,
    require_time,
)

if TYPE_CHECKING:
    from rigs.protocol.step import Pictures
    from rigs.protocol.strokes import Situation, Stroke

RUPTURE_DROP: Final = 0.6
"""Share by which the force must fall below its peak for a rupture, unless a protocol says otherwise [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Zero(StepDefaults):
    """Set the named channels to zero, and choose the gauge length by which travel is strain from then on.

    Parameters
    ----------
    channels : tuple of Channel
        The channels.
    gauge_length : GaugeLength or None
        The hook-to-hook length now, or the printed specimen's; None to keep the gauge length, at first the printed one.
    """

    channels: tuple[Channel, ...] = ("force", "displacement")
    gauge_length: GaugeLength | None = None

    axes: ClassVar[tuple[Axis, ...]] = ()
    tag: ClassVar[None] = None
    until: ClassVar[None] = None
    log: ClassVar[None] = None
    moves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        fine = len(self.channels) > 0 and len(set(self.channels)) == len(self.channels)
        require(fine, "channels", list(self.channels), "one or both of force and displacement, each once")
        counted = self.gauge_length is None or "displacement" in self.channels
        wanted = "one with displacement among the channels: strain is zero where travel is"
        require(counted, "gauge_length", f"{self.gauge_length} with channels {list(self.channels)}", wanted)

    @property
    def tares(self) -> tuple[Channel, ...]:
        """Return the channels that are set to zero."""
        return self.channels

    def stroke(self, index: int, situation: Situation) -> Stroke:  # noqa: ARG002 (there is one)
        """Return a stroke in which nothing moves."""
        return situation.zero(self.channels, self.gauge_length)


@dataclass(frozen=True, slots=True, kw_only=True)
class Preload(StepDefaults):
    """Load the axes until the load cell of each shows `force` [N].

    Driven at a speed or strain rate an axis that has met the force stops and stays while the others go on; with
    ``control='force'`` all forces go there together at a force rate, from whichever side, and are all held.
    """

    axes: tuple[Axis, ...]
    force: float
    rate: Rate
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    pulls: ClassVar[bool] = True

    def __post_init__(self) -> None:
        force, forced = f"{self.force:g} N", self.control == "force"
        # An axis that is driven outwards does not pass zero force.
        allowed = "a force from 0" if forced else "a force above 0 (from 0 with control: force)"
        fine = 0.0 < self.force <= 1e4 or (forced and self.force == 0.0)
        require_all(
            lambda: require_axes(self.axes),
            lambda: require(fine, "force", force, f"{allowed} and up to 10 kN"),
            lambda: require_rate(self.rate, self.control or "displacement"),
            lambda: require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    def stroke(self, index: int, situation: Situation) -> Stroke | None:  # noqa: ARG002 (there is one)
        """Return the stroke until the force is met, or the axes have gone as far as `PRELOAD_REACH`."""
        forced = self.control == "force"
        aim = Target(kind="force", value=self.force) if forced else None
        stroke = situation.drive(self.axes, self.rate, aim, reach=PRELOAD_REACH)
        if stroke is None:
            return None
        return situation.in_set(replace(stroke, phase="Preload", stop_force=None if forced else self.force))


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp(StepDefaults):
    """Drive the axes to a target together, the one with the longest travel at `rate`."""

    axes: tuple[Axis, ...]
    to: Target
    rate: Rate
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        controlled = self.to.kind if self.control is None or self.control == "force" else self.control
        require_all(
            lambda: require_axes(self.axes),
            lambda: require_controlled(self.control, self.to),
            lambda: require_shear(self.axes, self.to.kind, self.to.value, f"to.{self.to.kind}"),
            lambda: require_rate(self.rate, controlled),
            lambda: require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    def stroke(self, index: int, situation: Situation) -> Stroke | None:  # noqa: ARG002 (there is one)
        """Return the stroke to the target."""
        stroke = situation.drive(self.axes, self.rate, self.to)
        return None if stroke is None else situation.in_set(stroke)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold(StepDefaults):
    """Keep displacements for `duration` [s], or with ``control='force'`` the forces of `axes`."""

    duration: float
    axes: tuple[Axis, ...] = ()
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    moves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        named = bool(self.axes) or self.control != "force"
        require_all(
            lambda: require_time("duration", self.duration),
            lambda: require_axes(self.axes or AXES),
            lambda: require(named, "axes", "nothing", "a list of the axes whose force is held, such as [C, W]"),
            lambda: require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    def stroke(self, index: int, situation: Situation) -> Stroke:  # noqa: ARG002 (there is one)
        """Return the stroke in which displacements stay, or forces."""
        return situation.hold(self.duration, self.axes, self.axes if self.control == "force" else ())


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle(StepDefaults):
    """Drive the axes to `upper`, then to `lower`, at `rate`, `n` times.

    Both are strains [1], lengths [m] or forces [N], as `control` says.
    """

    axes: tuple[Axis, ...]
    lower: float
    upper: float
    rate: Rate
    n: int
    control: Control = "strain"
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    pulls: ClassVar[bool] = True
    cyclic: ClassVar[bool] = True

    def __post_init__(self) -> None:
        require_all(
            lambda: require_axes(self.axes),
            self._require_ends,
            lambda: require_rate(self.rate, self.control),
            lambda: require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000"),
            lambda: require_label("tag", self.tag),
        )

    def _require_ends(self) -> None:
        """Raise unless the ends are in their range, and the upper one above the lower."""
        require_all(
            lambda: require_level(self.control, self.lower, "lower"),
            lambda: require_level(self.control, self.upper, "upper"),
            lambda: require_shear(self.axes, self.control, self.lower, "lower"),
            lambda: require_shear(self.axes, self.control, self.upper, "upper"),
        )
        require(self.lower < self.upper, "upper", self.upper, f"a {self.control} above lower ({self.lower:g})")

    @property
    def stroke_count(self) -> int:
        """Return how many strokes it makes: two a cycle."""
        return 2 * self.n

    def stroke(self, index: int, situation: Situation) -> Stroke | None:
        """Return a stroke to the upper end, or back to the lower one."""
        aim = Target(kind=self.control, value=self.lower if index % 2 else self.upper)
        stroke = situation.drive(self.axes, self.rate, aim)
        return None if stroke is None else situation.in_set(stroke, first=index == 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """Steps that are done `n` times."""

    n: int
    steps: tuple[Step | Repeat, ...]

    def __post_init__(self) -> None:
        require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        require(len(self.steps) > 0, "steps", [], "one step or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class UntilRupture(StepDefaults):
    """Drive the axes on until the force fell by the share `drop` [1] below its peak, or the specimen tears.

    Fibres that break one by one end nothing. `to` is a ceiling; without it the rig's travel is.
    """

    axes: tuple[Axis, ...]
    rate: Rate
    drop: float = RUPTURE_DROP
    to: Target | None = None
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    pulls: ClassVar[bool] = True
    to_rupture: ClassVar[bool] = True

    def __post_init__(self) -> None:
        seen, place = "strain or displacement: under a controlled force no drop is seen", "a strain or a displacement"
        require_all(
            lambda: require_axes(self.axes),
            lambda: require(self.control != "force", "control", "force", seen),
            lambda: require(self.to is None or self.to.kind != "force", "to", "a force", place),
            lambda: None if self.to is None else require_shear(self.axes, self.to.kind, self.to.value, "to.strain"),
            lambda: require_rate(self.rate, "displacement"),
            lambda: require_drop("drop", self.drop),
            lambda: require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    def stroke(self, index: int, situation: Situation) -> Stroke | None:  # noqa: ARG002 (there is one)
        """Return the stroke to the ceiling, which a drop of the force ends."""
        stroke = situation.drive(self.axes, self.rate, self.to)
        return None if stroke is None else situation.in_set(replace(stroke, drop=self.drop))


@dataclass(frozen=True, slots=True, kw_only=True)
class Image(StepDefaults):
    """Take a picture now, or from now on one `every` so many seconds, or none any more ('off')."""

    every: float | Literal["off"] | None = None
    tag: str | None = None

    axes: ClassVar[tuple[Axis, ...]] = ()
    until: ClassVar[None] = None
    log: ClassVar[None] = None
    moves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        every = 1.0 if self.every is None or self.every == "off" else self.every
        require_all(lambda: require_time("every", every), lambda: require_label("tag", self.tag))

    @property
    def pictures(self) -> Pictures:
        """Return what is asked of the microscope."""
        return "one" if self.every is None else self.every

    def stroke(self, index: int, situation: Situation) -> None:
        """Return no stroke: a picture takes no time."""

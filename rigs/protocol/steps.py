"""Say what is done to a specimen, step by step; SI floats throughout."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from rigs.axes import AXES, Axis
from rigs.protocol.bounds import require, require_all, require_label
from rigs.protocol.targets import (
    Control,
    ForceRate,
    Rate,
    StepLog,
    StrainRate,
    Target,
    Until,
    require_axes,
    require_drop,
    require_level,
    require_rate,
    require_time,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = [
    "Channel",
    "Control",
    "Cycle",
    "ForceRate",
    "Hold",
    "Image",
    "Preload",
    "Ramp",
    "Rate",
    "Repeat",
    "Step",
    "StepLog",
    "StrainRate",
    "Target",
    "Until",
    "UntilRupture",
    "Zero",
    "axes_of",
    "step_name",
    "stroke_count",
]

Channel: TypeAlias = Literal["force", "displacement"]

RUPTURE_DROP: Final = 0.6
"""Share by which the force must fall below its peak for a rupture, unless a protocol says otherwise [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Zero:
    """Tare the named channels where they stand."""

    channels: tuple[Channel, ...] = ("force", "displacement")

    def __post_init__(self) -> None:
        fine = len(self.channels) > 0 and len(set(self.channels)) == len(self.channels)
        require(fine, "channels", list(self.channels), "one or both of force and displacement, each once")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preload:
    """Load the axes until the load cell of each shows `force` [N].

    Driven at a speed or strain rate an axis that has met the force stops and stands while the others go on; with
    ``control='force'`` all forces rise together at a force rate and are all held.
    """

    axes: tuple[Axis, ...]
    force: float
    rate: Rate
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        force = f"{self.force:g} N"
        require_all(
            lambda: require_axes(self.axes),
            lambda: require(0.0 < self.force <= 1e4, "force", force, "a force above 0 and up to 10 kN"),
            lambda: require_rate(self.rate, self.drives),
            lambda: _require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    @property
    def drives(self) -> Control:
        """Return what the controller makes follow its course."""
        return self.control or "displacement"


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp:
    """Drive the axes to a target together, the one with the longest way at `rate`."""

    axes: tuple[Axis, ...]
    to: Target
    rate: Rate
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        require_all(
            lambda: require_axes(self.axes),
            lambda: _require_same(self.control, self.to),
            lambda: require_rate(self.rate, self.drives if self.drives != "force" else self.to.kind),
            lambda: _require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    @property
    def drives(self) -> Control:
        """Return what the controller makes follow its course."""
        return self.to.kind if self.control is None else self.control


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """Stand still for `duration` [s], or with ``control='force'`` keep the forces of `axes` as they are."""

    duration: float
    axes: tuple[Axis, ...] = ()
    control: Control | None = None
    until: Until | None = None
    log: StepLog | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        named = bool(self.axes) or self.control != "force"
        require_all(
            lambda: require_time("duration", self.duration),
            lambda: require_axes(self.axes or AXES),
            lambda: require(named, "axes", "nothing", "a list of the axes whose force is held, such as [C, W]"),
            lambda: _require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
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
        )
        require(self.lower < self.upper, "upper", self.upper, f"a {self.control} above lower ({self.lower:g})")

    @property
    def drives(self) -> Control:
        """Return what the controller makes follow its course."""
        return self.control


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """Do the steps `n` times over."""

    n: int
    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        require(len(self.steps) > 0, "steps", [], "one step or more")


@dataclass(frozen=True, slots=True, kw_only=True)
class UntilRupture:
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

    def __post_init__(self) -> None:
        seen, place = "strain or displacement: under a controlled force no drop is seen", "a strain or a displacement"
        require_all(
            lambda: require_axes(self.axes),
            lambda: require(self.control != "force", "control", "force", seen),
            lambda: require(self.to is None or self.to.kind != "force", "to", "a force", place),
            lambda: require_rate(self.rate, "displacement"),
            lambda: require_drop("drop", self.drop),
            lambda: _require_no_cycles(self.log),
            lambda: require_label("tag", self.tag),
        )

    @property
    def drives(self) -> Control:
        """Return what the controller makes follow its course."""
        return self.control or "displacement"


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """Take a picture now, or from now on one `every` so many seconds, or none any more ('off')."""

    every: float | Literal["off"] | None = None
    tag: str | None = None

    def __post_init__(self) -> None:
        every = 1.0 if self.every is None or self.every == "off" else self.every
        require_all(lambda: require_time("every", every), lambda: require_label("tag", self.tag))


Drive: TypeAlias = Preload | Ramp | Cycle | UntilRupture
Step: TypeAlias = Zero | Preload | Ramp | Hold | Cycle | Repeat | UntilRupture | Image


def step_name(step: Step) -> str:
    """Return what a file calls a kind of step.

    Examples
    --------
    >>> step_name(UntilRupture(axes=("C",), rate=1e-4))
    'until_rupture'
    """
    return re.sub(r"(?<=.)([A-Z])", r"_\1", type(step).__name__).lower()


def stroke_count(steps: Sequence[Step]) -> int:
    """Count the single strokes that `steps` make, repeats and cycles counted out [1]."""
    count = 0
    for step in steps:
        match step:
            case Repeat():
                count += step.n * stroke_count(step.steps)
            case Cycle():
                count += 2 * step.n
            case _:
                count += 1
    return count


def axes_of(steps: Sequence[Step], under: str = "steps") -> Iterator[tuple[str, tuple[Axis, ...]]]:
    """Yield where the axes of each step are said, ``steps[2].cycle.axes``, and which they are."""
    for number, step in enumerate(steps):
        place = f"{under}[{number}].{step_name(step)}"
        match step:
            case Repeat():
                yield from axes_of(step.steps, f"{place}.steps")
            case Preload() | Ramp() | Cycle() | UntilRupture() | Hold():
                yield f"{place}.axes", step.axes
            case _:
                pass


def _require_no_cycles(log: StepLog | None) -> None:
    """Raise if a step without cycles keeps some of them."""
    every = None if log is None else log.every_cycle
    require(every is None, "log.every_cycle", every, "no such field: only a step cycle has cycles")


def _require_same(control: Control | None, to: Target) -> None:
    """Raise unless what is controlled can end at a target."""
    if control is None or (control == "force") == (to.kind == "force"):
        return
    found = f"{to.kind} with control: {control}"
    stop = " (to stop at a force say until: {force: 1 N})" if to.kind == "force" else ""
    wanted = "force" if control == "force" else "a strain or a displacement"
    require(allowed=False, name="to", found=found, expected=f"{wanted}{stop}")

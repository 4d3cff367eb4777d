"""Say what is done to a specimen, step by step; SI floats throughout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from rigs.bounds import require, require_label

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

Axis: TypeAlias = Literal["C", "W", "P"]
Channel: TypeAlias = Literal["force", "displacement"]

AXES: Final[tuple[Axis, ...]] = ("C", "W", "P")
"""Directions of a knit: course x, wale y, pile z."""


def _require_axes(axes: Sequence[str]) -> None:
    """Raise unless `axes` names each driven axis once."""
    fine = len(axes) > 0 and len(set(axes)) == len(axes) and set(axes) <= set(AXES)
    require(fine, "axes", list(axes), "one or more of C, W and P, each once")


def _require_speed(rate: float) -> None:
    """Raise unless `rate` is a speed a stage can have [m/s]."""
    require(0.0 < rate <= 1.0, "rate", f"{rate:g} m/s", "a speed above 0 and up to 1 m/s")


def _require_strain(name: str, strain: float) -> None:
    """Raise unless `strain` leaves a specimen between the hooks [1]."""
    require(-0.9 <= strain <= 5.0, name, strain, "a strain from -0.9 to 5")


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Say where an axis goes: a strain [1], or a change of hook-to-hook length [m], since the last zero."""

    kind: Literal["strain", "displacement"]
    value: float

    def __post_init__(self) -> None:
        if self.kind == "strain":
            _require_strain("strain", self.value)
        else:
            require(-10.0 <= self.value <= 10.0, "displacement", f"{self.value:g} m", "a length from -10 m to 10 m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Zero:
    """Tare the named channels where they stand."""

    channels: tuple[Channel, ...] = ("force", "displacement")

    def __post_init__(self) -> None:
        fine = len(self.channels) > 0 and len(set(self.channels)) == len(self.channels)
        require(fine, "channels", list(self.channels), "one or both of force and displacement, each once")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preload:
    """Draw the axes apart until each carries `force` [N], at `rate` [m/s]."""

    axes: tuple[Axis, ...]
    force: float
    rate: float
    tag: str | None = None

    def __post_init__(self) -> None:
        _require_axes(self.axes)
        require(0.0 < self.force <= 1e4, "force", f"{self.force:g} N", "a force above 0 and up to 10 kN")
        _require_speed(self.rate)
        require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp:
    """Drive the axes to a target together, the one with the longest way at `rate` [m/s]."""

    axes: tuple[Axis, ...]
    to: Target
    rate: float
    tag: str | None = None

    def __post_init__(self) -> None:
        _require_axes(self.axes)
        _require_speed(self.rate)
        require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """Stand still for `duration` [s]."""

    duration: float
    tag: str | None = None

    def __post_init__(self) -> None:
        require(0.0 < self.duration <= 1e7, "duration", f"{self.duration:g} s", "a time above 0 and up to 1e7 s")
        require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """Drive the axes to strain `upper`, then to `lower` [1], at `rate` [m/s], `n` times."""

    axes: tuple[Axis, ...]
    lower: float
    upper: float
    rate: float
    n: int
    tag: str | None = None

    def __post_init__(self) -> None:
        _require_axes(self.axes)
        _require_strain("lower", self.lower)
        _require_strain("upper", self.upper)
        require(self.lower < self.upper, "upper", self.upper, f"a strain above lower ({self.lower:g})")
        _require_speed(self.rate)
        require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """Do the steps `n` times over."""

    n: int
    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        require(len(self.steps) > 0, "steps", [], "one step or more")


Step: TypeAlias = Zero | Preload | Ramp | Hold | Cycle | Repeat


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
        place = f"{under}[{number}].{type(step).__name__.lower()}"
        match step:
            case Repeat():
                yield from axes_of(step.steps, f"{place}.steps")
            case Preload() | Ramp() | Cycle():
                yield f"{place}.axes", step.axes
            case _:
                pass

"""Targets and rates of axes, and what ends or logs a step; SI floats throughout."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from rigs.axes import AXES, SHEARS
from rigs.protocol.bounds import require, require_all, require_count, require_frequency

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import Axis

Control: TypeAlias = Literal["strain", "displacement", "force"]
Channel: TypeAlias = Literal["force", "displacement"]
Side: TypeAlias = Literal[">", "<"]
GaugeLength: TypeAlias = Literal["here", "printed"]
"""What a zero takes as gauge length: the hook-to-hook length at that moment, or that of the printed specimen."""

MOST_STRAIN: Final = 5.0
"""Largest strain that can be asked for [1]."""

MOST_SHEAR: Final = 0.9
"""Largest shear strain of a periodic cell, either way [1]; images are looked for that strands may touch up to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StrainRate:
    """Rate of strain [1/s]."""

    value: float

    def __post_init__(self) -> None:
        fine = 0.0 < self.value <= 100.0
        require(fine, "rate", f"{self.value:g} /s", "a strain rate above 0 and up to 100 /s")


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceRate:
    """Rate of force [N/s]."""

    value: float

    def __post_init__(self) -> None:
        fine = 0.0 < self.value <= 1e4
        require(fine, "rate", f"{self.value:g} N/s", "a force rate above 0 and up to 10 kN/s")


Rate: TypeAlias = float | StrainRate | ForceRate
"""A bare number is a speed [m/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Target of an axis, counted from the last zero.

    Parameters
    ----------
    kind : {'strain', 'displacement', 'force'}
        A strain [1], a change of hook-to-hook length [m], or what its load cell shows [N].
    value : float
        Its value.
    """

    kind: Control
    value: float

    def __post_init__(self) -> None:
        require_level(self.kind, self.value, self.kind)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """Level with the side of it that counts: at or above ('>'), at or below ('<')."""

    side: Side
    value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Until:
    """Conditions that end a step before its target: the first that is met, at once if that is when the step begins.

    At least one must be given. A bare level is passed as the step goes: at or above it where the step pulls, at or
    below it where a ramp lets go, from whichever side in a hold.

    Parameters
    ----------
    force : float, Bound or None
        The load cell of an axis that the step drives shows this force [N].
    strain, displacement : float, Bound or None
        Such an axis has this strain [1] or displacement [m] since the last zero.
    time : float or None
        Time since the step began [s].
    drop : float or None
        Such an axis' force fell by this share [1] below its peak within the step.
    """

    force: float | Bound | None = None
    strain: float | Bound | None = None
    displacement: float | Bound | None = None
    time: float | None = None
    drop: float | None = None

    def __post_init__(self) -> None:
        given = [field.name for field in fields(self) if getattr(self, field.name) is not None]
        require(len(given) > 0, "until", "nothing", "one or more of force, strain, displacement, time and drop")
        kinds: tuple[Control, ...] = ("strain", "displacement", "force")
        levels = [(kind, level) for kind in kinds if (level := self.level(kind)) is not None]
        require_all(
            *(partial(require_level, kind, level, f"until.{kind}") for kind, level in levels),
            *(() if self.time is None else (partial(require_time, "until.time", self.time),)),
            *(() if self.drop is None else (partial(require_drop, "until.drop", self.drop),)),
        )

    def level(self, kind: Control) -> float | None:
        """Return the level of a kind, without its side."""
        given = getattr(self, kind)
        return given.value if isinstance(given, Bound) else given

    def side(self, kind: Control) -> Side | None:
        """Return the side that is said of a level."""
        given = getattr(self, kind)
        return given.side if isinstance(given, Bound) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class StepLog:
    """Logging of a step where it differs from the test.

    Parameters
    ----------
    rate, events : float or None
        Samples per second, and near events [Hz].
    every_cycle : int or None
        Of the cycles of a step `cycle` the first, the last and every n-th is kept [1].
    """

    rate: float | None = None
    events: float | None = None
    every_cycle: int | None = None

    def __post_init__(self) -> None:
        given = [field.name for field in fields(self) if getattr(self, field.name) is not None]
        require(len(given) > 0, "log", "nothing", "one or more of rate, events and, in a step cycle, every_cycle")
        require_all(
            lambda: require_frequency("log.rate", self.rate),
            lambda: require_frequency("log.events", self.events),
            lambda: require_count("log.every_cycle", self.every_cycle),
        )


def require_axes(axes: Sequence[str]) -> None:
    """Raise unless `axes` names each driven axis once."""
    fine = len(axes) > 0 and len(set(axes)) == len(axes) and set(axes) <= set(AXES)
    require(fine, "axes", list(axes), "one or more axes of the rig, each once")


def require_shear(axes: Sequence[str], kind: Control, level: float, name: str) -> None:
    """Raise if axes of shear are to go beyond the strain that a cell may be sheared by."""
    sheared = kind == "strain" and any(axis in SHEARS for axis in axes)
    bounds = f"a shear strain from -{MOST_SHEAR:g} to {MOST_SHEAR:g}"
    require(not sheared or abs(level) <= MOST_SHEAR, name, f"{level:g}", bounds)


def require_level(kind: Control, level: float, name: str) -> None:
    """Raise unless a strain leaves a specimen between the hooks [1], a length [m] and a force [N] are a rig's."""
    if kind == "strain":
        require(-0.9 <= level <= MOST_STRAIN, name, level, f"a strain from -0.9 to {MOST_STRAIN:g}")
    elif kind == "displacement":
        require(-10.0 <= level <= 10.0, name, f"{level:g} m", "a length from -10 m to 10 m")
    else:
        require(-1e4 <= level <= 1e4, name, f"{level:g} N", "a force from -10 kN to 10 kN")


def require_rate(rate: Rate, control: Control) -> None:
    """Raise unless a rate is one of what is controlled: a force in N/s, a displacement in m/s or 1/s."""
    if isinstance(rate, ForceRate):
        wanted = f"a speed or a strain rate, for {control} is controlled: such as 0.2 mm/s or 1e-3 /s"
        require(control == "force", "rate", f"{rate.value:g} N/s", wanted)
    elif isinstance(rate, StrainRate):
        wanted = "a force rate, for force is controlled: such as 0.1 N/s"
        require(control != "force", "rate", f"{rate.value:g} /s", wanted)
    else:
        wanted = "a force rate, for force is controlled: such as 0.1 N/s"
        require(control != "force", "rate", f"{rate:g} m/s", wanted)
        require(0.0 < rate <= 1.0, "rate", f"{rate:g} m/s", "a speed above 0 and up to 1 m/s")


def require_time(name: str, time: float) -> None:
    """Raise unless a time is one that a test can take [s]."""
    require(0.0 < time <= 1e7, name, f"{time:g} s", "a time above 0 and up to 1e7 s")


def require_drop(name: str, drop: float) -> None:
    """Raise unless a drop is a share of a peak [1]."""
    require(0.0 < drop <= 1.0, name, drop, "a share above 0 and up to 1, such as 60 %")


def require_controlled(control: Control | None, to: Target) -> None:
    """Raise unless what is controlled can end at a target."""
    if control is None or (control == "force") == (to.kind == "force"):
        return
    found = f"{to.kind} with control: {control}"
    stop = " (to stop at a force say until: {force: 1 N})" if to.kind == "force" else ""
    wanted = "force" if control == "force" else "a strain or a displacement"
    require(allowed=False, name="to", found=found, expected=f"{wanted}{stop}")


def require_room(axis: Axis, end: float, length: float) -> None:
    """Raise if a displacement [m] would drive hooks at a length [m] through each other, or shear a cell too far."""
    most, found = MOST_SHEAR * length, f"{end:g} m on axis {axis}"
    if axis in SHEARS:
        bounds = f"a displacement from {-most:g} m to {most:g} m"
        require(abs(end) <= most * (1.0 + 1e-9), "steps", found, bounds)
    else:
        require(end > -length, "steps", found, f"a displacement above {-length:g} m")

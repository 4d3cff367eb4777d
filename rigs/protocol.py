"""Say what a test is: specimen, steps, log; SI floats throughout.

These dataclasses are also the Python builder: every file is one of them, and back (`app.schemas`).
Only what the rig honours can be said; a value outside its range raises where it is said.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Stitch
from knitlab_core.materials import DEFAULT_FRICTION, material_named

if TYPE_CHECKING:
    from collections.abc import Sequence

# The pile axis P joins these with the triaxial rig.
Axis: TypeAlias = Literal["C", "W"]
Channel: TypeAlias = Literal["force", "displacement"]
AXES: tuple[Axis, ...] = ("C", "W")

MAX_STROKES = 100_000
MAX_STITCHES = 10_000
_LABEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,63}(?<! )")


def _require(allowed: bool, name: str, found: object, expected: str) -> None:  # noqa: FBT001 (reads as "require that")
    """Raise `SpecificationError` unless the condition holds."""
    if not allowed:
        raise SpecificationError(name, found, expected)


def _require_label(name: str, label: str | None) -> None:
    """Raise unless `label` may name files and columns."""
    fine = label is None or _LABEL.fullmatch(label) is not None
    _require(fine, name, label, "up to 64 letters, digits, spaces, '.', '_' and '-', the first a letter or digit")


def _require_axes(axes: Sequence[str]) -> None:
    """Raise unless `axes` names each driven axis once."""
    fine = len(axes) > 0 and len(set(axes)) == len(axes) and set(axes) <= set(AXES)
    _require(fine, "axes", list(axes), "one or more of C and W, each once")


def _require_speed(rate: float) -> None:
    """Raise unless `rate` is a speed a stage can have [m/s]."""
    _require(0.0 < rate <= 1.0, "rate", f"{rate:g} m/s", "a speed above 0 and up to 1 m/s")


def _require_strain(name: str, strain: float) -> None:
    """Raise unless `strain` leaves a specimen between the hooks [1]."""
    _require(-0.9 <= strain <= 5.0, name, strain, "a strain from -0.9 to 5")


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenSpec:
    """Name the knit on the rig.

    Parameters
    ----------
    knit : str or Stitch
        A named set of stitch values, or the values themselves [loop widths].
    rows, loops : int
        Rows, and loops in a row [1].
    loop_width : float
        Width of one loop, l [m].
    material : str
        Name in the catalogue of materials.
    friction : float
        Coulomb coefficient between strands [1].
    nodes_per_loop : int
        Nodes of the yarn in one loop [1].
    rest_shape : 'as-printed'
        Shape the yarn is at rest in; 'straight' joins it with machine-knitted cotton.
    """

    knit: str | Stitch
    rows: int
    loops: int
    loop_width: float
    material: str
    friction: float = DEFAULT_FRICTION.value
    nodes_per_loop: int = 48
    rest_shape: Literal["as-printed"] = "as-printed"

    def __post_init__(self) -> None:
        if isinstance(self.knit, str):
            names = ", ".join(NAMED_STITCHES)
            _require(self.knit in NAMED_STITCHES, "knit", self.knit, f"one of {names}, or a mapping of stitch values")
        for name, count in (("rows", self.rows), ("loops", self.loops)):
            _require(1 <= count <= 200, name, count, "a whole number from 1 to 200")
        count = self.rows * self.loops
        _require(count <= MAX_STITCHES, "loops", [self.rows, self.loops], f"{MAX_STITCHES} stitches or fewer")
        width = self.loop_width
        _require(1e-6 <= width <= 1.0, "loop_width", f"{width:g} m", "a length from 1 um to 1 m")
        material_named(self.material, "material")
        _require(0.0 <= self.friction <= 2.0, "friction", self.friction, "a coefficient from 0 to 2")
        _require(
            8 <= self.nodes_per_loop <= 1000, "nodes_per_loop", self.nodes_per_loop, "a whole number from 8 to 1000"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LogSpec:
    """Say how the instruments sample: rate [Hz], noise or none, and the noise's seed [1]."""

    rate: float = 10.0
    noise: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        _require(0.0 < self.rate <= 1e4, "rate", f"{self.rate:g} Hz", "a frequency above 0 and up to 10 kHz")
        _require(0 <= self.seed < 2**63, "seed", self.seed, "a whole number from 0 to 2^63 - 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Say where an axis goes: a strain [1], or a change of hook-to-hook length [m], since the last zero."""

    kind: Literal["strain", "displacement"]
    value: float

    def __post_init__(self) -> None:
        if self.kind == "strain":
            _require_strain("strain", self.value)
        else:
            _require(-10.0 <= self.value <= 10.0, "displacement", f"{self.value:g} m", "a length from -10 m to 10 m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Zero:
    """Tare the named channels where they stand."""

    channels: tuple[Channel, ...] = ("force", "displacement")

    def __post_init__(self) -> None:
        fine = len(self.channels) > 0 and len(set(self.channels)) == len(self.channels)
        _require(fine, "channels", list(self.channels), "one or both of force and displacement, each once")


@dataclass(frozen=True, slots=True, kw_only=True)
class Preload:
    """Draw the axes apart until each carries `force` [N], at `rate` [m/s]."""

    axes: tuple[Axis, ...]
    force: float
    rate: float
    tag: str | None = None

    def __post_init__(self) -> None:
        _require_axes(self.axes)
        _require(0.0 < self.force <= 1e4, "force", f"{self.force:g} N", "a force above 0 and up to 10 kN")
        _require_speed(self.rate)
        _require_label("tag", self.tag)


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
        _require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """Stand still for `duration` [s]."""

    duration: float
    tag: str | None = None

    def __post_init__(self) -> None:
        _require(0.0 < self.duration <= 1e7, "duration", f"{self.duration:g} s", "a time above 0 and up to 1e7 s")
        _require_label("tag", self.tag)


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
        _require(self.lower < self.upper, "upper", self.upper, f"a strain above lower ({self.lower:g})")
        _require_speed(self.rate)
        _require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        _require_label("tag", self.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """Do the steps `n` times over."""

    n: int
    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        _require(1 <= self.n <= 10_000, "n", self.n, "a whole number from 1 to 10000")
        _require(len(self.steps) > 0, "steps", [], "one step or more")


Step: TypeAlias = Zero | Preload | Ramp | Hold | Cycle | Repeat


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """Describe one test on one specimen.

    Parameters
    ----------
    specimen : SpecimenSpec
        What hangs on the hooks.
    speed_ref : {'pair', 'grip'}
        Whether a rate is that of the hook-to-hook length, or of one carriage (half of it).
    others : 'hold'
        What the axes do that a step does not name; 'free' and 'follow' need a force controller.
    steps : tuple of Step
        The steps, in order.
    log : LogSpec
        How the instruments sample.
    rig : 'biaxial-hook'
        The rig.
    hook : 'pin'
        How a hook holds its loop: 'pin' ties the nearest node of the yarn.
    name : str
        Name of the test; it names the files of its run.
    max_strain_increment : float
        Largest strain between two equilibria [1].
    """

    specimen: SpecimenSpec
    speed_ref: Literal["pair", "grip"]
    others: Literal["hold"]
    steps: tuple[Step, ...]
    log: LogSpec = field(default_factory=LogSpec)
    rig: Literal["biaxial-hook"] = "biaxial-hook"
    hook: Literal["pin"] = "pin"
    name: str = "test"
    max_strain_increment: float = 0.0125

    def __post_init__(self) -> None:
        _require(len(self.steps) > 0, "steps", [], "one step or more")
        count = stroke_count(self.steps)
        _require(count <= MAX_STROKES, "steps", f"{count} strokes", f"{MAX_STROKES} strokes or fewer")
        _require_label("name", self.name)
        increment = self.max_strain_increment
        _require(1e-5 <= increment <= 0.1, "max_strain_increment", increment, "a strain from 1e-5 to 0.1")


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

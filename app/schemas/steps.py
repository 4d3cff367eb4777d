"""Steps of a protocol in its YAML: for each its model and its conversion, and one entry in the registry `ENTRIES`.

A file has a list of mappings of one key, which is the name of the step.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias, Union

from pydantic import Discriminator, Field, Tag, create_model

from app.schemas.base import BRANCH, Model
from app.schemas.step_parts import (
    AXES,
    CONTROL,
    COUNT,
    DROP,
    LOG,
    TAG,
    TARGET,
    UNTIL,
    CycleLogModel,
    StepContext,
    StepLogModel,
    TargetModel,
    UntilModel,
    common,
    driven,
    given,
    level,
    target,
    written_common,
    written_level,
    written_rate,
    written_target,
    written_time,
)
from app.schemas.units import allowed, write
from app.schemas.values import EVERY, LEVEL, RATE, AnyRate, Every, Force, Label, Level, Strain, Time
from app.schemas.waveform import WaveformModel, to_waveform, written_waveform
from rigs.axes import Axis
from rigs.protocol.step import Step, step_name
from rigs.protocol.steps import (
    RUPTURE_DROP,
    Cycle,
    Hold,
    Image,
    Preload,
    Ramp,
    Repeat,
    UntilRupture,
    Zero,
)
from rigs.protocol.targets import Channel, Control, GaugeLength


class ZeroModel(Model):
    """Tare channels."""

    channels: list[Channel] = Field(description="a list of channels, such as [force, displacement]")
    gauge_length: GaugeLength | None = Field(
        default=None,
        description="here, the hook-to-hook distance at this moment, or printed; without it the gauge length stays",
    )


def _zero(body: ZeroModel, _: StepContext) -> Zero:
    return Zero(channels=tuple(body.channels), gauge_length=body.gauge_length)


def _written_zero(step: Zero) -> dict[str, Any]:
    return {"channels": list(step.channels), **given(gauge_length=step.gauge_length)}


class PreloadModel(Model):
    """Load axes until they carry a force."""

    axes: list[Axis] = Field(description=AXES)
    force: Force = Field(description=allowed("force"))
    rate: AnyRate = Field(description=RATE)
    control: Control | None = Field(default=None, description=CONTROL)
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: StepLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG


def _preload(body: PreloadModel, context: StepContext) -> Preload:
    return Preload(force=body.force, **driven(body, context))


def _written_preload(step: Preload) -> dict[str, Any]:
    own = {"axes": list(step.axes), "force": write(step.force, "force"), "rate": written_rate(step.rate)}
    return {**own, **given(control=step.control), **written_common(step)}


class RampModel(Model):
    """Drive axes to a target."""

    axes: list[Axis] = Field(description=AXES)
    to: TargetModel = Field(description=TARGET)
    rate: AnyRate = Field(description=RATE)
    control: Control | None = Field(default=None, description=CONTROL)
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: StepLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG


def _ramp(body: RampModel, context: StepContext) -> Ramp:
    return Ramp(to=target(body.to, context), **driven(body, context))


def _written_ramp(step: Ramp) -> dict[str, Any]:
    own = {"axes": list(step.axes), "to": written_target(step.to), "rate": written_rate(step.rate)}
    return {**own, **given(control=step.control), **written_common(step)}


class HoldModel(Model):
    """Keep displacements, or forces."""

    duration: Time = Field(alias="for", description=allowed("time"))
    axes: list[Axis] | None = Field(default=None, description=AXES)
    control: Control | None = Field(default=None, description=CONTROL)
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: StepLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG


def _hold(body: HoldModel, context: StepContext) -> Hold:
    held: dict[str, Any] = {"axes": tuple(body.axes or ()), "control": body.control}
    return Hold(duration=body.duration, **held, **common(body, context))


def _written_hold(step: Hold) -> dict[str, Any]:
    own = given(axes=list(step.axes) or None, **{"for": written_time(step.duration)}, control=step.control)
    return {**own, **written_common(step)}


class CycleModel(Model):
    """Drive axes to and fro."""

    axes: list[Axis] = Field(description=AXES)
    lower: Level = Field(description=LEVEL)
    upper: Level = Field(description=LEVEL)
    rate: AnyRate = Field(description=RATE)
    n: int = Field(description=COUNT)
    control: Control = Field(default="strain", description=CONTROL)
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: CycleLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG


def _end(body: CycleModel, name: str) -> float:
    return level(getattr(body, name), body.control, name)


def _cycle(body: CycleModel, context: StepContext) -> Cycle:
    lower, upper = (context.faults.of(partial(_end, body, name), None) for name in ("lower", "upper"))
    # An end that is refused is replaced by one that is not.
    ends = (0.0, 1.0) if lower is None or upper is None else (lower, upper)
    return Cycle(lower=ends[0], upper=ends[1], n=body.n, **driven(body, context))


def _written_cycle(step: Cycle) -> dict[str, Any]:
    ends = {name: written_level(step.control, getattr(step, name)) for name in ("lower", "upper")}
    own = {"axes": list(step.axes), **ends, "rate": written_rate(step.rate), "n": step.n, "control": step.control}
    return {**own, **written_common(step)}


class RepeatModel(Model):
    """Do steps over."""

    n: int = Field(description=COUNT)
    steps: list["StepModel"] = Field(description="a list of steps")


def _repeat(body: RepeatModel, context: StepContext) -> Repeat:
    return Repeat(n=body.n, steps=context.steps(body.steps))


def _written_repeat(step: Repeat) -> dict[str, Any]:
    return {"n": step.n, "steps": [written_step(inner) for inner in step.steps]}


class UntilRuptureModel(Model):
    """Drive axes on until the force drops or the specimen tears.

    A drop is a rupture where something broke since the peak, and a slip where nothing did.
    """

    axes: list[Axis] = Field(description=AXES)
    rate: AnyRate = Field(description=RATE)
    drop: Strain = Field(default=RUPTURE_DROP, description=DROP)
    to: TargetModel | None = Field(default=None, description="a ceiling, such as 120 %, or {strain: 1.2}")
    control: Control | None = Field(default=None, description="strain or displacement")
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: StepLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG


def _until_rupture(body: UntilRuptureModel, context: StepContext) -> UntilRupture:
    to = None if body.to is None else target(body.to, context)
    return UntilRupture(drop=body.drop, to=to, **driven(body, context))


def _written_until_rupture(step: UntilRupture) -> dict[str, Any]:
    own = given(axes=list(step.axes), to=written_target(step.to), rate=written_rate(step.rate), drop=step.drop)
    return {**own, **given(control=step.control), **written_common(step)}


class ImageModel(Model):
    """Take pictures."""

    every: Every | None = Field(default=None, description=EVERY)
    tag: Label | None = TAG


def _image(body: ImageModel, _: StepContext) -> Image:
    return Image(every=body.every, tag=body.tag)


def _written_image(step: Image) -> dict[str, Any]:
    every = step.every if step.every is None or step.every == "off" else written_time(step.every)
    return given(every=every, tag=step.tag)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepEntry:
    """A step of the protocol language.

    Attributes
    ----------
    model : type of Model
        The mapping under its name in a file.
    make : Callable
        Conversion of the model to the domain's step.
    write : Callable
        The inverse: the mapping of a step as the data of a file.
    """

    model: type[Model]
    make: Callable[[Any, StepContext], Step | Repeat]
    write: Callable[[Any], dict[str, Any]]


ENTRIES: Final[Mapping[str, StepEntry]] = MappingProxyType(
    {
        "zero": StepEntry(model=ZeroModel, make=_zero, write=_written_zero),
        "preload": StepEntry(model=PreloadModel, make=_preload, write=_written_preload),
        "ramp": StepEntry(model=RampModel, make=_ramp, write=_written_ramp),
        "hold": StepEntry(model=HoldModel, make=_hold, write=_written_hold),
        "cycle": StepEntry(model=CycleModel, make=_cycle, write=_written_cycle),
        "waveform": StepEntry(model=WaveformModel, make=to_waveform, write=written_waveform),
        "repeat": StepEntry(model=RepeatModel, make=_repeat, write=_written_repeat),
        "until_rupture": StepEntry(model=UntilRuptureModel, make=_until_rupture, write=_written_until_rupture),
        "image": StepEntry(model=ImageModel, make=_image, write=_written_image),
    }
)
"""The steps by the name that a file has for them, which is that of their class (`step_name`)."""

STEPS: Final = tuple(ENTRIES)


def written_step(step: Step | Repeat) -> dict[str, Any]:
    """Return one step as the data of a file."""
    name = step_name(step)
    return {name: ENTRIES[name].write(step)}


def _step_branch(value: Any) -> str | None:  # noqa: ANN401 (whatever a file holds)
    """Return the branch of a step: its one key."""
    if isinstance(value, dict) and len(value) == 1:
        return f"{BRANCH}{next(iter(value))}"
    return None


def _keyed(name: str, model: type[Model]) -> Any:  # noqa: ANN401 (a type made here)
    """Return the branch of the union for a step: a mapping of its name alone to its model."""
    stem = model.__name__.removesuffix("Model")
    field: dict[str, Any] = {name: (model, Field(title=(model.__doc__ or "").partition("\n")[0].rstrip(".")))}
    keyed = create_model(f"{stem}Step", __base__=Model, __doc__=f"Be the step `{name}`.", **field)
    return Annotated[keyed, Tag(f"{BRANCH}{name}")]


if TYPE_CHECKING:
    StepModel: TypeAlias = Model
else:
    StepModel = Annotated[
        Union[tuple(_keyed(name, entry.model) for name, entry in ENTRIES.items())],  # noqa: UP007 (made of a tuple)
        Discriminator(_step_branch),
    ]

STEP_MODELS: Final[Mapping[str, type[Model]]] = MappingProxyType(
    {"to": TargetModel, "until": UntilModel, **{name: entry.model for name, entry in ENTRIES.items()}}
)
"""The model of a mapping in a step, by its key: what errors name of missing and unknown fields."""

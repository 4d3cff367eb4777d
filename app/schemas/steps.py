"""Describe the steps of a protocol in its YAML: a union told apart by the one key of each."""

from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Annotated, Any, Final

from pydantic import Discriminator, Field, GetJsonSchemaHandler, Tag, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from app.schemas.base import BRANCH, Model
from app.schemas.units import Dimension, allowed, parse
from app.schemas.values import (
    EVERY,
    LEVEL,
    RATE,
    AnyRate,
    Every,
    Force,
    ForceBound,
    Frequency,
    Label,
    Length,
    LengthBound,
    Level,
    Strain,
    StrainBound,
    Time,
    bounds,
    refuse,
)
from knitlab_core.errors import UnitError
from rigs.axes import Axis
from rigs.protocol.steps import RUPTURE_DROP, Channel, Control

_AXES: Final = "a list of axes, such as [C, W]"
_COUNT: Final = "a whole number from 1"
_DROP: Final = "a share of the peak, such as 60 %"
_CONTROL: Final = "strain, displacement or force: what follows its course at the rate"
_UNTIL: Final = (
    "a mapping of what ends the step early, such as {force: 2 N}, {force: '< 0.1 N'}, {time: 20 s} or {drop: 60 %}"
)
EVENTS: Final = f"the rate near jumps of the specimen, {allowed('frequency')}"
EVERY_CYCLE: Final = "a whole number n from 1: the first, the last and every n-th cycle of a step cycle is logged"
_LOG: Final = "a mapping of how the step is logged, such as {rate: 1 Hz} or {rate: 1 Hz, events: 100 Hz}"
TARGET: Final = "a target, such as 40 %, 10 mm or 2 N, or {strain: 0.4}, {displacement: 10 mm} or {force: 2 N}"
TARGETS: Final[Mapping[str, Dimension]] = MappingProxyType(
    {"strain": "strain", "displacement": "length", "force": "force"}
)
_TAG: Final = Field(default=None, description="a text or a number that names the step in the log")


class ZeroModel(Model):
    """Tare channels."""

    channels: list[Channel] = Field(description="a list of channels, such as [force, displacement]")


class UntilModel(Model):
    """Say what ends a step before its target; what is met first does, at once if it is met when the step begins.

    A level without a side is passed as the step goes: at or above it where the step pulls, at or below it where a ramp
    lets go, from whichever side in a hold.
    """

    force: ForceBound | None = Field(default=None, description=bounds("force"))
    strain: StrainBound | None = Field(default=None, description=bounds("strain"))
    displacement: LengthBound | None = Field(default=None, description=bounds("length"))
    time: Time | None = Field(default=None, description=allowed("time"))
    drop: Strain | None = Field(default=None, description=_DROP)


class StepLogModel(Model):
    """Say how a step is logged where it differs from the test."""

    rate: Frequency | None = Field(default=None, description=allowed("frequency"))
    events: Frequency | None = Field(default=None, description=EVENTS)


class CycleLogModel(StepLogModel):
    """Say also which of its cycles are."""

    every_cycle: int | None = Field(default=None, description=EVERY_CYCLE)


class TargetModel(Model):
    """Say where axes go: one of a strain, a displacement and a force."""

    strain: Strain | None = Field(default=None, description=allowed("strain"))
    displacement: Length | None = Field(default=None, description=allowed("length"))
    force: Force | None = Field(default=None, description=allowed("force"))

    @model_validator(mode="before")
    @classmethod
    def by_its_unit(cls, value: Any) -> Any:  # noqa: ANN401 (whatever a file holds)
        """Take a level alone as the target that its unit makes it: 10 %, 8 mm or 2 N."""
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            return value
        for name, dimension in TARGETS.items():
            with suppress(UnitError):
                parse(value, dimension)
                return {name: value}
        raise refuse(TARGET)

    @model_validator(mode="after")
    def one_of_them(self) -> "TargetModel":
        """Refuse none and several."""
        if sum(one is not None for one in (self.strain, self.displacement, self.force)) != 1:
            raise refuse("one of strain, displacement and force, such as {strain: 0.4}")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Say in the published schema that a level alone is a target too."""
        mapping = handler.resolve_ref_schema(handler(schema))
        return {"anyOf": [mapping, {"type": ["number", "string"], "description": TARGET}]}


class PreloadModel(Model):
    """Load axes until they carry a force."""

    axes: list[Axis] = Field(description=_AXES)
    force: Force = Field(description=allowed("force"))
    rate: AnyRate = Field(description=RATE)
    control: Control | None = Field(default=None, description=_CONTROL)
    until: UntilModel | None = Field(default=None, description=_UNTIL)
    log: StepLogModel | None = Field(default=None, description=_LOG)
    tag: Label | None = _TAG


class RampModel(Model):
    """Drive axes to a target."""

    axes: list[Axis] = Field(description=_AXES)
    to: TargetModel = Field(description=TARGET)
    rate: AnyRate = Field(description=RATE)
    control: Control | None = Field(default=None, description=_CONTROL)
    until: UntilModel | None = Field(default=None, description=_UNTIL)
    log: StepLogModel | None = Field(default=None, description=_LOG)
    tag: Label | None = _TAG


class HoldModel(Model):
    """Stand still, or keep forces."""

    duration: Time = Field(alias="for", description=allowed("time"))
    axes: list[Axis] | None = Field(default=None, description=_AXES)
    control: Control | None = Field(default=None, description=_CONTROL)
    until: UntilModel | None = Field(default=None, description=_UNTIL)
    log: StepLogModel | None = Field(default=None, description=_LOG)
    tag: Label | None = _TAG


class CycleModel(Model):
    """Drive axes to and fro."""

    axes: list[Axis] = Field(description=_AXES)
    lower: Level = Field(description=LEVEL)
    upper: Level = Field(description=LEVEL)
    rate: AnyRate = Field(description=RATE)
    n: int = Field(description=_COUNT)
    control: Control = Field(default="strain", description=_CONTROL)
    until: UntilModel | None = Field(default=None, description=_UNTIL)
    log: CycleLogModel | None = Field(default=None, description=_LOG)
    tag: Label | None = _TAG


class UntilRuptureModel(Model):
    """Drive axes on until the force drops or the specimen tears.

    A drop is a rupture where something broke since the peak, and a slip where nothing did.
    """

    axes: list[Axis] = Field(description=_AXES)
    rate: AnyRate = Field(description=RATE)
    drop: Strain = Field(default=RUPTURE_DROP, description=_DROP)
    to: TargetModel | None = Field(default=None, description="a ceiling, such as 120 %, or {strain: 1.2}")
    control: Control | None = Field(default=None, description="strain or displacement")
    until: UntilModel | None = Field(default=None, description=_UNTIL)
    log: StepLogModel | None = Field(default=None, description=_LOG)
    tag: Label | None = _TAG


class ImageModel(Model):
    """Take pictures."""

    every: Every | None = Field(default=None, description=EVERY)
    tag: Label | None = _TAG


class ZeroStep(Model):
    """Be the step `zero`."""

    zero: ZeroModel


class PreloadStep(Model):
    """Be the step `preload`."""

    preload: PreloadModel


class RampStep(Model):
    """Be the step `ramp`."""

    ramp: RampModel


class HoldStep(Model):
    """Be the step `hold`."""

    hold: HoldModel


class CycleStep(Model):
    """Be the step `cycle`."""

    cycle: CycleModel


class RepeatStep(Model):
    """Be the step `repeat`."""

    repeat: "RepeatModel"


class UntilRuptureStep(Model):
    """Be the step `until_rupture`."""

    until_rupture: UntilRuptureModel


class ImageStep(Model):
    """Be the step `image`."""

    image: ImageModel


def _step_branch(value: Any) -> str | None:  # noqa: ANN401 (whatever a file holds)
    """Return the branch of a step: its one key."""
    if isinstance(value, dict) and len(value) == 1:
        return f"{BRANCH}{next(iter(value))}"
    return None


StepModel = Annotated[
    Annotated[ZeroStep, Tag(f"{BRANCH}zero")]
    | Annotated[PreloadStep, Tag(f"{BRANCH}preload")]
    | Annotated[RampStep, Tag(f"{BRANCH}ramp")]
    | Annotated[HoldStep, Tag(f"{BRANCH}hold")]
    | Annotated[CycleStep, Tag(f"{BRANCH}cycle")]
    | Annotated[RepeatStep, Tag(f"{BRANCH}repeat")]
    | Annotated[UntilRuptureStep, Tag(f"{BRANCH}until_rupture")]
    | Annotated[ImageStep, Tag(f"{BRANCH}image")],
    Discriminator(_step_branch),
]


class RepeatModel(Model):
    """Do steps over."""

    n: int = Field(description=_COUNT)
    steps: list[StepModel] = Field(description="a list of steps")


STEP_MODELS: Final[Mapping[str, type[Model]]] = MappingProxyType(
    {
        "to": TargetModel,
        "until": UntilModel,
        "zero": ZeroModel,
        "preload": PreloadModel,
        "ramp": RampModel,
        "hold": HoldModel,
        "cycle": CycleModel,
        "repeat": RepeatModel,
        "until_rupture": UntilRuptureModel,
        "image": ImageModel,
    }
)
"""The model of a mapping in a step, by the key it stands under: what errors say of missing and unknown fields."""

STEPS: Final = ("zero", "preload", "ramp", "hold", "cycle", "repeat", "until_rupture", "image")

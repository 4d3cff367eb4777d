"""Describe the YAML of a protocol: its fields, their types and, as descriptions, what each allows.

Ranges are the business of `rigs.protocol`; here stand structure and units alone.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from app.schemas.values import Force, Frequency, Length, Speed, StitchValue, Strain, Switch, Time, refuse
from app.units import allowed
from rigs.catalogue import RigName, Sides
from rigs.steps import Axis, Channel

SCHEMA: Final = "knitlab/protocol@1"

# In the design of the protocol language, but not yet honoured by a rig.
NOT_YET: Final = frozenset(
    {"sweep", "control", "until", "force", "until_rupture", "image", "follow", "wire", "straight"}
    | {"triaxial", "microgripper"}
)
# Marks the branches of a union in pydantic's locations, so that they can be told from fields.
BRANCH: Final = "|"


class Model(BaseModel):
    """Refuse unknown fields and silent conversions."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


_AXES = Field(description="a list of axes, such as [C, W]")
_SPEED = Field(description=allowed("speed"))
_STRAIN = Field(description=allowed("strain"))
_COUNT = Field(description="a whole number from 1")
_TAG = Field(default=None, description="a short text")
_STITCH = Field(description="a number of loop widths, or a length with its unit, such as 0.4 mm")


class StitchModel(Model):
    """Give the values of a stitch."""

    curvature: StitchValue = Field(description="a pure number, such as 1.5")
    height: StitchValue = _STITCH
    depth: StitchValue = _STITCH
    row_spacing: StitchValue = _STITCH
    fibre_radius: StitchValue = _STITCH


class VolumetricStitchModel(Model):
    """Give the values of a volumetric stitch."""

    curvature: StitchValue = Field(description="a pure number, such as 1.5")
    wale_height: StitchValue = _STITCH
    pile_height: StitchValue = _STITCH
    depth: StitchValue = _STITCH
    row_spacing: StitchValue = _STITCH
    layer_spacing: StitchValue = _STITCH
    fibre_radius: StitchValue = _STITCH


VOLUMETRIC: Final = f"{BRANCH}volumetric"


def _knit_branch(value: object) -> str:
    """Tell a name, the values of a stitch and those of a volumetric one apart."""
    if not isinstance(value, dict):
        return f"{BRANCH}name"
    only_there = set(VolumetricStitchModel.model_fields) - set(StitchModel.model_fields)
    return VOLUMETRIC if only_there & set(value) else f"{BRANCH}values"


class SpecimenModel(Model):
    """Name the knit on the rig."""

    knit: Annotated[
        Annotated[str, Tag(f"{BRANCH}name")]
        | Annotated[StitchModel, Tag(f"{BRANCH}values")]
        | Annotated[VolumetricStitchModel, Tag(VOLUMETRIC)],
        Discriminator(_knit_branch),
    ] = Field(description="the name of a knit, such as stockinette-default, or a mapping of stitch values")
    loops: list[int] = Field(
        min_length=2,
        max_length=3,
        description="[rows, loops in a row], such as [6, 6], and of a volumetric knit the layers, such as [6, 6, 6]",
    )
    loop: Length = Field(description=allowed("length"))
    material: str = Field(description="the name of a material, such as RGD8530-DM")
    friction: float | None = Field(default=None, description="a coefficient of friction, such as 0.3")
    hook: Literal["pin"] = Field(default="pin", description="pin")
    nodes_per_loop: int = Field(default=48, description="a whole number, such as 48")
    rest_shape: Literal["as-printed"] = Field(default="as-printed", description="as-printed")


class LogModel(Model):
    """Say how the instruments sample."""

    rate: Frequency = Field(default=10.0, description=allowed("frequency"))
    noise: Switch = Field(default=True, description="on or off")
    seed: int = Field(default=0, description="a whole number from 0")


class ZeroModel(Model):
    """Tare channels."""

    channels: list[Channel] = Field(description="a list of channels, such as [force, displacement]")


class PreloadModel(Model):
    """Draw axes apart until they carry a force."""

    axes: list[Axis] = _AXES
    force: Force = Field(description=allowed("force"))
    rate: Speed = _SPEED
    tag: str | None = _TAG


class TargetModel(Model):
    """Say where a ramp goes: one of a strain and a displacement."""

    strain: Strain | None = Field(default=None, description=allowed("strain"))
    displacement: Length | None = Field(default=None, description=allowed("length"))

    @model_validator(mode="after")
    def one_of_them(self) -> "TargetModel":
        """Refuse none and both."""
        if (self.strain is None) == (self.displacement is None):
            raise refuse("either a strain or a displacement, such as {strain: 0.4}")
        return self


class RampModel(Model):
    """Drive axes to a target."""

    axes: list[Axis] = _AXES
    to: TargetModel = Field(description="a target, such as {strain: 0.4} or {displacement: 10 mm}")
    rate: Speed = _SPEED
    tag: str | None = _TAG


class HoldModel(Model):
    """Stand still."""

    duration: Time = Field(alias="for", description=allowed("time"))
    tag: str | None = _TAG


class CycleModel(Model):
    """Drive axes to and fro."""

    axes: list[Axis] = _AXES
    lower: Strain = _STRAIN
    upper: Strain = _STRAIN
    rate: Speed = _SPEED
    n: int = _COUNT
    tag: str | None = _TAG


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
    | Annotated[RepeatStep, Tag(f"{BRANCH}repeat")],
    Discriminator(_step_branch),
]


class RepeatModel(Model):
    """Do steps over."""

    n: int = _COUNT
    steps: list[StepModel] = Field(description="a list of steps")


class ProtocolModel(Model):
    """A knitlab protocol: one test on one specimen."""

    schema_id: Literal["knitlab/protocol@1"] = Field(alias="schema", description=SCHEMA)
    name: str | None = Field(default=None, description="a short text")
    rig: RigName = Field(description="biaxial-hook or uniaxial-frame")
    mount: Axis | None = Field(default=None, description="C, W or P, the axis that stands along the frame")
    specimen: SpecimenModel = Field(description="a mapping that names the specimen")
    speed_ref: Literal["pair", "grip"] = Field(description="pair or grip")
    others: Sides = Field(description="hold on biaxial-hook, free on uniaxial-frame")
    log: LogModel = Field(default=LogModel(), description="a mapping such as {rate: 10 Hz, noise: on, seed: 0}")
    params: dict[str, str | int | float | bool] = Field(
        default={}, description="a mapping of names to values, used as ${name}"
    )
    max_strain_increment: Strain = Field(default=0.0125, description=allowed("strain"))
    steps: list[StepModel] = Field(description="a list of steps")


# The model of a mapping, by the key it stands under: what errors say of missing and unknown fields.
MODELS: Final[Mapping[str, type[Model]]] = MappingProxyType(
    {
        "": ProtocolModel,
        "specimen": SpecimenModel,
        "knit": StitchModel,
        "log": LogModel,
        "to": TargetModel,
        "zero": ZeroModel,
        "preload": PreloadModel,
        "ramp": RampModel,
        "hold": HoldModel,
        "cycle": CycleModel,
        "repeat": RepeatModel,
    }
)
STEPS: Final = ("zero", "preload", "ramp", "hold", "cycle", "repeat")

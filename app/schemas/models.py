"""Describe the YAML of a protocol: its fields, their types and, as descriptions, what each allows.

Ranges are the business of `rigs.protocol`; here stand structure and units alone.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from app.schemas.base import BRANCH, Model
from app.schemas.materials import MaterialModel
from app.schemas.specimen import FusedModel, SpecimenModel, StitchModel, YarnModel
from app.schemas.values import Force, Frequency, Length, Speed, Strain, Switch, Time, refuse
from app.units import allowed
from rigs.catalogue import RigName, Sides
from rigs.steps import Axis, Channel

SCHEMA: Final = "knitlab/protocol@1"

# In the design of the protocol language, but not yet honoured by a rig.
NOT_YET: Final = frozenset(
    {"sweep", "control", "until", "force", "until_rupture", "image", "follow"} | {"triaxial", "microgripper"}
)
_AXES = Field(description="a list of axes, such as [C, W]")
_SPEED = Field(description=allowed("speed"))
_STRAIN = Field(description=allowed("strain"))
_COUNT = Field(description="a whole number from 1")
_TAG = Field(default=None, description="a short text")


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


def _materials_branch(value: object) -> str:
    """Tell a file and materials that stand here apart."""
    return f"{BRANCH}here" if isinstance(value, dict) else f"{BRANCH}file"


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
    materials: Annotated[
        Annotated[str, Tag(f"{BRANCH}file")] | Annotated[dict[str, MaterialModel], Tag(f"{BRANCH}here")],
        Discriminator(_materials_branch),
    ] = Field(default={}, description="a YAML file of materials beside the protocol, such as my-resins.yaml")
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
        "yarn": YarnModel,
        "fused": FusedModel,
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

"""Pydantic models of a protocol file: fields, types, and descriptions of what each allows.

Ranges are checked in `rigs.protocol.protocol`; here are structure and units.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Final, Literal

from pydantic import Discriminator, Field, Tag

from app.schemas.base import BRANCH, Model
from app.schemas.material_models import AnyMaterial
from app.schemas.sampling import SampleModel
from app.schemas.specimen import EdgesModel, FusedModel, GripsModel, SpecimenModel, StitchModel, YarnModel
from app.schemas.step_parts import EVENTS, EVERY_CYCLE
from app.schemas.steps import STEP_MODELS, StepModel
from app.schemas.units import allowed
from app.schemas.values import AnyRig, Force, Frequency, Label, Strain, Switch, Time
from rigs.axes import Axis
from rigs.protocol.catalogue import Others

SCHEMA: Final = "knitlab/protocol@1"


PAIR: Final = "a list of two stitches, rows or layers, counted from 0, such as [1, 4]"

# Part of the protocol language, but not supported by a rig.
NOT_YET: Final[frozenset[str]] = frozenset()


class ExtensometerModel(Model):
    """Pins in stitches, a pair along each axis that is measured; stitches are counted from 0."""

    course: list[int] | None = Field(default=None, min_length=2, max_length=2, description=PAIR)
    wale: list[int] | None = Field(default=None, min_length=2, max_length=2, description=PAIR)
    pile: list[int] | None = Field(default=None, min_length=2, max_length=2, description=PAIR)


class LogModel(Model):
    """How the instruments sample."""

    rate: Frequency = Field(default=10.0, description=allowed("frequency"))
    events: Frequency | None = Field(default=None, description=EVENTS)
    every_cycle: int = Field(default=1, description=EVERY_CYCLE)
    noise: Switch = Field(default=True, description="on or off")
    seed: int = Field(default=0, description="a whole number from 0")
    clock_offset: Time | None = Field(default=None, description=allowed("time"))
    clock_skew: float | None = Field(default=None, description="a number such as 2e-5")


def _extensometer_branch(value: object) -> str:
    """Return the branch of the union: on or off, or pins in chosen stitches."""
    return f"{BRANCH}pins" if isinstance(value, dict) else f"{BRANCH}switch"


def _materials_branch(value: object) -> str:
    """Return the branch of the union: the name of a materials file, or materials defined in the protocol."""
    return f"{BRANCH}here" if isinstance(value, dict) else f"{BRANCH}file"


class ProtocolModel(Model):
    """A knitlab protocol: one test on one specimen."""

    schema_id: Literal["knitlab/protocol@1"] = Field(alias="schema", description=SCHEMA)
    name: Label | None = Field(
        default=None, description="a text or a number that names the test; without it the name of its file"
    )
    rig: AnyRig = Field(
        description="biaxial-hook, uniaxial-frame, triaxial or sem-microgripper; of shear biaxial-shear, "
        "shear-frame or triaxial-shear"
    )
    mount: Axis | None = Field(
        default=None, description="C, W or P, the axis that stands along the frame; on shear-frame WC, PC or PW"
    )
    specimen: SpecimenModel = Field(description="a mapping that names the specimen")
    speed_ref: Literal["pair", "grip"] = Field(
        default="pair", description="pair, the speed of the hook-to-hook length, or grip, that of one carriage"
    )
    load_cell: Force | None = Field(default=None, description="a load cell of the frame: 500 N, 1 kN or 2 kN")
    others: Others | None = Field(
        default=None,
        description="hold, free or, without shear, follow; where sides are free it is free, which need not be said",
    )
    log: LogModel = Field(default=LogModel(), description="a mapping such as {rate: 10 Hz, noise: on, seed: 0}")
    extensometer: Annotated[
        Annotated[Switch, Tag(f"{BRANCH}switch")] | Annotated[ExtensometerModel, Tag(f"{BRANCH}pins")],
        Discriminator(_extensometer_branch),
    ] = Field(
        default=False,
        description="on, off, or a mapping of the stitches that hold its pins, such as {course: [1, 4]}",
    )
    materials: Annotated[
        Annotated[str, Tag(f"{BRANCH}file")] | Annotated[dict[str, AnyMaterial], Tag(f"{BRANCH}here")],
        Discriminator(_materials_branch),
    ] = Field(default={}, description="a YAML file of materials beside the protocol, such as my-resins.yaml")
    params: dict[str, str | int | float | bool] = Field(
        default={}, description="a mapping of names to values, used as ${name}"
    )
    sweep: dict[str, list[str | int | float | bool]] = Field(
        default={}, description="a mapping of names under params to lists of values, such as {pre: [0, 0.1]}"
    )
    sample: SampleModel | None = Field(
        default=None, description="a design such as {points: 24, of: {h: [0.7, 0.9], loop: [6 mm, 12 mm]}}"
    )
    max_strain_increment: Strain = Field(default=0.0125, description=allowed("strain"))
    steps: list[StepModel] = Field(description="a list of steps")


# The model of a mapping, by its key: what errors name of missing and unknown fields.
MODELS: Final[Mapping[str, type[Model]]] = MappingProxyType(
    {
        "": ProtocolModel,
        "specimen": SpecimenModel,
        "knit": StitchModel,
        "yarn": YarnModel,
        "fused": FusedModel,
        "edges": EdgesModel,
        "grips": GripsModel,
        "log": LogModel,
        "extensometer": ExtensometerModel,
        "sample": SampleModel,
        **STEP_MODELS,
    }
)

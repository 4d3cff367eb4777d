"""Pydantic models of a user's materials file: structure, units and what each field allows."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Discriminator, Field, Tag

from app.schemas.base import BRANCH, Model
from app.schemas.units import allowed
from app.schemas.values import Density, Strain, Stress, Time  # noqa: TC001 (pydantic reads them)
from app.schemas.yarns import ASSUMED, SOURCE, Source, SourcedYarnModel, is_measured

SCHEMA: Final = "knitlab/materials@1"
SOLID: Final = f"{BRANCH}solid"
YARN: Final = f"{BRANCH}yarn"


class StressValue(Model):
    """A stress and its source."""

    value: Stress = Field(description=allowed("stress"))
    source: Source = SOURCE
    assumed: bool = ASSUMED


class DensityValue(Model):
    """A density and its source."""

    value: Density = Field(description=allowed("density"))
    source: Source = SOURCE
    assumed: bool = ASSUMED


class StrainValue(Model):
    """A strain and its source."""

    value: Strain = Field(description=allowed("strain"))
    source: Source = SOURCE
    assumed: bool = ASSUMED


class NumberValue(Model):
    """A pure number and its source."""

    value: float = Field(description="a pure number, such as 0.37")
    source: Source = SOURCE
    assumed: bool = ASSUMED


class TermModel(Model):
    """One term of a Prony series."""

    share: Strain = Field(description="a share of the stiffness above 0 and below 1, such as 0.2 or 20 %")
    time: Time = Field(description=allowed("time"))


class RelaxationModel(Model):
    """A Prony series and its source."""

    terms: list[TermModel] = Field(min_length=1, description="a list of terms, such as [{share: 0.2, time: 10 s}]")
    source: Source = SOURCE
    assumed: bool = ASSUMED


class PointModel(Model):
    """One point of a curve of stress over strain."""

    strain: Strain = Field(description=allowed("strain"))
    stress: Stress = Field(description=allowed("stress"))


class CurveModel(Model):
    """A curve of stress over strain and its source."""

    points: list[PointModel] = Field(
        min_length=1,
        description="a list of points, such as [{strain: 2 %, stress: 40 MPa}], the first where yield begins",
    )
    source: Source = SOURCE
    assumed: bool = ASSUMED


class MaterialModel(Model):
    """A material."""

    young_modulus: StressValue = Field(description="a mapping such as {value: 2.0 GPa, source: ...}")
    poisson_ratio: NumberValue = Field(description="a mapping such as {value: 0.37, source: ...}")
    strength: StressValue | None = Field(default=None, description="a mapping such as {value: 40 MPa, source: ...}")
    elongation_at_break: StrainValue | None = Field(
        default=None, description="a mapping such as {value: 15 %, source: ...}"
    )
    density: DensityValue | None = Field(
        default=None, description="a mapping such as {value: 1180 kg/m^3, source: ...}"
    )
    relaxation: RelaxationModel | None = Field(
        default=None, description="a mapping such as {terms: [{share: 0.2, time: 10 s}], source: ...}"
    )
    yield_curve: CurveModel | None = Field(
        default=None,
        description="a mapping such as {points: [{strain: 2 %, stress: 40 MPa}, {strain: 15 %, stress: 50 MPa}], "
        "source: ...}",
    )
    note: str = Field(default="", description="a text")


def _material_branch(value: object) -> str:
    """Return the branch of the union: a yarn by measurement, or a solid material."""
    return YARN if is_measured(value) else SOLID


AnyMaterial = Annotated[
    Annotated[MaterialModel, Tag(SOLID)] | Annotated[SourcedYarnModel, Tag(YARN)], Discriminator(_material_branch)
]


class MaterialsModel(Model):
    """A knitlab materials file: one or more materials by name."""

    schema_id: Literal["knitlab/materials@1"] = Field(alias="schema", description=SCHEMA)
    materials: dict[str, AnyMaterial] = Field(
        min_length=1, description="a mapping of names to materials, each a mapping of fields"
    )

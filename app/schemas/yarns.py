"""Models of a yarn by measurement, in a protocol and in a file of materials, and their conversion.

Ranges are checked in `knitlab_core.materials`; here are structure, units and the table of a test between plates.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import Field, StringConstraints

from app.schemas.base import Model
from app.schemas.units import allowed, write
from app.schemas.values import BendingStiffness, Force, Length, LineForce
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import MeasuredYarn, Value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.units import Dimension

PROTOCOL: Final = "the protocol"
"""Source of the numbers of a yarn that a protocol itself gives."""

INLINE_NAME: Final = "measured-yarn"
"""Name of a yarn that a protocol itself gives."""

SOURCE = Field(description="where the number was found, or why it was chosen")
ASSUMED = Field(default=False, description="true for a choice, false for a figure of its source")
_TABLE = Field(
    default=None,
    description="compressions and forces by length of a yarn between plates, such as [[0.1 mm, 0.2 mN/mm], ...]; in "
    "a protocol also a CSV file beside it",
)
_EXPONENT = Field(default=None, description="a number from 2 to 6, such as 2.4")
_RIGIDITY = Field(
    default=None,
    description="the force by length that presses the yarn between plates to halfway to its core, such as 0.0048 N/mm",
)

Source = Annotated[str, StringConstraints(min_length=1, strip_whitespace=True)]
Row = tuple[Length, LineForce]

UNITS: Final[Mapping[str, tuple[str, Dimension | None]]] = MappingProxyType(
    {
        "bending": ("N*m**2", "bending stiffness"),
        "axial": ("N", "force"),
        "twisting": ("N*m**2", "bending stiffness"),
        "radius": ("m", "length"),
        "core": ("m", "length"),
        "exponent": ("1", None),
        "rigidity": ("N/m", "line force"),
        "friction": ("1", None),
    }
)
"""SI unit and dimension of the numbers of a yarn."""


class CompressionModel(Model):
    """How a yarn is flattened: two numbers, or a table they are fitted to."""

    exponent: float | None = _EXPONENT
    rigidity: LineForce | None = _RIGIDITY
    table: list[Annotated[Row, Field(strict=False)]] | None = _TABLE


class SourcedCompressionModel(CompressionModel):
    """The same with its source."""

    source: Source = SOURCE
    assumed: bool = ASSUMED


class MeasuredYarnModel(Model):
    """Take a yarn by what is measured on it."""

    bending: BendingStiffness = Field(description=allowed("bending stiffness"))
    axial: Force = Field(description="an axial stiffness, force by strain, with its unit, such as 100 N")
    twisting: BendingStiffness = Field(description=allowed("bending stiffness"))
    radius: Length = Field(description="the outer radius of the yarn, such as 0.74 mm")
    core: Length = Field(description="the radius to which no force can compress it, such as 0.325 mm")
    compression: CompressionModel = Field(
        description="a mapping such as {exponent: 2.4, rigidity: 0.0048 N/mm}, or {table: yarn.csv}"
    )
    friction: float | None = Field(default=None, description="a coefficient of friction, such as 0.3")


class BendingValue(Model):
    """A stiffness in bending or twisting and its source."""

    value: BendingStiffness = Field(description=allowed("bending stiffness"))
    source: Source = SOURCE
    assumed: bool = ASSUMED


class AxialValue(Model):
    """An axial stiffness and its source."""

    value: Force = Field(description="an axial stiffness, force by strain, with its unit, such as 100 N")
    source: Source = SOURCE
    assumed: bool = ASSUMED


class LengthValue(Model):
    """A length and its source."""

    value: Length = Field(description=allowed("length"))
    source: Source = SOURCE
    assumed: bool = ASSUMED


class FrictionValue(Model):
    """A coefficient of friction and its source."""

    value: float = Field(description="a coefficient of friction, such as 0.3")
    source: Source = SOURCE
    assumed: bool = ASSUMED


class SourcedYarnModel(Model):
    """A yarn by measurement in a file of materials, every number with its source."""

    bending: BendingValue = Field(description="a mapping such as {value: 0.045 N mm^2, source: ...}")
    axial: AxialValue = Field(description="a mapping such as {value: 100 N, source: ...}")
    twisting: BendingValue = Field(description="a mapping such as {value: 0.03 N mm^2, source: ...}")
    radius: LengthValue = Field(description="a mapping such as {value: 0.74 mm, source: ...}")
    core: LengthValue = Field(description="a mapping such as {value: 0.325 mm, source: ...}")
    compression: SourcedCompressionModel = Field(
        description="a mapping such as {exponent: 2.4, rigidity: 0.0048 N/mm, source: ...}, or with a table in their "
        "place"
    )
    friction: FrictionValue | None = Field(default=None, description="a mapping such as {value: 0.3, source: ...}")
    note: str = Field(default="", description="a text")


NAMES_OF_YARN: Final = frozenset(SourcedYarnModel.model_fields) - {"friction", "note"}
"""Fields that only a yarn by measurement has."""


def is_measured(value: object) -> bool:
    """Return whether data describe a yarn by measurement."""
    return isinstance(value, dict) and bool(NAMES_OF_YARN & set(value))


def to_inline_yarn(model: MeasuredYarnModel) -> MeasuredYarn:
    """Return the yarn that a protocol gives.

    Raises
    ------
    SpecificationError
        For a number out of its range, or a table that does not rise or that no law follows.
    """
    plain = {name: getattr(model, name) for name in ("bending", "axial", "twisting", "radius", "core", "friction")}
    values = {
        name: Value(value=number, unit=UNITS[name][0], source=PROTOCOL)
        for name, number in plain.items()
        if number is not None
    }
    return _made(INLINE_NAME, values, model.compression, PROTOCOL, assumed=False, note="")


def to_yarn(name: str, model: SourcedYarnModel) -> MeasuredYarn:
    """Return a yarn of a file of materials.

    Raises
    ------
    SpecificationError
        As `to_inline_yarn`.
    """
    models = {field: getattr(model, field) for field in ("bending", "axial", "twisting", "radius", "core", "friction")}
    values = {
        field: Value(value=one.value, unit=UNITS[field][0], source=one.source, assumed=one.assumed)
        for field, one in models.items()
        if one is not None
    }
    law = model.compression
    return _made(name, values, law, law.source, assumed=law.assumed, note=model.note)


def _made(
    name: str, values: Mapping[str, Value], law: CompressionModel, source: str, *, assumed: bool, note: str
) -> MeasuredYarn:
    """Return a yarn of its values and its law of compression."""
    if law.table is None:
        exponent, rigidity = _two_numbers(law)
    else:
        if law.exponent is not None or law.rigidity is not None:
            found, expected = "a table beside exponent or rigidity", "the table, or the two numbers"
            raise SpecificationError("yarn.compression", found, expected)
        radius, core = values["radius"].value, values["core"].value
        if not 0.0 < core < radius < float("inf"):
            raise SpecificationError("yarn.core", f"{1e3 * core:.4g} mm", f"above 0, below {1e3 * radius:.4g} mm")
        from knitlab_core.contact.compression import fit_compression  # noqa: PLC0415 (numba, for a table alone)

        fit = fit_compression([(length, force) for length, force in law.table], radius=radius, core=core)
        exponent, rigidity = fit.compression.exponent, fit.compression.rigidity
        fitted = (
            f"least squares of relative deviations over {fit.points} rows, missed by {100 * fit.deviation:.2g} % rms"
        )
        source = f"{fitted}; {source}"
    numbers = {"exponent": exponent, "rigidity": rigidity}
    more = {
        field: Value(value=number, unit=UNITS[field][0], source=source, assumed=assumed)
        for field, number in numbers.items()
    }
    return MeasuredYarn(name=name, note=note, **{**values, **more})


def _two_numbers(law: CompressionModel) -> tuple[float, float]:
    """Return exponent and rigidity."""
    for field, number in (("exponent", law.exponent), ("rigidity", law.rigidity)):
        if number is None:
            expected = "exponent and rigidity, or a table"
            raise SpecificationError("yarn.compression", f"no {field}", expected)
    return float(law.exponent or 0.0), float(law.rigidity or 0.0)


def written_yarn(yarn: MeasuredYarn) -> dict[str, Any]:
    """Return a yarn as the data of a file of materials that reads back as the same yarn.

    Raises
    ------
    SpecificationError
        If the two numbers of its compression come from two sources: a file gives one.
    """
    data: dict[str, Any] = {}
    for name, value in yarn.numbers():
        dimension = UNITS[name][1]
        number = value.value if dimension is None else write(value.value, dimension)
        data[name] = {"value": number, "source": value.source, "assumed": value.assumed}
    exponent, rigidity = data.pop("exponent"), data.pop("rigidity")
    first, second = exponent.pop("value"), rigidity.pop("value")
    if exponent != rigidity:
        found = "an exponent and a rigidity of two sources"
        raise SpecificationError("material.compression", found, "one source for both")
    data["compression"] = {"exponent": first, "rigidity": second, **exponent}
    return data | ({"note": yarn.note} if yarn.note else {})

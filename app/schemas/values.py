"""Single values of a user's YAML: quantities, stitch values, switches."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, cast

from pydantic import BeforeValidator, GetJsonSchemaHandler, PlainValidator, WithJsonSchema
from pydantic_core import CoreSchema, PydanticCustomError, PydanticKnownError

from app.schemas.errors import shown
from app.schemas.units import Dimension, allowed, parse, units_of
from knitlab_core.errors import SpecificationError, UnitError
from rigs.protocol.catalogue import CATALOGUE
from rigs.protocol.targets import Bound, ForceRate, Rate, StrainRate

if TYPE_CHECKING:
    from rigs.protocol.targets import Side


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """A length of a stitch, in metres or in loop widths."""

    value: float
    metres: bool


def refuse(expected: str) -> PydanticCustomError:
    """Return the error of a value, with what is allowed in its place."""
    return PydanticCustomError("refused", "{expected}", {"expected": expected})


def _quantity(dimension: Dimension, value: object) -> float:
    """Return a quantity in SI."""
    try:
        return parse(value, dimension)
    except UnitError as error:
        raise refuse(error.expected) from error


def _measure(value: object) -> Measure:
    """Return a stitch value: a bare number is in loop widths."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return Measure(value=float(value), metres=False)
    try:
        return Measure(value=parse(value, "length"), metres=True)
    except UnitError as error:
        raise refuse("a number of loop widths, or a length with its unit, such as 0.4 mm") from error


_RATES: Final[tuple[tuple[Dimension, Callable[[float], Rate]], ...]] = (
    ("speed", float),
    ("strain rate", lambda value: StrainRate(value=value)),
    ("force rate", lambda value: ForceRate(value=value)),
)
RATE: Final = "a speed, a strain rate or a force rate with its unit, such as 0.2 mm/s, 1e-3 1/s or 0.1 N/s"


def _rate(value: object) -> Rate:
    """Return a rate; its unit decides between speed, strain rate and force rate."""
    for dimension, make in _RATES:
        try:
            number = parse(value, dimension)
        except UnitError:
            continue
        try:
            return make(number)
        except SpecificationError as error:
            raise refuse(str(error.expected)) from error
    raise refuse(RATE)


def bounds(dimension: Dimension) -> str:
    """Return the phrase that describes a level with its side."""
    return f"{allowed(dimension)}, or with the side that counts, such as '> {_EXAMPLES[dimension]}'"


_EXAMPLES: Final = {"force": "50 mN", "strain": "40 %", "length": "8 mm"}


def _bound(dimension: Dimension, value: object) -> float | Bound:
    """Return a level, with its side if one is given."""
    side = value.strip()[:1] if isinstance(value, str) else ""
    try:
        if side in {">", "<"}:
            level = str(value).strip()[1:].strip()
            # A strain may be a bare number, which is a text here.
            number = level if dimension != "strain" or level.endswith("%") else float(level)
            return Bound(side=cast("Side", side), value=parse(number, dimension))
        return parse(value, dimension)
    except (UnitError, ValueError) as error:
        raise refuse(bounds(dimension)) from error


LEVEL: Final = "a strain, or with its unit a displacement or a force, as control says, such as 0.4, 8 mm or 0.2 N"


def _level(value: object) -> object:
    """Return a level unconverted; `control` decides its dimension."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise refuse(LEVEL)
    return value


EVERY: Final = "a time between pictures, such as 20 s, or off"


def _every(value: object) -> float | Literal["off"]:
    """Return the time between pictures, or the word that ends them."""
    if value == "off" or value is False:
        return "off"
    try:
        return parse(value, "time")
    except UnitError as error:
        raise refuse(EVERY) from error


LAID_IN: Final = "a contact radius as laid in, such as 0.3 mm, or relaxed, the loops of a periodic cell at rest"


def _laid_in(value: object) -> float | Literal["relaxed"]:
    """Return the contact radius of a yarn as laid in, or the word for loops of a cell at rest."""
    if value == "relaxed":
        return "relaxed"
    try:
        return parse(value, "length")
    except UnitError as error:
        raise refuse(LAID_IN) from error


def _switch(value: object) -> object:
    """Return `on` and `off` as booleans."""
    return {"on": True, "off": False}.get(value, value) if isinstance(value, str) else value


def _label(value: object) -> object:
    """Return a number as text where a name is expected: a parameter may give it."""
    return shown(value) if isinstance(value, int | float) else value


UNITS: Final = "x-units"
"""Keyword of the JSON Schema for the units that a quantity may have."""


def _text_schema(dimension: Dimension) -> WithJsonSchema:
    """Return the JSON Schema of a quantity."""
    return WithJsonSchema({"type": "string", "description": allowed(dimension), UNITS: units_of(dimension)})


def _rig_name(value: object) -> str:
    """Return the name of a rig."""
    if not isinstance(value, str) or value not in CATALOGUE:
        raise PydanticKnownError("literal_error", {"expected": " or ".join(f"'{name}'" for name in CATALOGUE)})
    return value


@dataclass(frozen=True, slots=True)
class Names:
    """Names in the JSON Schema of a text, those that were registered among them.

    Attributes
    ----------
    names : Callable
        Returns them when the schema is asked for.
    keyword : {'enum', 'examples'}
        Whether the text is one of them, or may be another.
    """

    names: Callable[[], Iterable[str]]
    keyword: Literal["enum", "examples"]

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {**handler(schema), self.keyword: list(self.names())}


AnyRig = Annotated[str, BeforeValidator(_rig_name), Names(lambda: CATALOGUE, "enum")]
Length = Annotated[float, BeforeValidator(partial(_quantity, "length")), _text_schema("length")]
Time = Annotated[float, BeforeValidator(partial(_quantity, "time")), _text_schema("time")]
Force = Annotated[float, BeforeValidator(partial(_quantity, "force")), _text_schema("force")]
Stress = Annotated[float, BeforeValidator(partial(_quantity, "stress")), _text_schema("stress")]
Density = Annotated[float, BeforeValidator(partial(_quantity, "density")), _text_schema("density")]
BendingStiffness = Annotated[
    float, BeforeValidator(partial(_quantity, "bending stiffness")), _text_schema("bending stiffness")
]
LineForce = Annotated[float, BeforeValidator(partial(_quantity, "line force")), _text_schema("line force")]
Frequency = Annotated[float, BeforeValidator(partial(_quantity, "frequency")), _text_schema("frequency")]
Strain = Annotated[
    float,
    BeforeValidator(partial(_quantity, "strain")),
    WithJsonSchema({"type": ["number", "string"], "description": allowed("strain"), UNITS: units_of("strain")}),
]


def _bound_schema(dimension: Dimension) -> WithJsonSchema:
    """Return the JSON Schema of a level with its side."""
    kinds = ["number", "string"] if dimension == "strain" else "string"
    return WithJsonSchema({"type": kinds, "description": bounds(dimension), UNITS: units_of(dimension)})


ForceBound = Annotated[float | Bound, PlainValidator(partial(_bound, "force")), _bound_schema("force")]
StrainBound = Annotated[float | Bound, PlainValidator(partial(_bound, "strain")), _bound_schema("strain")]
LengthBound = Annotated[float | Bound, PlainValidator(partial(_bound, "length")), _bound_schema("length")]
Every = Annotated[
    float | Literal["off"],
    PlainValidator(_every),
    WithJsonSchema({"type": "string", "description": EVERY, UNITS: units_of("time")}),
]
AnyRate = Annotated[
    Rate,
    PlainValidator(_rate),
    WithJsonSchema({"type": "string", "description": RATE, UNITS: units_of(*(dimension for dimension, _ in _RATES))}),
]
Level = Annotated[
    float | str,
    PlainValidator(_level),
    WithJsonSchema({"type": ["number", "string"], "description": LEVEL, UNITS: units_of("strain", "length", "force")}),
]
StitchValue = Annotated[
    Measure,
    PlainValidator(_measure),
    WithJsonSchema({"type": ["number", "string"], UNITS: units_of("length")}),
]
Label = Annotated[str, BeforeValidator(_label), WithJsonSchema({"type": ["string", "number"]})]
LaidIn = Annotated[
    float | Literal["relaxed"],
    PlainValidator(_laid_in),
    WithJsonSchema({"type": "string", "description": LAID_IN, UNITS: units_of("length"), "examples": ["relaxed"]}),
]
Switch = Annotated[bool, BeforeValidator(_switch), WithJsonSchema({"enum": ["on", "off", True, False]})]

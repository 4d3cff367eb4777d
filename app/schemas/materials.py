"""Conversion of a user's materials file to the domain's materials, and back; errors with their places.

Ranges are checked in `knitlab_core.materials`, structure and units in `material_models`.
"""

from __future__ import annotations

import re
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from app.schemas.base import BRANCH
from app.schemas.document import dotted
from app.schemas.errors import Faults, ProtocolError, in_order, nearest, shown
from app.schemas.material_models import (
    CurveModel,
    DensityValue,
    MaterialModel,
    MaterialsModel,
    NumberValue,
    PointModel,
    RelaxationModel,
    StrainValue,
    StressValue,
    TermModel,
)
from app.schemas.units import write
from app.schemas.yarns import (
    AxialValue,
    BendingValue,
    FrictionValue,
    LengthValue,
    SourcedCompressionModel,
    SourcedYarnModel,
    is_measured,
    to_yarn,
    written_yarn,
)
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import MATERIALS, CurvePoint, Material, MeasuredYarn, RelaxationTerm, Value
from rigs.protocol.bounds import LABEL, is_label

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic_core import ErrorDetails

    from app.schemas.base import Model
    from app.schemas.document import Document, Place
    from app.schemas.units import Dimension
    from knitlab_core.materials import Substance

_PART: Final = re.compile(r"[^.\[\]]+")


def to_materials(document: Document) -> dict[str, Substance]:
    """Return the materials of a document.

    Raises
    ------
    ProtocolError
        For whatever is wrong with them, in one line with file, line and column.
    """
    try:
        model = MaterialsModel.model_validate(document.data)
    except ValidationError as error:
        raise in_order([translate(document, details) for details in own_mistakes(error)]) from error
    return to_domain(model.materials, document)


def to_domain(models: Mapping[str, MaterialModel | SourcedYarnModel], document: Document) -> dict[str, Substance]:
    """Return the materials under `materials` in a document.

    Raises
    ------
    ProtocolError
        For a number out of its range, or a name that cannot be given.
    """
    faults = Faults()
    made = {name: faults.of(partial(_material, name, one, document), None) for name, one in models.items()}
    faults.raise_any()
    return {name: one for name, one in made.items() if one is not None}


def written(material: Substance) -> dict[str, Any]:
    """Return a material as the data of a file that reads back as the same material.

    Raises
    ------
    SpecificationError
        If the terms of its relaxation, the points of its yield curve or the numbers of its compression come from
        several sources: a file gives one.
    """
    if isinstance(material, MeasuredYarn):
        return written_yarn(material)
    numbers: dict[str, tuple[Value | None, Dimension | None]] = {
        "young_modulus": (material.young_modulus, "stress"),
        "poisson_ratio": (material.poisson_ratio, None),
        "strength": (material.strength, "stress"),
        "elongation_at_break": (material.elongation_at_break, "strain"),
        "density": (material.density, "density"),
    }
    data: dict[str, Any] = {
        name: {"value": value.value if kind is None else write(value.value, kind), **_origin(value)}
        for name, (value, kind) in numbers.items()
        if value is not None
    }
    if material.relaxation:
        values = [value for term in material.relaxation for value in (term.share, term.time)]
        origin = _one_origin(values, "material.relaxation", "terms")
        terms = [
            {"share": write(term.share.value, "strain"), "time": write(term.time.value, "time")}
            for term in material.relaxation
        ]
        data["relaxation"] = {"terms": terms, **origin}
    if material.yield_curve:
        values = [value for point in material.yield_curve for value in (point.strain, point.stress)]
        origin = _one_origin(values, "material.yield_curve", "points")
        points = [
            {"strain": write(point.strain.value, "strain"), "stress": write(point.stress.value, "stress")}
            for point in material.yield_curve
        ]
        data["yield_curve"] = {"points": points, **origin}
    return data | ({"note": material.note} if material.note else {})


def _one_origin(values: Sequence[Value], field: str, parts: str) -> dict[str, Any]:
    """Return the origin of all parts of a series, which a file gives once."""
    origin = _origin(values[0])
    if any(_origin(value) != origin for value in values):
        raise SpecificationError(field, f"{parts} of several sources", f"one source for all {parts}")
    return origin


def _origin(value: Value) -> dict[str, Any]:
    return {"source": value.source, "assumed": value.assumed}


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a materials file."""
    schema = MaterialsModel.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _material(name: str, model: MaterialModel | SourcedYarnModel, document: Document) -> Substance:
    """Return one material, or one yarn by measurement."""
    place: Place = ("materials", name)
    if not is_label(name) or name in MATERIALS:
        expected = f"{LABEL}, and no name of the catalogue"
        raise ProtocolError(document.path, document.spot(place, key=True), dotted(place), shown(name), expected)
    try:
        if isinstance(model, SourcedYarnModel):
            return to_yarn(name, model)
        return Material(
            name=name,
            young_modulus=_value(model.young_modulus, "Pa"),
            poisson_ratio=_value(model.poisson_ratio, "1"),
            strength=None if model.strength is None else _value(model.strength, "Pa"),
            elongation_at_break=None if model.elongation_at_break is None else _value(model.elongation_at_break, "1"),
            density=None if model.density is None else _value(model.density, "kg/m**3"),
            relaxation=() if model.relaxation is None else _terms(model.relaxation),
            yield_curve=() if model.yield_curve is None else _points(model.yield_curve),
            note=model.note,
        )
    except SpecificationError as error:
        raise _placed(document, place, error) from error


def _value(model: StressValue | DensityValue | StrainValue | NumberValue, unit: str) -> Value:
    """Return a value with its source."""
    return Value(value=model.value, unit=unit, source=model.source, assumed=model.assumed)


def _terms(model: RelaxationModel) -> tuple[RelaxationTerm, ...]:
    """Return the terms of a series, each with the series' source."""
    return tuple(
        RelaxationTerm(
            share=Value(value=term.share, unit="1", source=model.source, assumed=model.assumed),
            time=Value(value=term.time, unit="s", source=model.source, assumed=model.assumed),
        )
        for term in model.terms
    )


def _points(model: CurveModel) -> tuple[CurvePoint, ...]:
    """Return the points of a curve, each with the curve's source."""
    return tuple(
        CurvePoint(
            strain=Value(value=point.strain, unit="1", source=model.source, assumed=model.assumed),
            stress=Value(value=point.stress, unit="Pa", source=model.source, assumed=model.assumed),
        )
        for point in model.points
    )


def _placed(document: Document, material: Place, error: SpecificationError) -> ProtocolError:
    """Return an error of the domain with line and column of the number it blames."""
    # `material.relaxation[0].share` is under `terms`, `material.yield_curve[0].stress` under `points`, any other
    # number under `value`.
    kind, *names = [int(part) if part.isdigit() else part for part in _PART.findall(error.field)]
    if kind == "material" and len(names) > 1:
        names.insert(1, "points" if names[0] == "yield_curve" else "terms")
    place: Place = (*material, *names)
    if (*place, "value") in document.values:
        place = (*place, "value")
    return ProtocolError(document.path, document.spot(place), dotted(place), shown(error.found), error.expected)


def own_mistakes(error: ValidationError) -> list[ErrorDetails]:
    """Return pydantic's errors without those that follow from another: a misspelt field is also missing."""
    every = error.errors(include_url=False)
    unknown = [details["loc"] for details in every if details["type"] == "extra_forbidden"]

    def misspelt(place: tuple[int | str, ...]) -> bool:
        return any(
            other[:-1] == place[:-1] and nearest(str(other[-1]), [str(place[-1]).removesuffix("_id")])
            for other in unknown
        )

    return [details for details in every if details["type"] != "missing" or not misspelt(details["loc"])]


def translate(document: Document, details: Mapping[str, Any]) -> ProtocolError:
    """Return one of pydantic's errors in our words."""
    place: Place = tuple("schema" if part == "schema_id" else part for part in details["loc"])
    # In a protocol materials by name are one way of two to give them.
    place = tuple(part for part in place if not str(part).startswith(BRANCH))
    field = dotted(place) or "materials"
    known = _fields(place[:-1], document)
    if details["type"] == "extra_forbidden":
        expected = f"{', '.join(known)}{nearest(str(place[-1]), known)}"
        return ProtocolError(document.path, document.spot(place, key=True), field, "an unknown field", expected)
    missing = details["type"] == "missing"
    found = "nothing" if missing else shown(details["input"])
    spot = document.spot(place)
    allowed = _phrase(place, known, document)
    return ProtocolError(document.path, spot, field, found, allowed, missing=missing)


def _phrase(place: Place, known: Mapping[str, str], document: Document) -> str:
    """Return the phrase that describes what is allowed at a place whose neighbours are `known`."""
    if place and place[-1] in known:
        return known[str(place[-1])]
    if "table" in place:
        return _ROW
    return f"a mapping of fields: {', '.join(_fields(place, document))}"


def _fields(place: Place, document: Document) -> dict[str, str]:
    """Return the fields of the mapping at a place, with what each allows; nothing where names are free."""
    model: type[Model] | None
    match place:
        case ():
            model = MaterialsModel
        case ("materials", _):
            one = _within(document.data, place)
            model = SourcedYarnModel if is_measured(one) else MaterialModel
        case ("materials", _, str(name)):
            model = _VALUES.get(name)
        case ("materials", _, "relaxation", "terms", int()):
            model = TermModel
        case ("materials", _, "yield_curve", "points", int()):
            model = PointModel
        case _:
            model = None
    if model is None:
        return {}
    return {field.alias or key: field.description or "a value" for key, field in model.model_fields.items()}


def _within(data: object, place: Place) -> object:
    """Return the data at a place of a file; None where there is none."""
    for part in place:
        data = data.get(part) if isinstance(data, dict) else None
    return data


_ROW: Final = "a row of two: a compression and a force by length, such as [0.1 mm, 0.002 N/mm]"

_VALUES: Final[Mapping[str, type[Model]]] = MappingProxyType(
    {
        "young_modulus": StressValue,
        "poisson_ratio": NumberValue,
        "strength": StressValue,
        "elongation_at_break": StrainValue,
        "density": DensityValue,
        "relaxation": RelaxationModel,
        "yield_curve": CurveModel,
        "bending": BendingValue,
        "axial": AxialValue,
        "twisting": BendingValue,
        "radius": LengthValue,
        "core": LengthValue,
        "friction": FrictionValue,
        "compression": SourcedCompressionModel,
    }
)

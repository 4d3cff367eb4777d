"""Mapping of a measured file: what its columns are, and of which specimen, given once in YAML."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal, get_args

from pydantic import Field, ValidationError

from app.schemas.base import Model
from app.schemas.document import Document, dotted, parse_text, read_text
from app.schemas.errors import ProtocolError, in_order, nearest, shown
from app.schemas.units import allowed, parse
from app.schemas.values import Label, Length
from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment
from rigs.readers.headings import DIMENSIONS, Heading, Quantity, factor_to_si
from rigs.readers.mapping import FileMapping

SCHEMA: Final = "knitlab/measured@1"
SHORTEST, LONGEST = 1e-9, 1e3
"""Lengths of a specimen that are none by mistake [m]."""

MOST_LOOKED_AT: Final = 4096
"""Bytes of a YAML file in which its schema is looked for."""

_AXIS: Final = "C, W, P or another name of the axis that was pulled"
_DELIMITERS: Final = {"comma": ",", "semicolon": ";", "tab": "\t"}


class ColumnModel(Model):
    """Meaning of a column."""

    quantity: Quantity = Field(alias="is", description=f"one of {', '.join(get_args(Quantity))}")
    unit: Label = Field(default="", description="its unit, such as mm or kN; that of the file if it is left out")
    axis: Label = Field(default="", description=_AXIS)


class MeasuredModel(Model):
    """A mapping."""

    schema_id: Literal["knitlab/measured@1"] = Field(alias="schema", description=SCHEMA)
    columns: dict[str, ColumnModel] = Field(
        default_factory=dict,
        description="columns by heading, or by number in a file without headings, such as Fz: {is: force, unit: N}",
    )
    delimiter: Literal["comma", "semicolon", "tab"] | None = Field(default=None, description="comma, semicolon or tab")
    decimal: Literal["comma", "point"] | None = Field(default=None, description="comma or point")
    axis: Label = Field(default="", description=_AXIS)
    gauge_length: Length | None = Field(default=None, description=allowed("length"))
    width: Length | None = Field(default=None, description=allowed("length"))
    thickness: Length | None = Field(default=None, description=allowed("length"))


def load_mapping(path: Path) -> FileMapping:
    """Return the mapping in a YAML file of schema ``knitlab/measured@1``.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line with file, line and column.
    """
    document = parse_text(read_text(path, "mapping"), str(path), "mapping")
    try:
        model = MeasuredModel.model_validate(document.data)
    except ValidationError as error:
        raise in_order([_translate(document, one) for one in error.errors(include_url=False)]) from error
    _require_units(document, model)
    _require_above_zero(document, model)
    lengths = {name: getattr(model, name) for name in ("gauge_length", "width", "thickness")}
    return FileMapping(
        headings={
            name: Heading(text=name, quantity=one.quantity, axis=one.axis, unit=one.unit)
            for name, one in model.columns.items()
        },
        delimiter=None if model.delimiter is None else _DELIMITERS[model.delimiter],
        decimal=None if model.decimal is None else {"comma": ",", "point": "."}[model.decimal],
        axis=model.axis,
        **{name: length for name, length in lengths.items() if length is not None},
    )


def mapping_beside(path: Path) -> FileMapping:
    """Return the mapping of a measured file's name beside it; an empty one if there is none.

    Raises
    ------
    ProtocolError
        As `load_mapping`.
    """
    beside = path.with_suffix(".yaml")
    # A protocol may have the name of its log.
    is_mapping = beside.is_file() and SCHEMA.encode() in beside.read_bytes()[:MOST_LOOKED_AT]
    return load_mapping(beside) if is_mapping else FileMapping()


def with_lengths(known: FileMapping, gauge_length: str | None, width: str | None, thickness: str | None) -> FileMapping:
    """Return what is known of a measured file with lengths that go before its own, as texts such as ``45 mm``.

    Raises
    ------
    SpecificationError
        If one is no length above 0.
    """

    def length(option: str, text: str | None, otherwise: float) -> float:
        if text is None:
            return otherwise
        found = parse(text, "length", option)
        if not SHORTEST <= found <= LONGEST:
            raise SpecificationError(option, text, "a length above 0 m: from 1 nm to 1 km")
        return found

    return replace(
        known,
        gauge_length=length("--gauge-length", gauge_length, known.gauge_length),
        width=length("--width", width, known.width),
        thickness=length("--thickness", thickness, known.thickness),
    )


def alignment_of(cycle: int, slack: str | None, *, offset: bool) -> Alignment:
    """Return how tests are laid over each other; the slack is a text such as ``50 mN``.

    Raises
    ------
    SpecificationError
        If the slack is no force.
    """
    return Alignment(cycle=cycle, slack=None if slack is None else parse(slack, "force", "--slack"), offset=offset)


def _require_units(document: Document, model: MeasuredModel) -> None:
    for name, one in model.columns.items():
        if one.unit and factor_to_si(one.quantity, one.unit) is None:
            place = ("columns", name, "unit")
            expected = f"a unit of {DIMENSIONS[one.quantity]}"
            raise ProtocolError(document.path, document.spot(place), dotted(place), shown(one.unit), expected)


def _require_above_zero(document: Document, model: MeasuredModel) -> None:
    for name in ("gauge_length", "width", "thickness"):
        length = getattr(model, name)
        if length is not None and length <= 0.0:
            spot = document.spot((name,))
            raise ProtocolError(document.path, spot, name, f"{length:g} m", "a length above 0 m")


def _translate(document: Document, details: Any) -> ProtocolError:  # noqa: ANN401 (pydantic's)
    """Return one of pydantic's errors in our words."""
    place = tuple({"schema_id": "schema"}.get(str(part), part) for part in details["loc"])
    model: type[Model] = ColumnModel if len(place) > 2 else MeasuredModel
    known = {field.alias or name: field.description or "a value" for name, field in model.model_fields.items()}
    field = dotted(place) or "mapping"
    if details["type"] == "extra_forbidden":
        expected = f"{', '.join(known)}{nearest(str(place[-1]), known)}"
        return ProtocolError(document.path, document.spot(place, key=True), field, "an unknown field", expected)
    missing = details["type"] == "missing"
    found = "nothing" if missing else shown(details["input"])
    expected = known.get(str(place[-1]) if place else "", f"a mapping of fields: {', '.join(known)}")
    return ProtocolError(document.path, document.spot(place), field, found, expected, missing=missing)

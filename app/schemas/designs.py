"""Design file: a protocol, its free parameters with their bounds, and what its test shall come to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import Field, ValidationError

from app.schemas.base import Model
from app.schemas.document import Document, dotted, parse_text, read_text
from app.schemas.errors import Faults, ProtocolError, in_order, nearest, shown
from app.schemas.sampling import MOST_PARAMETERS, Method, number_and_unit
from app.schemas.units import allowed
from app.schemas.values import Strain, Stress  # noqa: TC001 (pydantic reads the annotations)
from rigs.axes import Axis  # noqa: TC001 (the same)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from app.schemas.sweep import Scalar

    Fault = tuple[tuple[str | int, ...], str, str]

SCHEMA: Final = "knitlab/design@1"
MOST_POINTS: Final = 1000
MOST_ROUNDS: Final = 100
MOST_CHOICES: Final = 20

_FREE: Final = "a mapping of names under params to the ends of their ranges, such as {r: [0.6 mm, 0.9 mm]}"
_CHOICES: Final = "a mapping of names under params to words to choose from, such as {resin: [soft, hard]}"
_TARGET: Final = "{secant: 40 kPa, to: 20 %}, {loop_area: 30 Pa} or {curve: wanted.csv}, with axis and cycle"
_POSITIVE: Final = "a number above 0, at most 100 %"


class TargetModel(Model):
    """What the test shall come to: one of a secant, a loop area and a curve."""

    secant: Stress | None = Field(default=None, description=allowed("stress"))
    to: Strain | None = Field(default=None, description="the strain that the secant runs to, such as 20 %")
    loop_area: Stress | None = Field(default=None, description="an energy by volume as a stress: 30 J/m3 are 30 Pa")
    curve: str | None = Field(default=None, description="the name of a measured file beside this one")
    axis: Axis = Field(description="C, W or P, or WC, PC or PW of a shear")
    cycle: int = Field(default=1, description="a whole number from 1")


class DesignModel(Model):
    """A design file."""

    schema_id: Literal["knitlab/design@1"] = Field(alias="schema", description=SCHEMA)
    protocol: str = Field(description="the name of a protocol file beside this one")
    free: dict[str, list[str | int | float]] = Field(default_factory=dict, description=_FREE)
    choices: dict[str, list[str | int | float | bool]] = Field(default_factory=dict, description=_CHOICES)
    target: TargetModel = Field(description=_TARGET)
    within: Strain = Field(default=0.05, description=_POSITIVE)
    points: int = Field(default=12, description=f"a whole number from 4 to {MOST_POINTS}")
    method: Method = Field(default="halton", description="halton, latin-hypercube or random")
    seed: int = Field(default=0, description="a whole number from 0")
    rounds: int = Field(default=8, description=f"a whole number from 0 to {MOST_ROUNDS}")
    printer: str = Field(default="j35", description="j35, nanoscribe, the path of a printer's file, or none")
    proof: dict[str, str | int | float | bool] = Field(
        default_factory=dict, description="values of params for the last test, such as {nodes: 48}"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Ends of a free parameter in its unit."""

    name: str
    low: float
    high: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignTarget:
    """What the test shall come to, along an axis in a cycle; one of the first three is given.

    Attributes
    ----------
    secant : float or None
        Secant modulus of the loading [Pa].
    loop_area : float or None
        Area of the cycle's loop [J/m³].
    curve : Path or None
        Measured file whose loading is wanted.
    to : float
        Strain that the secant runs to [1]; ``nan`` without a secant.
    axis : str
        The axis.
    cycle : int
        Which cycle, from 1.
    """

    secant: float | None
    loop_area: float | None
    curve: Path | None
    to: float
    axis: str
    cycle: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignFile:
    """Content of a design file; fields as in `DesignModel`, files as paths, `within` as a share [1]."""

    path: Path
    protocol: Path
    ranges: Sequence[Range]
    choices: Mapping[str, Sequence[Scalar]]
    target: DesignTarget
    within: float
    points: int
    method: Method
    seed: int
    rounds: int
    printer: str
    proof: Mapping[str, Scalar]


def load_design(path: Path | str) -> DesignFile:
    """Return the content of a design file.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, each mistake with file, line and column.
    """
    path = Path(path)
    document = parse_text(read_text(path, "design"), str(path), "design")
    try:
        model = DesignModel.model_validate(document.data)
    except ValidationError as error:
        raise in_order([_translate(document, one) for one in error.errors(include_url=False)]) from error
    faults = Faults()
    ranges = [faults.of(partial(_range, document, name, ends), None) for name, ends in model.free.items()]
    for place, found, expected in _faults(model):
        faults.found.append(_refusal(document, place, found, expected))
    faults.raise_any()
    wanted = model.target
    return DesignFile(
        path=path,
        protocol=path.parent / model.protocol,
        ranges=[one for one in ranges if one is not None],
        choices=model.choices,
        target=DesignTarget(
            secant=wanted.secant,
            loop_area=wanted.loop_area,
            curve=None if wanted.curve is None else path.parent / wanted.curve,
            to=float("nan") if wanted.to is None else wanted.to,
            axis=wanted.axis,
            cycle=wanted.cycle,
        ),
        within=model.within,
        points=model.points,
        method=model.method,
        seed=model.seed,
        rounds=model.rounds,
        printer=model.printer,
        proof=model.proof,
    )


def _range(document: Document, name: str, ends: Sequence[Scalar]) -> Range:
    """Return the ends of a free parameter."""
    place = ("free", name)
    pair = [number_and_unit(end) for end in ends]
    if len(pair) != 2 or pair[0] is None or pair[1] is None or pair[0][1] != pair[1][1]:
        raise _refusal(document, place, shown(list(ends)), "two numbers of one unit, such as [6 mm, 12 mm]")
    (low, unit), (high, _) = pair[0], pair[1]
    if not low < high or not isfinite(low) or not isfinite(high):
        raise _refusal(document, place, shown(list(ends)), "the smaller end first")
    return Range(name=name, low=low, high=high, unit=unit)


def _faults(model: DesignModel) -> Iterator[Fault]:
    """Yield what is out of range: its place, what was found, what is allowed."""
    yield from _parameter_faults(model)
    yield from _target_faults(model.target)
    for place, value, low, high in (
        (("target", "cycle"), model.target.cycle, 1, 100_000),
        (("points",), model.points, 4, MOST_POINTS),
        (("rounds",), model.rounds, 0, MOST_ROUNDS),
        (("seed",), model.seed, 0, 2**32 - 1),
    ):
        if not low <= value <= high:
            yield place, str(value), f"a whole number from {low} to {high}"
    if not 0.0 < model.within <= 1.0:
        yield ("within",), f"{model.within:g}", _POSITIVE


def _parameter_faults(model: DesignModel) -> Iterator[Fault]:
    count = len(model.free) + len(model.choices)
    if not 1 <= count <= MOST_PARAMETERS:
        yield ("free",), f"{count} parameters, choices among them", f"1 to {MOST_PARAMETERS}"
    for name, words in model.choices.items():
        if not 2 <= len(words) <= MOST_CHOICES or len(set(map(str, words))) < len(words):
            yield ("choices", name), f"{len(words)} values", f"2 to {MOST_CHOICES} values, each once"
        if name in model.free:
            yield ("choices", name), "a name that is under free too", "each parameter once"


def _target_faults(wanted: TargetModel) -> Iterator[Fault]:
    given = [name for name in ("secant", "loop_area", "curve") if getattr(wanted, name) is not None]
    if len(given) != 1:
        yield ("target",), ", ".join(given) or "nothing that is wanted", _TARGET
    for name in given:
        value = getattr(wanted, name)
        if not isinstance(value, str) and value <= 0.0:
            yield ("target", name), f"{value:g} Pa", "a value above 0"
    if (wanted.secant is None) != (wanted.to is None):
        yield ("target",), "secant or to without the other", "both, such as {secant: 40 kPa, to: 20 %}"
    if wanted.to is not None and wanted.to <= 0.0:
        yield ("target", "to"), f"{wanted.to:g}", "a strain above 0"


def _translate(document: Document, details: Any) -> ProtocolError:  # noqa: ANN401 (pydantic's)
    """Return one of pydantic's errors in our words."""
    place = tuple({"schema_id": "schema"}.get(str(part), part) for part in details["loc"])
    inner = place[:1] == ("target",) and len(place) > 1
    model: type[Model] = TargetModel if inner else DesignModel
    known = {field.alias or name: field.description or "a value" for name, field in model.model_fields.items()}
    field = str(place[1] if inner else place[0] if place else "")
    if details["type"] == "extra_forbidden":
        expected = f"{', '.join(known)}{nearest(str(place[-1]), known)}"
        return ProtocolError(document.path, document.spot(place, key=True), dotted(place), "an unknown field", expected)
    missing = details["type"] == "missing"
    found = "nothing" if missing else shown(details["input"])
    expected = known.get(field, f"a mapping of fields: {', '.join(known)}")
    return ProtocolError(
        document.path, document.spot(place), dotted(place) or "design", found, expected, missing=missing
    )


def _refusal(document: Document, place: tuple[str | int, ...], found: str, expected: str) -> ProtocolError:
    """Return an error at a value."""
    return ProtocolError(document.path, document.spot(place), dotted(place), found, expected)

"""Parts that steps share in a file: models of targets, ends and logs, and their conversion to and from the domain."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, Final

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from app.schemas.base import Model
from app.schemas.errors import Faults
from app.schemas.units import Dimension, allowed, parse, write
from app.schemas.values import (
    Force,
    ForceBound,
    Frequency,
    Length,
    LengthBound,
    Strain,
    StrainBound,
    Time,
    bounds,
    refuse,
)
from knitlab_core.errors import SpecificationError, UnitError
from rigs.protocol.step import Step
from rigs.protocol.steps import Repeat
from rigs.protocol.targets import Control, ForceRate, Rate, StepLog, StrainRate, Target, Until

AXES: Final = "a list of axes, such as [C, W] or, of shear, [WC]"
COUNT: Final = "a whole number from 1"
DROP: Final = "a share of the peak, such as 60 %"
CONTROL: Final = "strain, displacement or force: what follows its course at the rate"
UNTIL: Final = (
    "a mapping of what ends the step early, such as {force: 2 N}, {force: '< 0.1 N'}, {time: 20 s} or {drop: 60 %}"
)
EVENTS: Final = f"the rate near jumps of the specimen, {allowed('frequency')}"
EVERY_CYCLE: Final = "a whole number n from 1: the first, the last and every n-th cycle of a step cycle is logged"
LOG: Final = "a mapping of how the step is logged, such as {rate: 1 Hz} or {rate: 1 Hz, events: 100 Hz}"
TARGET: Final = "a target, such as 40 %, 10 mm or 2 N, or {strain: 0.4}, {displacement: 10 mm} or {force: 2 N}"
TARGETS: Final[Mapping[str, Dimension]] = MappingProxyType(
    {"strain": "strain", "displacement": "length", "force": "force"}
)
TAG: Final = Field(default=None, description="a text or a number that names the step in the log")


class UntilModel(Model):
    """Conditions that end a step before its target; what is met first does, at once if it is met when the step begins.

    A level without a side is passed as the step goes: at or above it where the step pulls, at or below it where a ramp
    lets go, from whichever side in a hold.
    """

    force: ForceBound | None = Field(default=None, description=bounds("force"))
    strain: StrainBound | None = Field(default=None, description=bounds("strain"))
    displacement: LengthBound | None = Field(default=None, description=bounds("length"))
    time: Time | None = Field(default=None, description=allowed("time"))
    drop: Strain | None = Field(default=None, description=DROP)


class StepLogModel(Model):
    """Logging of a step where it differs from the test."""

    rate: Frequency | None = Field(default=None, description=allowed("frequency"))
    events: Frequency | None = Field(default=None, description=EVENTS)


class CycleLogModel(StepLogModel):
    """The same of a step of cycles, with those that are kept."""

    every_cycle: int | None = Field(default=None, description=EVERY_CYCLE)


class TargetModel(Model):
    """Target of the axes: one of a strain, a displacement and a force."""

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
        """Return the JSON Schema, in which a level alone is a target too."""
        mapping = handler.resolve_ref_schema(handler(schema))
        return {"anyOf": [mapping, {"type": ["number", "string"], "description": TARGET}]}


@dataclass(frozen=True, slots=True, kw_only=True)
class StepContext:
    """What the conversion of a step needs beside its model.

    Attributes
    ----------
    faults : Faults
        Takes what is out of its range in a part of the step.
    steps : Callable
        Conversion of the steps inside a step.
    """

    faults: Faults
    steps: Callable[[Sequence[Model]], tuple[Step | Repeat, ...]]


def common(body: Any, context: StepContext) -> dict[str, Any]:  # noqa: ANN401 (the model of any step that has them)
    """Return the fields that all steps have which take time: what ends them early, how they are logged, their tag."""
    return {
        "until": context.faults.of(lambda: _until(body.until), None),
        "log": context.faults.of(lambda: _log(body.log), None),
        "tag": body.tag,
    }


def driven(body: Any, context: StepContext) -> dict[str, Any]:  # noqa: ANN401 (the model of any step that has them)
    """Return the fields that all steps have which drive axes at a rate."""
    return {"axes": tuple(body.axes), "rate": body.rate, "control": body.control, **common(body, context)}


def _until(model: UntilModel | None) -> Until | None:
    """Return what ends a step early."""
    return None if model is None else Until(**{one.name: getattr(model, one.name) for one in fields(Until)})


def _log(model: StepLogModel | None) -> StepLog | None:
    """Return how a step is logged."""
    if model is None:
        return None
    every = model.every_cycle if isinstance(model, CycleLogModel) else None
    return StepLog(rate=model.rate, events=model.events, every_cycle=every)


def target(model: TargetModel, context: StepContext) -> Target:
    """Return the one target that is given; one of the same kind for one out of its range."""
    kinds: tuple[Control, ...] = ("strain", "displacement", "force")
    kind, value = next((kind, value) for kind in kinds if (value := getattr(model, kind)) is not None)

    def made() -> Target:
        try:
            return Target(kind=kind, value=value)
        except SpecificationError as error:
            raise SpecificationError(f"to.{error.field}", error.found, error.expected) from error

    return context.faults.of(made, Target(kind=kind, value=0.0))


def level(value: object, control: Control, name: str) -> float:
    """Return a level in what `control` measures.

    Raises
    ------
    SpecificationError
        If it measures something else.
    """
    try:
        return parse(value, MEASURES[control], name)
    except UnitError as error:
        expected = f"{error.expected}, for {control} is controlled"
        raise SpecificationError(name, repr(value), expected) from error


MEASURES: Final[Mapping[Control, Dimension]] = {"strain": "strain", "displacement": "length", "force": "force"}


def given(**values: object) -> dict[str, Any]:
    """Return the fields that have a value."""
    return {name: value for name, value in values.items() if value is not None}


def written_common(step: Any) -> dict[str, Any]:  # noqa: ANN401 (any step that has them)
    """Return what ends a step early, how it is logged and its tag as the data of a file."""
    return given(until=_written_until(step.until), log=_written_log(step.log), tag=step.tag)


def written_level(kind: Control, value: float) -> float | str:
    """Return a level as a file writes it."""
    return value if kind == "strain" else write(value, MEASURES[kind])


def written_target(to: Target | None) -> dict[str, float | str] | None:
    """Return a target as the data of a file."""
    return None if to is None else {to.kind: written_level(to.kind, to.value)}


def written_rate(rate: Rate) -> str:
    """Return a rate as a file writes it."""
    match rate:
        case StrainRate():
            return write(rate.value, "strain rate")
        case ForceRate():
            return write(rate.value, "force rate")
        case _:
            return write(rate, "speed")


def written_time(time: float) -> str:
    """Return a time as a file writes it."""
    return write(time, "time")


def _written_until(until: Until | None) -> dict[str, Any] | None:
    """Return what ends a step as the data of a file."""
    if until is None:
        return None
    return given(
        force=_written_bound("force", until),
        strain=_written_bound("strain", until),
        displacement=_written_bound("displacement", until),
        time=None if until.time is None else written_time(until.time),
        drop=until.drop,
    )


def _written_log(log: StepLog | None) -> dict[str, Any] | None:
    """Return how a step is logged as the data of a file."""
    if log is None:
        return None
    return given(
        rate=None if log.rate is None else write(log.rate, "frequency"),
        events=None if log.events is None else write(log.events, "frequency"),
        every_cycle=log.every_cycle,
    )


def _written_bound(kind: Control, until: Until) -> float | str | None:
    """Return a level that ends a step, with its side if one is said."""
    level, side = until.level(kind), until.side(kind)
    if level is None or side is None:
        return None if level is None else written_level(kind, level)
    return f"{side} {level!r}" if kind == "strain" else f"{side} {written_level(kind, level)}"

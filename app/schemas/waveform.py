"""The step `waveform` in a file: points in the file, or in a CSV table beside it."""

from typing import Annotated, Any, Final

from pydantic import Field, PlainValidator, WithJsonSchema, model_validator

from app.schemas.base import Model
from app.schemas.step_parts import (
    AXES,
    CONTROL,
    LOG,
    TAG,
    UNTIL,
    StepContext,
    StepLogModel,
    UntilModel,
    common,
    level,
    written_common,
    written_level,
    written_time,
)
from app.schemas.units import parse
from app.schemas.values import LEVEL, Label, refuse
from knitlab_core.errors import UnitError
from rigs.axes import Axis
from rigs.protocol.targets import Control
from rigs.protocol.waveform import Waveform

POINT: Final = "a list of a time and a level, such as [1 s, 5 %]"
_TABLE: Final = "a CSV file beside the protocol, such as my_wave.csv, with a head such as time (s),strain (%)"

#: Takes the place of points that have mistakes.
_STAND_IN: Final[tuple[tuple[float, float], ...]] = ((0.0, 0.0), (1.0, 0.0))


def _point(value: object) -> tuple[float, object]:
    """Return the time of a point [s] and its level as the file has it; `kind` is what it measures."""
    if not isinstance(value, list) or len(value) != 2 or isinstance(value[1], bool | dict | list | None):
        raise refuse(POINT)
    try:
        return parse(value[0], "time"), value[1]
    except UnitError as error:
        raise refuse(POINT) from error


Point = Annotated[
    tuple[float, object],
    PlainValidator(_point),
    WithJsonSchema(
        {
            "type": "array",
            "prefixItems": [{"type": "string"}, {"type": ["number", "string"], "description": LEVEL}],
            "minItems": 2,
            "maxItems": 2,
            "description": POINT,
        }
    ),
]


class WaveformModel(Model):
    """Drive axes along points of time and level; levels count from the last zero."""

    axes: list[Axis] = Field(description=AXES)
    table: str | None = Field(default=None, description=_TABLE)
    points: list[Point] | None = Field(
        default=None, description="a list of points from 0 s on, such as [[0 s, 0 %], [1 s, 5 %]]"
    )
    kind: Control = Field(default="strain", description=CONTROL)
    until: UntilModel | None = Field(default=None, description=UNTIL)
    log: StepLogModel | None = Field(default=None, description=LOG)
    tag: Label | None = TAG

    @model_validator(mode="after")
    def one_of_them(self) -> "WaveformModel":
        """Refuse none and both."""
        if (self.table is None) == (self.points is None):
            raise refuse("one of table and points")
        return self


def to_waveform(body: WaveformModel, context: StepContext) -> Waveform:
    """Return the step of a model; the points of its table were put into it before (`app.schemas.tables`)."""

    def points() -> tuple[tuple[float, float], ...]:
        given = enumerate(body.points or ())
        return tuple((time, level(value, body.kind, f"points[{number}][1]")) for number, (time, value) in given)

    rest = common(body, context)
    # A table that could not be read is still named.
    made = _STAND_IN if body.points is None else context.faults.of(points, _STAND_IN)
    return Waveform(axes=tuple(body.axes), points=made, kind=body.kind, **rest)


def written_waveform(step: Waveform) -> dict[str, Any]:
    """Return a step as the data of a file, its points in it."""
    points = [[written_time(time), written_level(step.kind, value)] for time, value in step.points]
    return {"axes": list(step.axes), "points": points, "kind": step.kind, **written_common(step)}

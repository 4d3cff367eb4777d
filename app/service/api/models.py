"""Pydantic models of the service's answers, from which the OpenAPI document is made."""

from datetime import datetime
from typing import Annotated, Any, Literal

from fastapi import Path
from pydantic import ConfigDict, Field

from app.service.api.progress import Answer, ProgressView
from app.service.jobs import State


class Place(Answer):
    """What is wrong, and where in the request."""

    model_config = ConfigDict(extra="allow")
    detail: str
    pointer: str | None = Field(default=None, description="JSON pointer (RFC 6901) into the protocol")
    line: int | None = Field(default=None, description="line of the YAML text, from 1")
    column: int | None = Field(default=None, description="column of the YAML text, from 1")
    file: str | None = Field(default=None, description="name of the file beside the protocol that it is in")
    parameter: str | None = Field(default=None, description="name of the parameter of the request")
    bound: int | None = Field(default=None, description="the bound that was passed")


class Problem(Answer):
    """An error in the form of RFC 9457."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "type": "urn:knitlab:problem:invalid-protocol",
                "title": "The protocol is not valid",
                "status": 422,
                "detail": "line 3, column 6: rig: found 'biaxial', allowed biaxial-hook or uniaxial-frame",
                "instance": "/v1/jobs",
                "errors": [
                    {
                        "detail": "rig: found 'biaxial', allowed biaxial-hook or uniaxial-frame",
                        "pointer": "/rig",
                        "line": 3,
                        "column": 6,
                    }
                ],
            }
        }
    )
    type: str = Field(description="urn:knitlab:problem:..., or about:blank where the status says all")
    title: str
    status: int
    detail: str
    instance: str
    errors: list[Place] = Field(default=[])


class Number(Answer):
    """A number with its unit and source."""

    value: float
    unit: str
    source: str
    assumed: bool = Field(description="whether it is a choice rather than a figure of its source")


class RelaxationView(Answer):
    """One term of a Prony series."""

    share: Number
    time: Number


class CurvePointView(Answer):
    """One point of a curve of stress over strain."""

    strain: Number
    stress: Number


class MaterialView(Answer):
    """A material."""

    name: str
    young_modulus: Number
    poisson_ratio: Number
    strength: Number | None
    elongation_at_break: Number | None
    density: Number | None
    relaxation: list[RelaxationView]
    yield_curve: list[CurvePointView]
    note: str


class MaterialList(Answer):
    """The catalogue of materials."""

    materials: list[MaterialView]


class MachineView(Answer):
    """A machine by its numbers, each with its source."""

    name: str
    numbers: dict[str, Any] = Field(description="by part and name: value, unit, source, assumed")


class RigView(Answer):
    """A rig: the axes that it drives, and its machines."""

    name: str
    axes: list[str]
    mounts_one: bool = Field(description="whether only the axis along the frame is driven")
    others: list[str] = Field(description="what a protocol may ask of axes that a step does not drive")
    others_default: str | None = Field(description="what holds where a protocol asks nothing; null: it has to say")
    machines: list[str]
    dialects: list[str] = Field(description="dialects of the logs of its machines")


class RigList(Answer):
    """The catalogue of rigs."""

    rigs: list[RigView]
    machines: list[MachineView]


class SpecimenView(Answer):
    """Properties of a specimen that need no physics; lengths in metres."""

    model_config = ConfigDict(extra="allow")
    nodes: int
    yarn_length_m: float
    fibre_radius_m: float
    clearance_m: float = Field(description="least distance between surfaces")
    gauge_lengths_m: dict[str, float] = Field(description="hook to hook, or between clamps or plates, along each axis")
    pins_m: dict[str, float] = Field(default={}, description="between the extensometer's pins, along each axis")
    locking_strain: float | None = Field(description="equibiaxial strain at which the yarn is used up (estimate)")
    clasps: dict[str, int] = Field(description="heads that hold a loop, by what is joined: rows, layers, chained edges")


class StrokeView(Answer):
    """One move of the axes."""

    model_config = ConfigDict(extra="allow")
    cycle: int
    phase: str
    tag: str | None
    start_m: dict[str, float]
    end_m: dict[str, float]
    duration_s: float


class BudgetView(Answer):
    """Strain of a protocol beside the strain at which a loop's yarn is used up."""

    largest: float = Field(description="largest strain that is planned")
    locking: float = Field(description="strain at which a loop has used up its yarn (estimate)")
    measure: str = Field(description="which strain both are", examples=["as equibiaxial strain"])


class PlanView(Answer):
    """What a protocol would do, without physics."""

    name: str
    rig: str
    specimen: SpecimenView
    strokes: list[StrokeView]
    duration_s: float
    rows: int
    log_bytes: float = Field(description="about how large the files of the log will be [bytes]")
    largest_strain: float | None
    budget: BudgetView | None
    fibre_strain: float | None = Field(
        description="largest strain of a fibre's surface, an estimate within a factor of 2"
    )
    warnings: list[str]
    defaults: dict[str, str] = Field(description="what holds though the protocol does not say it, by its place")


class JobView(Answer):
    """Present state of a job."""

    model_config = ConfigDict(
        frozen=True,
        from_attributes=True,
        json_schema_extra={
            "example": {
                "id": "3f2a9c0d41e65b78",
                "name": "biaxial_small",
                "state": "running",
                "created": "2026-01-31T09:00:00Z",
                "started": "2026-01-31T09:00:01Z",
                "finished": None,
                "attempts": 1,
                "end": None,
                "message": "",
                "progress": {
                    "share": 0.43,
                    "text": "Stretch 1: C 17.2%, W 17.2%",
                    "strain": {"C": 0.172, "W": 0.172},
                    "force": {"C": 0.31, "W": 0.36},
                    "seconds_left": 12.0,
                    "rows": 14,
                },
                "sweep": None,
                "wanted": None,
            }
        },
    )
    id: str
    name: str
    state: State = Field(description="a test that ruptured or overloaded has succeeded; `end` says how it ended")
    created: datetime
    started: datetime | None
    finished: datetime | None
    attempts: int = Field(description="how often its process was started")
    end: str | None = Field(description="target, rupture, unravelled, limit ...; of a failed job what stopped it")
    message: str
    progress: ProgressView
    sweep: str | None
    wanted: str | None = Field(description="`pause` while a running job has not stopped yet")


class JobPage(Answer):
    """Some jobs, newest first."""

    jobs: list[JobView]
    cursor: str | None = Field(description="what to ask for the next page with; nothing at the end")
    counts: dict[State, int] = Field(description="how many jobs there are in each state, of the sweep if one is named")


class ProtocolTextView(Answer):
    """The protocol of a job and the materials file that it names, as texts of YAML."""

    name: str
    protocol: str
    materials: str


class FileView(Answer):
    """A file of a job."""

    name: str = Field(description="its path within the job", examples=["run/biaxial_small.csv"])
    size: int = Field(description="bytes")
    kind: Literal["record", "log", "picture", "text"]


class FileList(Answer):
    """The files of a job."""

    files: list[FileView]


class Health(Answer):
    """The service answers."""

    status: Literal["ok"] = "ok"
    version: str


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI description of some errors of a route, and of those that any route may have."""
    what = {
        400: "The body cannot be read",
        401: "A token is needed",
        403: "The request comes from another site",
        404: "There is no such thing",
        408: "The request took too long",
        409: "Not there yet, or not ended yet",
        413: "The body is too large",
        415: "The body is of a kind that the route does not take",
        416: "The range is not in the file",
        422: "What was asked for is not valid, or beyond a bound",
        503: "Too many at once, or the service cannot keep its data for the moment",
        507: "The service has no room left",
    }
    schema = {"schema": {"$ref": "#/components/schemas/Problem"}}
    return {
        status: {"description": what[status], "content": {"application/problem+json": schema}}
        for status in sorted({401, 403, *statuses})
    }


JobId = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{1,64}$", examples=["3f2a9c0d41e65b78"])]

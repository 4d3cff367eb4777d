"""Pydantic models of the service's answers about sweeps."""

from datetime import datetime
from typing import Any

from pydantic import ConfigDict, Field

from app.service.api.models import JobView, PlanView
from app.service.api.progress import Answer
from app.service.jobs import State

Scalar = str | float | bool


class SweepView(Answer):
    """The jobs of a sweep."""

    sweep: str
    count: int
    jobs: list[JobView]


class PlannedPointView(Answer):
    """What one job of a sweep would do."""

    name: str
    values: dict[str, Scalar] = Field(description="values of the sweep's parameters")
    duration_s: float
    rows: int
    log_bytes: float


class SweepPlanView(Answer):
    """What a sweep would do, without physics."""

    count: int = Field(description="jobs that the sweep would be")
    looked_at: int = Field(description="of these the first that were looked at; the totals are estimated from them")
    duration_s: float = Field(description="time on the rig, all jobs together [s]")
    rows: int = Field(description="rows of all logs")
    log_bytes: float = Field(description="about how large the files of all logs will be [bytes]")
    points: list[PlannedPointView]
    first: PlanView = Field(description="the plan of the first job")


class SweepSummaryView(Answer):
    """A sweep and how far it is."""

    model_config = ConfigDict(frozen=True, from_attributes=True)
    id: str
    name: str = Field(description="name of its first job, without the number of the job")
    created: datetime
    counts: dict[State, int] = Field(description="how many of its jobs are in each state")


class SweepPageView(Answer):
    """Some sweeps, newest first."""

    sweeps: list[SweepSummaryView]
    cursor: str | None = Field(description="where the next page begins; null on the last")


class FigureView(Answer):
    """A figure of a test, SI units."""

    name: str
    value: float
    unit: str


class SweepPointView(Answer):
    """One job of a sweep: the values of its parameters, how far it is, and what its test came to."""

    job: JobView
    values: dict[str, Scalar] = Field(description="values of the sweep's parameters; empty of a list of protocols")
    figures: list[float | None] = Field(description="in the order of the table's `figures`; empty before its end")


class FigureName(Answer):
    """Name and unit of a figure."""

    name: str
    unit: str


class SweepTableView(Answer):
    """A sweep with its jobs in the order in which they were accepted."""

    sweep: SweepSummaryView
    parameters: list[str] = Field(description="names of the parameters that it varies")
    figures: list[FigureName] = Field(description="figures of the jobs on this page")
    points: list[SweepPointView]
    cursor: str | None = Field(description="where the next page begins; null on the last")


def table_of(sweep: Any, found: list[tuple[Any, Any, list[dict[str, Any]]]], cursor: str | None) -> SweepTableView:  # noqa: ANN401 (a sweep of the store)
    """Return the table of a sweep from its jobs, their specifications and figures."""
    units: dict[str, str] = {}
    for _, _, figures in found:
        units |= {one["name"]: one["unit"] for one in figures}
    points = []
    for job, spec, figures in found:
        values = {one["name"]: one["value"] for one in figures}
        row = [values.get(name) for name in units] if figures else []
        points.append(SweepPointView(job=JobView.model_validate(job), values=dict(spec.point), figures=row))
    return SweepTableView(
        sweep=SweepSummaryView.model_validate(sweep),
        parameters=list(dict.fromkeys(name for _, spec, _ in found for name in spec.point)),
        figures=[FigureName(name=name, unit=unit) for name, unit in units.items()],
        points=points,
        cursor=cursor,
    )

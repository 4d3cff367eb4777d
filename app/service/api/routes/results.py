"""Routes of what a job's test came to: its report, and a measured file over it."""

from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import quote

from anyio.to_thread import run_sync
from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse
from pydantic import Field

from app.file_names import file_stem
from app.records.reader import RunReader
from app.schemas.measured import alignment_of, with_lengths
from app.service.api.bodies import read_bytes, require_kind
from app.service.api.compared import compared
from app.service.api.context import Here
from app.service.api.growing_record import read_record, sections_of
from app.service.api.models import JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.progress import Answer
from app.service.api.row_curves import row_curves
from app.service.api.sweep_models import FigureView
from app.service.folder import JobFolder
from knitlab_core.errors import FormatError, SpecificationError
from rigs.axes import Axis
from rigs.readers.mapping import FileMapping

router = APIRouter(prefix="/v1/jobs/{job}", tags=["results"])

#: A page without scripts; opened from the service it may still do nothing.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; sandbox"
_TABLES = ("text/csv", "text/plain", "text/tab-separated-values")
_TEXT = {"schema": {"type": "string"}}
_TABLE = {**_TEXT, "example": "Time [s],Load [N],Extension [mm]\n0,0,0\n1,0.2,1\n2,0.6,2\n"}

Quantity = Annotated[str | None, Query(max_length=32, examples=["45 mm"])]


class CurveView(Answer):
    """A curve of a comparison, SI units."""

    name: str
    axis: str
    measured: bool
    part: Literal["loading", "unloading", "mean", "low", "high", "repeat"]
    x: list[float]
    y: list[float]


class ScoreView(Answer):
    """A figure of a test in a comparison, SI units; of repeats a mean with the least and the largest."""

    name: str
    axis: str
    cycle: int
    figure: str
    value: float
    unit: str
    low: float | None
    high: float | None


class ComparisonView(Answer):
    """A measured file over the test of a job: what is compared over what, the curves, the scores."""

    across: Literal["strain", "travel"]
    along: Literal["stress", "force"]
    curves: list[CurveView]
    scores: list[ScoreView]


class CurvesView(Answer):
    """Curves of a test from its equilibria as columns, SI units; of long ones what can be seen."""

    rows: int = Field(description="equilibria that there are")
    section: dict[str, float] = Field(description="area that carries each axis")
    time: list[float]
    cycle: list[int]
    strain: dict[str, list[float]]
    force: dict[str, list[float]]
    stress: dict[str, list[float]]


class FigureList(Answer):
    """What a test came to."""

    figures: list[FigureView]


@router.get("/curves", summary="Fetch the curves of a job", responses=problems(404, 409, 422))
def curves(job: JobId, here: Here) -> CurvesView:
    """Return strain, force and stress of the driven axes, also of a test that goes on.

    Of more than about 4000 equilibria the lowest and highest of every stretch are kept.
    """
    folder = here.store.folder(job)
    return CurvesView.model_validate(row_curves(JobFolder(folder).rows_file, read_record(folder, sections_of)))


@router.get("/figures", summary="Fetch the figures of a job", responses=problems(404, 409, 422))
def figures(job: JobId, here: Here) -> FigureList:
    """Return moduli, loop areas, energies and cost of a test that has ended, SI units."""
    found = JobFolder(here.store.folder(job)).figures()
    if found is None:
        raise ProblemError("not-ready", "figures: found none yet, allowed when the test has ended")
    return FigureList.model_validate({"figures": found})


@router.get(
    "/report",
    summary="Fetch the report of a job",
    response_class=HTMLResponse,
    responses={200: {"description": "The page", "content": {"text/html": _TEXT}}, **problems(404, 409, 422, 503)},
)
async def report(job: JobId, here: Here) -> HTMLResponse:
    """Return protocol, specimen, curves, results, pictures and what was assumed as one page by itself."""
    record = await run_sync(here.store.folder, job) / "run" / "run.h5"
    with here.drawing.line():
        async with here.drawing.turn(1.0):
            name, page = await run_sync(_reported, record, limiter=here.drawing.limiter)
    headers = {
        # As RFC 8187 encodes it: no name can end the header, or start another.
        "Content-Disposition": f"attachment; filename*=utf-8''{quote(file_stem(name), safe='')}_report.html",
        "Content-Security-Policy": _POLICY,
        "Cache-Control": "no-cache",
    }
    return HTMLResponse(page, headers=headers)


def _reported(record: Path) -> tuple[str, str]:
    """Return the name of a test and its report."""
    from app.views.report.page import report_page  # noqa: PLC0415 (matplotlib: only where something is drawn)

    try:
        run = RunReader(record)
    except (FileNotFoundError, FormatError) as error:
        raise ProblemError("not-ready", "report: found no record yet, allowed when the test has begun") from error
    return str(run.provenance.get("name", "job")), report_page([run])


@router.post(
    "/compare",
    summary="Lay a measured file over the test of a job",
    responses=problems(400, 404, 408, 409, 413, 415, 422, 503),
    openapi_extra={
        "requestBody": {
            "required": True,
            "description": "The file as an instrument writes it: text between commas, semicolons or tabs.",
            "content": dict.fromkeys(_TABLES, _TABLE),
        }
    },
)
async def compare(
    job: JobId,
    here: Here,
    request: Request,
    *,
    name: Annotated[str, Query(max_length=200, description="What the file is called.")] = "measured.csv",
    axis: Annotated[Axis | None, Query(description="That axis alone; a file that names none is of it.")] = None,
    cycle: Annotated[int, Query(ge=1, le=100_000, description="Which cycle of each.")] = 1,
    slack: Annotated[
        str | None, Query(max_length=32, description="Force from where strain counts, such as 50 mN.")
    ] = None,
    offset: Annotated[bool, Query(description="Whether force counts from its mean before the start.")] = False,
    gauge_length: Quantity = None,
    width: Quantity = None,
    thickness: Quantity = None,
) -> ComparisonView:
    """Return both curves with NRMSE, secants and loops, as `knitlab compare` does; nothing is kept."""
    record = await run_sync(here.store.folder, job) / "run" / "run.h5"
    require_kind(request, _TABLES)
    try:
        mapping, how = (
            with_lengths(FileMapping(), gauge_length, width, thickness),
            alignment_of(cycle, slack, offset=offset),
        )
    except SpecificationError as error:
        parameter = error.field.removeprefix("--").replace("-", "_")
        detail = f"{parameter}: found {error.found}, allowed {error.expected}"
        raise ProblemError("invalid-request", detail, errors=[{"parameter": parameter, "detail": detail}]) from error
    with here.comparing.line():
        content = await read_bytes(request, here.bounds.measured)
        if not record.exists():
            raise ProblemError("not-ready", "record: found none yet, allowed when the test has begun")
        async with here.comparing.turn(len(content)):
            found = await run_sync(
                lambda: compared(content, name, record, mapping, how, axis), limiter=here.comparing.limiter
            )
    return ComparisonView.model_validate(found)

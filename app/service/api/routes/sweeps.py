"""Routes of sweeps: many jobs, all accepted or none, and what they came to."""

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any, TypeVar

from anyio.to_thread import run_sync
from fastapi import APIRouter, Depends, Query, Request

from app.service.api.bodies import parse_json, read_raw
from app.service.api.bounds import Bounds
from app.service.api.context import Here, context_of
from app.service.api.documents import SWEEP_BODY
from app.service.api.models import JobView, problems
from app.service.api.problems import ProblemError
from app.service.api.routes.query_params import Asked, Cursor, Key, SweepId
from app.service.api.sweep_models import (
    SweepPageView,
    SweepPlanView,
    SweepSummaryView,
    SweepTableView,
    SweepView,
    table_of,
)
from app.service.api.sweeping import planned_sweep, swept
from app.service.folder import JobFolder
from app.service.jobs import JobSpec

router = APIRouter(tags=["jobs"])

Found = TypeVar("Found")


async def _looked_at(request: Request, at: Callable[[Any, Bounds], Found]) -> Found:
    """Return the result of a look at the sweep in the body of a request, which waits for its turn."""
    here = context_of(request)
    bounds = here.bounds
    with here.sweeping.line():
        raw = await read_raw(request, bounds.sweep_body)
        if raw.kind != "json":
            raise ProblemError("media-type", "content-type: found YAML, allowed application/json")
        async with here.sweeping.turn(len(raw.text)):
            return await run_sync(lambda: at(parse_json(raw.text), bounds), limiter=here.sweeping.limiter)


async def sweep_body(request: Request) -> list[JobSpec]:
    """Return the jobs of a sweep from the body of a request."""
    return await _looked_at(request, swept)


@router.post(
    "/v1/sweeps",
    summary="Submit a sweep",
    status_code=202,
    responses=problems(400, 408, 413, 415, 422, 503, 507),
    openapi_extra=SWEEP_BODY,
)
def submit_sweep(
    specs: Annotated[list[JobSpec], Depends(sweep_body)], here: Here, asked: Asked, *, key: Key = None
) -> SweepView:
    """Accept every job of a sweep, or none: one that is not valid refuses the whole.

    A protocol's `params` over lists of values, every combination a job, the last name fastest; or a list of protocols.
    Query parameters apply to each job.
    """
    limits = asked.model_dump()
    jobs = here.store.submit_all([replace(spec, **limits) for spec in specs], key=key)
    return SweepView(sweep=str(jobs[0].sweep), count=len(jobs), jobs=[JobView.model_validate(job) for job in jobs])


@router.post(
    "/v1/sweeps:validate",
    summary="Say what a sweep would do, without physics",
    responses=problems(400, 408, 413, 415, 422, 503),
    openapi_extra=SWEEP_BODY,
)
async def validate_sweep(request: Request) -> SweepPlanView:
    """Return how many jobs a sweep would be, their values, time on the rig and logs; or what is wrong.

    Of a large sweep the first 100 jobs are looked at; all are when it is submitted.
    """
    return SweepPlanView.model_validate(await _looked_at(request, planned_sweep))


@router.get("/v1/sweeps", summary="List sweeps, newest first", responses=problems(422))
def list_sweeps(
    here: Here,
    limit: Annotated[int, Query(ge=1, le=1000, description="Most sweeps to return.")] = 50,
    cursor: Cursor = None,
) -> SweepPageView:
    """Return a page of sweeps, each with how many of its jobs are in each state, and the cursor of the next."""
    page = here.store.sweeps(limit, cursor)
    return SweepPageView(sweeps=[SweepSummaryView.model_validate(one) for one in page.sweeps], cursor=page.cursor)


@router.get("/v1/sweeps/{sweep}", summary="Show a sweep as a table", responses=problems(404, 422))
def get_sweep(
    sweep: SweepId,
    here: Here,
    limit: Annotated[int, Query(ge=1, le=1000, description="Most jobs to return.")] = 200,
    cursor: Cursor = None,
) -> SweepTableView:
    """Return the jobs of a sweep, first to last: parameter values, state, and the figures of those that ended."""
    whole = here.store.sweep(sweep)
    page = here.store.points(sweep, limit, cursor)
    found = [(job, spec, JobFolder(here.store.folder(job.id)).figures() or []) for job, spec in page.points]
    return table_of(whole, found, page.cursor)

"""Routes of sweeps: many jobs, all accepted or none."""

from dataclasses import replace
from typing import Annotated

from anyio.to_thread import run_sync
from fastapi import APIRouter, Depends, Request

from app.service.api.bodies import parse_json, read_raw
from app.service.api.context import Here, context_of
from app.service.api.documents import SWEEP_BODY
from app.service.api.models import JobView, SweepView, problems
from app.service.api.problems import ProblemError
from app.service.api.routes.query_params import Asked, Key
from app.service.api.sweeping import swept
from app.service.jobs import JobSpec

router = APIRouter(prefix="/v1/sweeps", tags=["jobs"])


async def sweep_body(request: Request) -> list[JobSpec]:
    """Return the jobs of a sweep from the body of a request."""
    here = context_of(request)
    bounds = here.bounds
    with here.sweeping.line():
        raw = await read_raw(request, bounds.sweep_body)
        if raw.kind != "json":
            raise ProblemError("media-type", "content-type: found YAML, allowed application/json")
        async with here.sweeping.turn(len(raw.text)):
            return await run_sync(lambda: swept(parse_json(raw.text), bounds), limiter=here.sweeping.limiter)


@router.post(
    "",
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

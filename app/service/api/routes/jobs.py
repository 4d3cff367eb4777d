"""Routes of jobs: submit, show, cancel, pause, resume, delete."""

import hashlib
from collections.abc import Callable
from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from app.checks.dry_run import count_rows
from app.schemas import Loaded
from app.service.api.bodies import as_yaml
from app.service.api.bounds import Bounds, check_rows
from app.service.api.checking import look
from app.service.api.context import Here
from app.service.api.documents import PROTOCOL_BODY
from app.service.api.etags import has_tag
from app.service.api.models import JobId, JobPage, JobView, ProtocolTextView, problems
from app.service.api.routes.laboratory import Sent
from app.service.api.routes.query_params import Asked, Cursor, Key
from app.service.jobs import Job, JobSpec, State

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])


def _runnable(loaded: Loaded, bounds: Bounds) -> Loaded:
    """Return a protocol, after a check that it can be run.

    Raises
    ------
    ProblemError
        For one that is not valid, or whose log would be too long.
    """
    check_rows(count_rows(loaded), bounds)
    return loaded


@router.post(
    "",
    summary="Submit a protocol",
    status_code=202,
    responses={
        202: {"headers": {"Location": {"description": "Path of the job.", "schema": {"type": "string"}}}},
        **problems(400, 408, 413, 415, 422, 503, 507),
    },
    openapi_extra=PROTOCOL_BODY,
)
async def submit(sent: Sent, here: Here, response: Response, asked: Asked, *, key: Key = None) -> JobView:
    """Accept a protocol as a job; it is not lost from here on. The same key with another body is refused."""
    loaded = await look(here, sent, _runnable)
    # What files beside it say is written into the protocol, which then needs none; any other stays verbatim.
    spec = JobSpec(
        name=loaded.protocol.name, protocol=loaded.text, materials=loaded.beside(sent.materials), **asked.model_dump()
    )
    job = await run_sync(lambda: here.store.submit(spec, key=key))
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return JobView.model_validate(job)


@router.get("", summary="List jobs, newest first", responses=problems(422))
def list_jobs(
    here: Here,
    limit: Annotated[int, Query(ge=1, le=1000, description="Most jobs to return.")] = 50,
    cursor: Cursor = None,
    state: Annotated[State | None, Query(description="Only jobs in this state.")] = None,
    sweep: Annotated[
        str | None, Query(pattern=r"^[A-Za-z0-9_-]{1,64}$", description="Only jobs of this sweep.")
    ] = None,
) -> JobPage:
    """Return a page of jobs, and the cursor of the next."""
    page = here.store.list(limit, cursor, state, sweep)
    jobs = [JobView.model_validate(job) for job in page.jobs]
    return JobPage(jobs=jobs, cursor=page.cursor, counts=here.store.counts(sweep))


@router.get(
    "/{job}",
    summary="Show a job",
    response_model=JobView,
    responses={
        200: {"headers": {"ETag": {"description": "Changes with the job.", "schema": {"type": "string"}}}},
        304: {"description": "Nothing changed"},
        **problems(404, 422),
    },
)
def get_job(job: JobId, here: Here, request: Request) -> Any:  # noqa: ANN401 (a job, or that nothing changed)
    """Return a job; with `If-None-Match` only if it changed."""
    body = JobView.model_validate(here.store.get(job)).model_dump_json().encode()
    tag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    headers = {"ETag": tag, "Cache-Control": "no-cache"}
    if has_tag(request.headers.get("if-none-match", ""), tag):
        return Response(status_code=304, headers=headers)
    return Response(body, media_type="application/json", headers=headers)


@router.get("/{job}/protocol", summary="Fetch the protocol of a job", responses=problems(404, 422))
def get_protocol(job: JobId, here: Here) -> ProtocolTextView:
    """Return the texts that were submitted; a protocol that came as JSON, or was made by a sweep, as YAML."""
    spec = here.store.spec(job)
    return ProtocolTextView(name=spec.name, protocol=as_yaml(spec.protocol), materials=spec.materials)


@router.delete("/{job}", summary="Delete a job", status_code=204, responses=problems(404, 409, 422))
def delete(job: JobId, here: Here) -> Response:
    """Delete a job that has ended, and its files, for good; cancel one that has not."""
    here.store.delete(job)
    return Response(status_code=204)


def _answer(act: Callable[[str], Job], job: str) -> JobView:
    """Return the answer to a change of a job."""
    return JobView.model_validate(act(job))


_ASKED: dict[str, Any] = {"status_code": 202, "responses": problems(404, 422)}


@router.post("/{job}/cancel", summary="Cancel a job", **_ASKED)
def cancel(job: JobId, here: Here) -> JobView:
    """Ask a job to end. It is `cancelling` until its process has stopped; a finished job stays as it is."""
    return _answer(here.store.cancel, job)


@router.post("/{job}/pause", summary="Pause a job", **_ASKED)
def pause(job: JobId, here: Here) -> JobView:
    """Pause a queued or running job at its checkpoint; any other stays as it is."""
    return _answer(here.store.pause, job)


@router.post("/{job}/resume", summary="Let a paused job go on", **_ASKED)
def resume(job: JobId, here: Here) -> JobView:
    """Queue a paused job again; any other stays as it is."""
    return _answer(here.store.resume, job)

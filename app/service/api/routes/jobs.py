"""Answer what is asked of jobs: submit, look, cancel, pause, resume."""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Request
from fastapi.responses import Response

from app.check import dry_run
from app.service.api.bodies import Submission
from app.service.api.bounds import Bounds, check_plan, check_protocol
from app.service.api.context import Here
from app.service.api.documents import PROTOCOL_BODY
from app.service.api.models import JobId, JobPage, JobView, problems
from app.service.api.routes.laboratory import Sent
from app.service.jobs import GIBIBYTE, Job, JobSpec, State

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_DAY = 86400.0

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        pattern=r"^[\x21-\x7e]{1,200}$",
        description="Tells a submission that is sent again from a new one.",
        examples=["5c1f0a86-9d1b-4a51-8f0e-2b7d3a7b9f10"],
    ),
]
Timeout = Annotated[
    float | None,
    Query(gt=0.0, le=30 * _DAY, description="Longest time that the job may run [s].", examples=[3600.0]),
]
Memory = Annotated[
    int,
    Query(ge=GIBIBYTE // 4, le=1024 * GIBIBYTE, description="Most memory that its process may hold [bytes]."),
]


def spec_of(sent: Submission, bounds: Bounds) -> JobSpec:
    """Return what a job shall do, once it is sure that it can.

    Raises
    ------
    ProblemError
        For a protocol that is not valid, or too large.
    """
    loaded = sent.load()
    check_protocol(loaded.protocol, bounds)
    check_plan(dry_run(loaded), bounds)
    return JobSpec(name=loaded.protocol.name, protocol=sent.text, materials=sent.materials)


@router.post(
    "",
    summary="Submit a protocol",
    status_code=202,
    responses={
        202: {"headers": {"Location": {"description": "Path of the job.", "schema": {"type": "string"}}}},
        **problems(400, 408, 413, 415, 422),
    },
    openapi_extra=PROTOCOL_BODY,
)
def submit(
    sent: Sent,
    here: Here,
    response: Response,
    *,
    key: Key = None,
    timeout: Timeout = None,
    memory: Memory = 8 * GIBIBYTE,
    pictures: Annotated[bool, Query(description="Whether to draw the plot and the knit too.")] = True,
) -> JobView:
    """Accept a protocol as a job; it is not lost from here on. The same key with another body is refused."""
    spec = spec_of(sent, here.bounds)
    asked = replace(spec, timeout=timeout, memory=memory, pictures=pictures)
    job = here.store.submit(asked, key=key)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return JobView.model_validate(job)


@router.get("", summary="List jobs, newest first", responses=problems(422))
def list_jobs(
    here: Here,
    limit: Annotated[int, Query(ge=1, le=1000, description="Most jobs to return.")] = 50,
    cursor: Annotated[str | None, Query(pattern=r"^[0-9]{1,18}$", description="Cursor of the page before.")] = None,
    state: Annotated[State | None, Query(description="Only jobs in this state.")] = None,
    sweep: Annotated[
        str | None, Query(pattern=r"^[A-Za-z0-9_-]{1,64}$", description="Only jobs of this sweep.")
    ] = None,
) -> JobPage:
    """Return a page of jobs, and the cursor of the next."""
    page = here.store.list(limit, cursor, state, sweep)
    return JobPage(jobs=[JobView.model_validate(job) for job in page.jobs], cursor=page.cursor)


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
    if _matches(request.headers.get("if-none-match", ""), tag):
        return Response(status_code=304, headers=headers)
    return Response(body, media_type="application/json", headers=headers)


def _matches(wanted: str, tag: str) -> bool:
    """Tell whether a list of tags has one, weak or strong (RFC 9110, 13.1.2)."""
    return any(one.strip().removeprefix("W/") in {tag, "*"} for one in wanted.split(","))


def _answer(act: Callable[[str], Job], job: str) -> JobView:
    """Ask something of a job."""
    return JobView.model_validate(act(job))


_ASKED: dict[str, Any] = {"status_code": 202, "responses": problems(404, 422)}


@router.post("/{job}/cancel", summary="Cancel a job", **_ASKED)
def cancel(job: JobId, here: Here) -> JobView:
    """Ask a job to end. It is `cancelling` until its process has stopped; a finished job stays as it is."""
    return _answer(here.store.cancel, job)


@router.post("/{job}/pause", summary="Pause a job", **_ASKED)
def pause(job: JobId, here: Here) -> JobView:
    """Ask a queued or running job to rest at its checkpoint; any other stays as it is."""
    return _answer(here.store.pause, job)


@router.post("/{job}/resume", summary="Let a paused job go on", **_ASKED)
def resume(job: JobId, here: Here) -> JobView:
    """Queue a paused job again; any other stays as it is."""
    return _answer(here.store.resume, job)

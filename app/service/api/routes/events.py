"""Route of a job's event stream."""

from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import APIRouter, Header, Request
from fastapi.responses import Response, StreamingResponse

from app.service.api.context import Here
from app.service.api.head_requests import asks_head
from app.service.api.metrics import metrics_of
from app.service.api.models import JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.streams import EventStream, Seen, job_events

router = APIRouter(prefix="/v1/jobs/{job}", tags=["jobs"])

# The form that OpenAPI 3.2 gives to a stream of events.
_EVENT = {
    "type": "object",
    "required": ["event", "data", "id"],
    "properties": {
        "event": {"enum": ["rows", "progress", "state"]},
        "data": {"type": "string", "contentMediaType": "application/json"},
        "id": {"type": "string"},
    },
}
_EXAMPLE = """\
event: rows
data: {"first": 0, "rows": [{"row": 0, "time": 0.0, "strain": {"C": 0.0, "W": 0.0}, "force": {"C": 0.0, "W": 0.0}}]}
id: 1-none-0

event: progress
data: {"share": 0.05, "text": "Stretch 1: C 1.2%, W 1.2%", "seconds_left": 12.0, "rows": 1}
id: 1-none-500

event: state
data: {"id": "3f2a9c0d41e65b78", "name": "biaxial_small", "state": "running"}
id: 1-running-500

"""


@router.get(
    "/events",
    summary="Follow a job",
    response_class=StreamingResponse,
    responses={
        200: {"content": {"text/event-stream": {"itemSchema": _EVENT, "example": _EXAMPLE}}},
        204: {"description": "The job has ended, and the client has seen all of it"},
        **problems(404, 422, 503),
    },
)
async def events(
    job: JobId,
    here: Here,
    request: Request,
    last: Annotated[
        str,
        Header(alias="Last-Event-ID", max_length=64, description="Id of the last event seen; what followed comes."),
    ] = "",
) -> Any:  # noqa: ANN401 (a stream, or nothing)
    """Send server-sent events: `rows` (new equilibria), `progress` and `state`, to the job's end.

    The first events are what is known already; with `Last-Event-ID` only what came since. The last event is the
    state in which the job ended.
    """
    metrics = metrics_of(request)
    seen = Seen.read(last)
    found = await run_sync(here.store.get, job)
    if seen.over and found.state == seen.state:
        return Response(status_code=204)
    if asks_head(request):
        return StreamingResponse(iter(()), media_type=EventStream.media_type)
    if not metrics.take_stream(here.bounds.streams):
        detail = f"event streams: found {here.bounds.streams} open, allowed {here.bounds.streams} or fewer"
        raise ProblemError("busy", detail, headers={"Retry-After": "5"})
    return EventStream(job_events(here, job, seen), metrics.give_stream)

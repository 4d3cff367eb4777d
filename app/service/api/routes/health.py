"""Routes for monitoring: health and metrics."""

from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest

from app.service.api.context import Here
from app.service.api.guard import admit
from app.service.api.metrics import metrics_of
from app.service.api.models import Health, problems
from app.version import version_of

router = APIRouter(tags=["health"])


@router.get("/healthz", summary="Say that the service answers")
async def healthz() -> Health:
    """Return the version; needs no token, and no thread that a slow request could hold."""
    return Health(version=version_of("knitlab"))


@router.get(
    "/metrics",
    summary="Figures for Prometheus",
    dependencies=[Depends(admit)],
    response_class=Response,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}, **problems()},
)
def metrics(request: Request, here: Here) -> Response:
    """Return counts of requests, of jobs by state and of open event streams."""
    found = metrics_of(request)
    for state, count in here.store.counts().items():
        found.jobs.labels(state).set(count)
    return Response(generate_latest(found.registry), media_type=CONTENT_TYPE_LATEST)

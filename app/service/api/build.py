"""Assembly of the web app: routes, errors, guard, documentation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fastapi import Depends, FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.responses import HTMLResponse

from app.extensions import load_extensions
from app.service.api.documents import protocol_schemas
from app.service.api.faults import add_fault_handlers
from app.service.api.guard import admit
from app.service.api.head_requests import AnswerHead
from app.service.api.metrics import CountRequests, Metrics
from app.service.api.models import Problem
from app.service.api.pages import Console, documentation
from app.service.api.problems import add_problem_handlers
from app.service.api.routes import events, files, frames, health, jobs, laboratory, library, results, sweeps
from app.version import version_of

if TYPE_CHECKING:
    from app.service.api.context import Context

CONSOLE: Final = Path(__file__).parents[1] / "console"
"""Static files that are shown at `/`, where there are any."""

_DESCRIPTION: Final = """\
A virtual laboratory for the mechanics of knits. A job is one protocol on one specimen.
Errors are `application/problem+json` (RFC 9457) with a JSON pointer, and the line of the YAML where there is one.
"""


def create_app(context: Context) -> FastAPI:
    """Return the app of a service.

    Parameters
    ----------
    context : Context
        What its routes need.
    """
    load_extensions()
    app = FastAPI(
        title="knitlab", version=version_of("knitlab"), description=_DESCRIPTION, docs_url=None, redoc_url=None
    )
    app.state.context = context
    app.state.metrics = Metrics()
    app.add_middleware(CountRequests, metrics=app.state.metrics)
    app.add_middleware(AnswerHead)
    add_problem_handlers(app)
    add_fault_handlers(app)
    app.include_router(health.router)
    for part in (laboratory, library, jobs, sweeps, events, files, frames, results):
        app.include_router(part.router, dependencies=[Depends(admit)])
    app.openapi = lambda: _openapi(app, guarded=context.token is not None)  # type: ignore[method-assign]  # FastAPI's own way to extend it
    app.get("/docs", include_in_schema=False, response_class=HTMLResponse)(documentation)
    if CONSOLE.is_dir():
        app.mount("/", Console(directory=CONSOLE, html=True), name="console")
    return app


def _openapi(app: FastAPI, *, guarded: bool) -> dict[str, Any]:
    """Return the OpenAPI document, with the schema of protocols and of problems among its components."""
    if app.openapi_schema is None:
        made = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
        schemas = made.setdefault("components", {}).setdefault("schemas", {})
        problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas |= {**problem.pop("$defs"), "Problem": problem, **protocol_schemas()}
        # What FastAPI answers of itself is a problem here, and so described.
        for path in made["paths"].values():
            for operation in path.values():
                _describe_errors(operation)
                if not guarded:
                    operation.pop("security", None)
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        app.openapi_schema = made
    return app.openapi_schema


def _describe_errors(operation: dict[str, Any]) -> None:
    """Document the real form of the answer to invalid parameters."""
    answer = operation.get("responses", {}).get("422")
    if answer is not None and "application/problem+json" not in answer.get("content", {}):
        schema = {"schema": {"$ref": "#/components/schemas/Problem"}}
        answer["description"] = "What was asked for is not valid"
        answer["content"] = {"application/problem+json": schema}

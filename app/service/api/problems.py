"""Errors of requests in the form of RFC 9457, never with a stack trace.

A module of our own: what libraries offer wraps pydantic's errors, while a protocol's have their pointer and line.
"""

from __future__ import annotations

import json
import re
from http import HTTPStatus
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from starlette.exceptions import HTTPException
from starlette.routing import Match, Mount

from app.schemas import ProtocolError
from app.schemas.errors import SweptProtocolError
from app.service.jobs import KeyReusedError, NotEndedError, UnknownJobError, UnknownSweepError
from knitlab_core.errors import KnitlabError, SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from fastapi import FastAPI, Request

MEDIA_TYPE: Final = "application/problem+json"
MOST_MISTAKES: Final = 20
"""Mistakes in a protocol that one answer names."""

_PART: Final = re.compile(r"[^.\[\]]+")


class Kind(NamedTuple):
    """Kind of problem: its status and title."""

    status: int
    title: str


KINDS: Final[Mapping[str, Kind]] = MappingProxyType(
    {
        "malformed": Kind(400, "The body cannot be read"),
        "unauthorised": Kind(401, "A token is needed"),
        "forbidden": Kind(403, "Not from there"),
        "unknown": Kind(404, "There is no such thing"),
        "too-slow": Kind(408, "The request took too long"),
        "not-ready": Kind(409, "Not there yet"),
        "not-ended": Kind(409, "The job has not ended"),
        "too-large": Kind(413, "The body is too large"),
        "media-type": Kind(415, "The body is of another kind"),
        "range": Kind(416, "The range is not in the file"),
        "invalid-protocol": Kind(422, "The protocol is not valid"),
        "swept": Kind(422, "The protocol is a sweep"),
        "invalid-request": Kind(422, "The request is not valid"),
        "beyond-bound": Kind(422, "Beyond a bound of this service"),
        "key-used": Kind(422, "The idempotency key stands for another body"),
        "busy": Kind(503, "Too many at once"),
        "away": Kind(503, "The service cannot keep its data for the moment"),
        "full": Kind(507, "The service has no room left"),
    }
)
"""What can go wrong, by the last part of the problem's type, `urn:knitlab:problem:...`."""


class ProblemError(Exception):
    """A request is refused.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    detail : str
        One line for the user.
    errors : sequence of mapping
        What is wrong where: `detail`, and `pointer`, `line`, `column` or `parameter` where there is one.
    headers : mapping
        To go with the answer.
    """

    def __init__(
        self,
        kind: str,
        detail: str,
        *,
        errors: Sequence[Mapping[str, object]] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(kind, detail)
        self.kind, self.detail, self.errors, self.headers = kind, detail, errors, headers


def beyond(bound: str, found: object, allowed: int, *, pointer: str = "", kind: str = "beyond-bound") -> ProblemError:
    """Return the problem of a request beyond a bound of the service.

    Examples
    --------
    >>> beyond("nodes", 3000000, 200000).detail
    'nodes: found 3000000, allowed 200000 or fewer'
    """
    detail = f"{bound}: found {found}, allowed {allowed} or fewer"
    return ProblemError(kind, detail, errors=[{"detail": detail, "pointer": pointer, "bound": allowed}])


def pointer_of(field: str) -> str:
    """Return the JSON pointer (RFC 6901) of a field as errors write it.

    Examples
    --------
    >>> pointer_of("steps[3].ramp.rate"), pointer_of("protocol")
    ('/steps/3/ramp/rate', '')
    """
    if field == "protocol":
        return ""
    parts = (part.replace("~", "~0").replace("/", "~1") for part in _PART.findall(field))
    return "".join(f"/{part}" for part in parts)


def refused(error: SpecificationError, *, lined: bool, path: str = "") -> ProblemError:
    """Return the problem of a protocol: JSON pointers, and lines and columns where the user wrote text.

    Parameters
    ----------
    error : SpecificationError
        What is wrong.
    lined : bool
        Whether lines and columns of the protocol's text are the user's own.
    path : str
        Name in place of its file; a mistake in another file is told with the name of that.
    """
    if isinstance(error, SweptProtocolError):
        # What else its text says is for the command line.
        detail = f"sweep: found {error.found}, allowed one test; POST /v1/sweeps takes a sweep"
        return ProblemError("swept", detail, errors=[{**_place(error, lined=lined, path=path), "detail": detail}])
    places = [_place(one, lined=lined, path=path) for one in [error, *error.more][:MOST_MISTAKES]]
    first, detail = places[0], _detail(error)
    if "line" in first:
        spot = f"line {first['line']}, column {first['column']}"
        detail = f"{first['file']}, {spot}: {detail}" if "file" in first else f"{spot}: {detail}"
    return ProblemError("invalid-protocol", detail, errors=places)


def _detail(error: SpecificationError) -> str:
    """Return what is wrong, without its place in a text."""
    return _one_line(f"{error.field or 'protocol'}: found {error.found}, allowed {error.expected}")


def _place(error: SpecificationError, *, lined: bool, path: str) -> dict[str, object]:
    """Return what is wrong, and where."""
    place: dict[str, object] = {"detail": _detail(error), "pointer": pointer_of(error.field)}
    beside = isinstance(error, ProtocolError) and path not in ("", error.path)
    if isinstance(error, ProtocolError) and (lined or beside):
        place |= {"line": error.spot.line, "column": error.spot.column}
    return {**place, "file": error.path} if isinstance(error, ProtocolError) and beside else place


def problem_response(
    status: int,
    title: str,
    detail: str,
    path: str,
    *,
    kind: str | None = None,
    errors: Sequence[Mapping[str, object]] = (),
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Return the response of a problem; without a kind its type is `about:blank`."""
    body: dict[str, Any] = {
        "type": "about:blank" if kind is None else f"urn:knitlab:problem:{kind}",
        "title": title,
        "status": status,
        "detail": _one_line(detail),
        "instance": path,
    }
    if errors:
        body["errors"] = list(errors)
    # ASCII alone: what a user sent may hold halves of characters that UTF-8 cannot write.
    return Response(json.dumps(body), status_code=status, media_type=MEDIA_TYPE, headers=dict(headers or {}))


def add_problem_handlers(app: FastAPI) -> None:
    """Register handlers that answer every error of an app as a problem."""
    app.add_exception_handler(ProblemError, on_problem)
    app.add_exception_handler(KnitlabError, _on_knitlab_error)
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(HTTPException, _on_http)
    app.add_exception_handler(Exception, _on_anything)


async def on_problem(request: Request, error: Exception) -> Response:
    """Answer a refusal."""
    if not isinstance(error, ProblemError):
        return await _on_anything(request, error)
    kind = KINDS[error.kind]
    return problem_response(
        kind.status,
        kind.title,
        error.detail,
        request.url.path,
        kind=error.kind,
        errors=error.errors,
        headers=error.headers,
    )


async def _on_knitlab_error(request: Request, error: Exception) -> Response:
    """Answer errors that the user caused; any other is ours, and raised again."""
    if isinstance(error, UnknownJobError | UnknownSweepError):
        return await on_problem(request, ProblemError("unknown", str(error)))
    if isinstance(error, NotEndedError):
        return await on_problem(request, ProblemError("not-ended", str(error)))
    if isinstance(error, KeyReusedError):
        return await on_problem(request, ProblemError("key-used", str(error)))
    if isinstance(error, SpecificationError):
        return await on_problem(request, refused(error, lined=True))
    return await _on_anything(request, error)


async def _on_invalid(request: Request, error: Exception) -> Response:
    """Answer parameters that the route does not allow."""
    if not isinstance(error, RequestValidationError):
        return await _on_anything(request, error)
    # What was found is left out: it may be anything, and the user has it.
    places = [{"parameter": str(one["loc"][-1]), "detail": _one_line(str(one["msg"]))} for one in error.errors()]
    detail = "; ".join(f"{place['parameter']}: {place['detail']}" for place in places)
    return await on_problem(request, ProblemError("invalid-request", detail, errors=places))


def _methods(request: Request) -> list[str]:
    """Return the methods that a request's path allows; none if it is no route's."""
    routes = [route for route in request.app.routes if not isinstance(route, Mount)]
    known = [
        method
        for method in ("GET", "POST", "DELETE")
        if any(route.matches({**request.scope, "method": method})[0] is Match.FULL for route in routes)
    ]
    return ["GET", "HEAD", *known[1:]] if "GET" in known else known


async def _on_http(request: Request, error: Exception) -> Response:
    """Answer errors of the framework: unknown path, method that is not allowed."""
    if not isinstance(error, HTTPException):
        return await _on_anything(request, error)
    status, detail, headers = error.status_code, str(error.detail), dict(error.headers or {})
    # Paths without a route reach the static files of the console, which allow no other method.
    if methods := _methods(request):
        status, headers["Allow"] = HTTPStatus.METHOD_NOT_ALLOWED, ", ".join(methods)
        detail = f"method: found {request.method}, allowed {headers['Allow']}"
    else:
        status, detail = HTTPStatus.NOT_FOUND, "path: found no such route, allowed those that /docs lists"
    title = HTTPStatus(status).phrase
    return problem_response(status, title, detail, request.url.path, headers=headers)


async def _on_anything(request: Request, error: Exception) -> Response:
    """Answer an error of ours: the trace goes to the log, one line to the client."""
    del error
    return problem_response(500, "Internal error", "the service failed; its log says how", request.url.path)


def _one_line(text: str) -> str:
    """Return a text on one line, without control characters, of bounded length."""
    plain = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    return plain if len(plain) <= 1000 else f"{plain[:1000]}..."

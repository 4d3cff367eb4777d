"""Answers to faults of disk and database: 507 where there is no room, 503 for the others."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from app.records.storage import FULL, fault_of
from app.service.api.problems import ProblemError, on_problem
from app.service.tables import AWAY, first_line

if TYPE_CHECKING:
    from fastapi import FastAPI, Request
    from fastapi.responses import Response

AGAIN: Final = 5
"""When a client may ask again [s]."""

_FULL_IN_WORDS: Final = ("database or disk is full", "no space left on device", "could not extend file")
"""Messages of SQLite and PostgreSQL where there is no room."""

_log: Final = logging.getLogger(__name__)


def add_fault_handlers(app: FastAPI) -> None:
    """Register handlers that answer faults of disk and database as problems."""
    for kind in (*AWAY, OSError):
        app.add_exception_handler(kind, _on_fault)


async def _on_fault(request: Request, error: Exception) -> Response:
    """Answer a fault; any other error is raised again, to be logged.

    Raises
    ------
    OSError
        If it is none of the host's.
    """
    number = fault_of(error)
    if isinstance(error, OSError) and number is None:
        raise error
    said = first_line(error)
    _log.error("%s %s: %s", request.method, request.url.path, said)
    if number in FULL or any(words in said.lower() for words in _FULL_IN_WORDS):
        problem = ProblemError("full", "storage: found no room, allowed when its keeper has made some")
    else:
        detail = f"storage: cannot be used for the moment, allowed again in some seconds; asked again after {AGAIN} s"
        problem = ProblemError("away", detail, headers={"Retry-After": str(AGAIN)})
    return await on_problem(request, problem)

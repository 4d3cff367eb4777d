"""HEAD for every route that answers GET, with the same headers (RFC 9110, 9.3.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fastapi import Request
    from starlette.types import ASGIApp, Receive, Scope, Send

_ASKED = "knitlab.head"


class AnswerHead:
    """ASGI middleware that passes HEAD to an app as GET; the server does not send the body.

    Parameters
    ----------
    app : ASGIApp
        What answers.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "http" and scope["method"] == "HEAD":
            scope = {**scope, "method": "GET", _ASKED: True}
        await self.app(scope, receive, send)


def asks_head(request: Request) -> bool:
    """Return whether a request is HEAD, so that a long body need not be made."""
    return _ASKED in request.scope

"""Answer HEAD wherever GET is answered, with the same headers (RFC 9110, 9.3.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fastapi import Request
    from starlette.types import ASGIApp, Receive, Scope, Send

_ASKED = "knitlab.head"


class AnswerHead:
    """Ask an app for what GET would answer; the server itself sends no body to who asks by HEAD.

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
    """Tell whether the body of an answer will not be sent, so that a long one need not be made."""
    return _ASKED in request.scope

"""Access control: this machine alone, or clients with the token."""

import hashlib
import hmac
from typing import Annotated
from urllib.parse import urlsplit

from fastapi import Depends, Request
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from app.service.address import is_loopback
from app.service.api.connections import AGAIN, admitted
from app.service.api.context import context_of
from app.service.api.problems import ProblemError
from knitlab_core.errors import SpecificationError

_BEARER = HTTPBearer(auto_error=False, description="the token that the service was started with")


def same_token(given: str, wanted: str) -> bool:
    """Compare two tokens in a time that reveals neither where they differ nor their lengths."""
    return hmac.compare_digest(*(hashlib.sha256(one.encode(errors="replace")).digest() for one in (given, wanted)))


def require_token_for(host: str, token: str | None) -> None:
    """Raise if the service would listen to other machines without a token.

    Raises
    ------
    SpecificationError
        If the address is not this machine's own and there is no token.
    """
    if token is not None and not token.strip():
        raise SpecificationError("token", token, "a text that is not empty")
    if token is None and not is_loopback(host):
        raise SpecificationError("host", host, "a loopback address, or also --token (or KNITLAB_TOKEN)")


async def admit(
    request: Request, credentials: Annotated[HTTPAuthorizationCredentials | None, Depends(_BEARER)]
) -> None:
    """Admit a request, or raise why it is refused.

    Without a token the service is for this machine alone: a page of another site must reach it neither under a name
    of its own that points here (`Host`) nor by a form or a script (`Origin`).

    Raises
    ------
    ProblemError
        For a wrong token, a foreign host or a foreign page, or one connection too many.
    """
    token = context_of(request).token
    if token is not None:
        if credentials is None or not same_token(credentials.credentials, token):
            raise ProblemError(
                "unauthorised", "found no valid token, allowed: Authorization: Bearer TOKEN", headers=_CHALLENGE
            )
    else:
        _require_this_machine(request)
    if (full := admitted(request)) is not None:
        raise ProblemError("busy", full, headers={"Retry-After": str(AGAIN), "Connection": "close"})


def _require_this_machine(request: Request) -> None:
    """Refuse a request that does not come from this machine, or from a page of another site.

    Raises
    ------
    ProblemError
        For a foreign host or a foreign page.
    """
    host = request.headers.get("host", "")
    if not is_loopback(_name_of(host)):
        raise ProblemError("forbidden", "host: found another name, allowed localhost, or a service with a token")
    origin = request.headers.get("origin")
    # A page of this service has its host and port behind the scheme.
    if origin is not None and origin.partition("://")[2] != host:
        raise ProblemError("forbidden", "origin: found a page of another site, allowed pages of this service")


_CHALLENGE = {"WWW-Authenticate": "Bearer"}


def _name_of(host: str) -> str:
    """Return the name or address in a Host header, without port and brackets."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""

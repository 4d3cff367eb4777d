"""Objects that every route needs."""

from dataclasses import dataclass, field
from threading import Event
from typing import Annotated

from anyio import CapacityLimiter
from fastapi import Depends, Request

from app.service.api.bounds import Bounds
from app.service.api.concurrency import Turns
from app.service.jobs import JobStore


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """Objects that every route needs.

    Attributes
    ----------
    store : JobStore
        The jobs.
    token : str or None
        What a client must show; None for a service that this machine alone can reach.
    bounds : Bounds
        What one request may ask for.
    thinking : CapacityLimiter
        Threads for looks at small protocols, so that those that answer all else stay free.
    checking, sweeping, drawing, comparing : Turns
        Turns to look at a large protocol, to look at a sweep, to draw a picture, to read a measured file.
    closing : Event
        Set when the service is about to stop: streams end, their clients come again.
    """

    store: JobStore
    token: str | None = None
    bounds: Bounds = field(default_factory=Bounds)
    thinking: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(4))
    checking: Turns = field(
        default_factory=lambda: Turns(what="other large protocols are being looked at", again=10, patience=30.0)
    )
    # A client that retries waits here, and takes no processor from its first request.
    sweeping: Turns = field(default_factory=lambda: Turns(what="other sweeps are being looked at", again=30))
    # Drawing takes hundreds of MB too.
    drawing: Turns = field(
        default_factory=lambda: Turns(what="other pictures are being drawn", again=10, patience=30.0)
    )
    comparing: Turns = field(
        default_factory=lambda: Turns(what="other measured files are being read", again=10, patience=30.0)
    )
    closing: Event = field(default_factory=Event)


def context_of(request: Request) -> Context:
    """Return the context of the service that a request came to."""
    found = request.app.state.context
    if not isinstance(found, Context):
        raise TypeError("an app without a context")
    return found


Here = Annotated[Context, Depends(context_of)]
"""The context, as a parameter of a route."""

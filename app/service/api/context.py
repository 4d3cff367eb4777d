"""Hold what every route needs."""

from dataclasses import dataclass, field
from threading import Event
from typing import Annotated

from anyio import CapacityLimiter
from fastapi import Depends, Request

from app.service.api.bounds import Bounds
from app.service.jobs import JobStore


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """Hold what every route needs.

    Attributes
    ----------
    store : JobStore
        The jobs.
    token : str or None
        What a client must show; None for a service that this machine alone can reach.
    bounds : Bounds
        What one request may ask for.
    thinking, sweeping, drawing : CapacityLimiter
        Turns for what takes seconds of a processor: to look at a protocol, at a sweep, to draw a picture. Who waits for
        one holds no thread, so that the threads that answer all else stay free.
    closing : Event
        Set when the service is about to stop: streams end, their clients come again.
    """

    store: JobStore
    token: str | None = None
    bounds: Bounds = field(default_factory=Bounds)
    thinking: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(4))
    sweeping: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(1))
    # Drawing takes hundreds of MB too: one picture at a time.
    drawing: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(1))
    closing: Event = field(default_factory=Event)


def context_of(request: Request) -> Context:
    """Return the context of the service that a request came to."""
    found = request.app.state.context
    if not isinstance(found, Context):
        raise TypeError("an app without a context")
    return found


Here = Annotated[Context, Depends(context_of)]
"""The context, as a parameter of a route."""

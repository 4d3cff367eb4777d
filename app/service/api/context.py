"""Hold what every route needs."""

from dataclasses import dataclass, field
from typing import Annotated

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
    """

    store: JobStore
    token: str | None = None
    bounds: Bounds = field(default_factory=Bounds)


def context_of(request: Request) -> Context:
    """Return the context of the service that a request came to."""
    found = request.app.state.context
    if not isinstance(found, Context):
        raise TypeError("an app without a context")
    return found


Here = Annotated[Context, Depends(context_of)]
"""The context, as a parameter of a route."""

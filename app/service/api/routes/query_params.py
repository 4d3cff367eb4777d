"""Query parameters of a submission: its key, and the limits of its jobs."""

from typing import Annotated

from fastapi import Depends, Header, Path, Query
from pydantic import BaseModel, ConfigDict

from app.service.jobs import GIBIBYTE

_DAY = 86400.0

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        pattern=r"^[\x21-\x7e]{1,200}$",
        description="Tells a submission that is sent again from a new one.",
        examples=["5c1f0a86-9d1b-4a51-8f0e-2b7d3a7b9f10"],
    ),
]
Timeout = Annotated[
    float | None,
    Query(gt=0.0, le=30 * _DAY, description="Longest time that a job may run [s].", examples=[3600.0]),
]
Memory = Annotated[
    int,
    Query(ge=GIBIBYTE // 4, le=1024 * GIBIBYTE, description="Most memory that a job's process may hold [bytes]."),
]
Pictures = Annotated[bool, Query(description="Whether to draw the plot and the knit too.")]


SweepId = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{1,64}$", examples=["5c1f0a869d1b"])]
Cursor = Annotated[str | None, Query(pattern=r"^[0-9]{1,18}$", description="Cursor of the page before.")]


class Limits(BaseModel):
    """Limits of each job of a submission, by the names of `JobSpec`."""

    model_config = ConfigDict(frozen=True)
    timeout: float | None
    memory: int
    pictures: bool


def _limits(*, timeout: Timeout = None, memory: Memory = 8 * GIBIBYTE, pictures: Pictures = True) -> Limits:
    """Return the limits in the query of a submission."""
    return Limits(timeout=timeout, memory=memory, pictures=pictures)


Asked = Annotated[Limits, Depends(_limits)]

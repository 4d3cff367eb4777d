"""Checks of protocols in threads: small ones at once, large ones one at a time, so that they block no others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeVar

from anyio.to_thread import run_sync

from app.service.api.bounds import Bounds, check_protocol, node_count
from rigs.protocol.protocol import stroke_count

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.schemas import Loaded
    from app.service.api.bodies import Submission
    from app.service.api.concurrency import Turns
    from app.service.api.context import Context
    from rigs.protocol.protocol import Protocol

Found = TypeVar("Found")

LARGE: Final = 0.3
"""Time from which on a look at a protocol counts as large [s of a processor]."""

_CHARACTERS, _NODES, _STROKES = 5e4, 1e5, 5e3
"""How much of each is looked at in a second of a processor."""


async def look(
    here: Context, sent: Submission, at: Callable[[Loaded, Bounds], Found], *, turns: Turns | None = None
) -> Found:
    """Return the result of a check of a protocol, once it is known to be within the bounds.

    Parameters
    ----------
    here : Context
        The bounds, and the threads for small protocols.
    sent : Submission
        The protocol.
    at : callable
        What looks at it, in a thread.
    turns : Turns or None
        Turns to wait for; None waits for one only if the protocol is large.

    Raises
    ------
    ProblemError
        For a protocol that is not valid or too large, or if too many wait for their turns.
    """
    cost, loaded = sent.size / _CHARACTERS, None
    if cost < LARGE:
        loaded = await run_sync(_load, sent, here.bounds, limiter=here.thinking)
        cost += _checking_time(loaded.protocol)
        if turns is None and cost < LARGE:
            return await run_sync(at, loaded, here.bounds, limiter=here.thinking)
    turns = turns or here.checking
    with turns.line():
        async with turns.turn(cost):
            return await run_sync(lambda: at(loaded or _load(sent, here.bounds), here.bounds), limiter=turns.limiter)


def _load(sent: Submission, bounds: Bounds) -> Loaded:
    """Return a protocol that is within the bounds."""
    loaded = sent.load()
    check_protocol(loaded.protocol, bounds)
    return loaded


def _checking_time(protocol: Protocol) -> float:
    """Estimate the time to build a protocol's knit and to go through its strokes [s]."""
    return node_count(protocol.specimen) / _NODES + stroke_count(protocol.steps) / _STROKES

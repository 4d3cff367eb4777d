"""Event streams of a job: new rows, progress, state.

Nothing is kept for a client. An event's id names what the client has seen, so that one that comes back goes on from
there, and the files of the job are the memory. The next event is made when the last one has been sent.
"""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass, replace
from time import monotonic
from typing import TYPE_CHECKING, Final

import anyio
from anyio.to_thread import run_sync
from fastapi.responses import StreamingResponse
from fastapi.sse import KEEPALIVE_COMMENT, format_sse_event

from app.service.api.models import JobView
from app.service.api.rows import NewRows
from app.service.jobs import FINAL, UnknownJobError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from typing import Any

    from starlette.types import Message, Receive, Scope, Send

    from app.service.api.context import Context
    from app.service.jobs import Job

PERIOD: Final = 0.5
"""How often a job is looked at [s]."""

QUIET: Final = 15.0
"""Longest silence on a stream [s]."""

STALLED: Final = 60.0
"""How long a client may take nothing before it is dropped [s]."""

_ID: Final = re.compile(r"(\d{1,9})-([a-z]{1,16})-(\d{1,5})")


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What a client has received: number of rows, state, share of the protocol done [1e-4]."""

    rows: int = 0
    state: str = "none"
    share: int = 0

    @classmethod
    def read(cls, text: str) -> Seen:
        """Parse an event's id; an unknown one means nothing received.

        Examples
        --------
        >>> Seen.read("12-running-4300") == Seen(rows=12, state="running", share=4300)
        True
        >>> Seen.read("who knows") == Seen()
        True
        """
        match = _ID.fullmatch(text)
        return cls() if match is None else cls(rows=int(match[1]), state=match[2], share=int(match[3]))

    @property
    def id(self) -> str:
        """Return the event id."""
        return f"{self.rows}-{self.state}-{self.share}"

    @property
    def over(self) -> bool:
        """Return whether the stream is complete."""
        return self.state in FINAL


async def job_events(here: Context, job: str, seen: Seen) -> AsyncIterator[bytes]:
    """Yield the events of a job to its end or the service's, from what a client has received.

    Parameters
    ----------
    here : Context
        The jobs, and whether the service is about to stop.
    job : str
        The job's id.
    seen : Seen
        What need not be sent again.
    """
    folder = await run_sync(here.store.folder, job)
    rows = NewRows(folder / "rows.jsonl", seen.rows)
    last = monotonic()
    while True:
        # The state first: when a job has ended, all its rows are written.
        try:
            now = await run_sync(here.store.get, job)
        except UnknownJobError:  # deleted meanwhile
            return
        while found := await run_sync(rows.read):
            seen = replace(seen, rows=rows.number)
            yield _event("rows", {"first": rows.number - len(found), "rows": found}, seen)
            last = monotonic()
        for kind, new in _news(now, seen):
            seen = new
            data = asdict(now.progress) if kind == "progress" else JobView.model_validate(now).model_dump(mode="json")
            yield _event(kind, data, seen)
            last = monotonic()
        if seen.over or here.closing.is_set():
            return
        if monotonic() - last > QUIET:
            yield KEEPALIVE_COMMENT
            last = monotonic()
        await anyio.sleep(PERIOD)


def _news(job: Job, seen: Seen) -> list[tuple[str, Seen]]:
    """Return the events that a client has not received, each with its state after it."""
    news = []
    share = round(1e4 * min(1.0, max(0.0, job.progress.share)))
    if share != seen.share:
        seen = replace(seen, share=share)
        news.append(("progress", seen))
    if job.state != seen.state:
        news.append(("state", replace(seen, state=job.state)))
    return news


def _event(kind: str, data: dict[str, Any], seen: Seen) -> bytes:
    """Return an event as bytes."""
    return format_sse_event(event=kind, data_str=json.dumps(data), id=seen.id)


class EventStream(StreamingResponse):
    """Streaming response of events; a client that does not read is dropped.

    Parameters
    ----------
    events : async iterator of bytes
        The events.
    done : callable
        Called when the stream has ended, however.
    """

    media_type = "text/event-stream"

    def __init__(self, events: AsyncIterator[bytes], done: Callable[[], None]) -> None:
        super().__init__(events, headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})
        self._done = done

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the events."""

        async def send_in_time(message: Message) -> None:
            with anyio.fail_after(STALLED):
                await send(message)

        try:
            await super().__call__(scope, receive, send_in_time)
        except* TimeoutError:
            # The client disconnected; it can reconnect and continue from the last event.
            pass
        finally:
            self._done()

"""Limits on connections: how many may be open, and how long each may take to send its request.

A connection waits until a request on it is let in (a valid token, or none is asked for); then it is admitted. Waiting
and admitted ones are counted apart, in all and for each address, so that connections without a token take no place
from those that have one. When too many wait the oldest is closed, not the newest: who has a token shows it at once.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass, field
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address, ip_network
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from app.service.api.problems import KINDS, MEDIA_TYPE

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from fastapi import Request
    from uvicorn.config import Config
    from uvicorn.protocols.http.h11_impl import RequestResponseCycle
    from uvicorn.server import ServerState

BATCH: Final = 32
"""Connections that are accepted before those accepted before them are read."""

AGAIN: Final = 5
"""When a client that found too many connections may come again [s]."""

STALLED: Final = 60.0
"""How long a client may take nothing of an answer before it is dropped [s]."""

_ADMIT: Final = "knitlab.admit"


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits on the connections of a service.

    Attributes
    ----------
    connections, per_address : int
        Admitted connections at a time, in all and from one address; half as many may wait beside them.
    header_timeout : float
        Time from the first byte of a request, or from the connection, to the end of the request's header [s].
    idle_timeout : int
        Time that a connection may rest between two requests [s].
    """

    connections: int = 400
    per_address: int = 200
    header_timeout: float = 10.0
    idle_timeout: int = 30

    @property
    def files(self) -> int:
        """Return the most files that connections have open, including those about to be closed."""
        return self.connections + max(1, self.connections // 2) + 4 * BATCH


def connections_within(files: int) -> int:
    """Return how many connections may be admitted for a limit on open files.

    Examples
    --------
    >>> [Limits(connections=connections_within(1000) + more).files for more in (0, 1)]
    [999, 1001]
    """
    return max(0, (2 * (files - 4 * BATCH) + 1) // 3)


@dataclass(slots=True, kw_only=True)
class _Group:
    """Connections in the order of their arrival, counted by address."""

    most: int
    most_each: int
    members: dict[Guarded, None] = field(default_factory=dict)
    each: Counter[str] = field(default_factory=Counter)

    def add(self, one: Guarded) -> None:
        self.members[one] = None
        self.each[one.address] += 1

    def discard(self, one: Guarded) -> None:
        if one in self.members:
            del self.members[one]
            self.each[one.address] -= 1
            if not self.each[one.address]:
                del self.each[one.address]


class ConnectionLimiter:
    """Counter of the connections of a service.

    Parameters
    ----------
    limits : Limits
        How many there may be.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.waiting = _Group(most=max(1, limits.connections // 2), most_each=max(1, limits.per_address // 2))
        self.admitted = _Group(most=limits.connections, most_each=limits.per_address)

    def arrive(self, one: Guarded) -> None:
        """Register a new connection; close the oldest of its address, or of all, if there are too many."""
        self.waiting.add(one)
        # Two turns of the loop later, what the connection brought with it has been read: it may be admitted by then.
        one.loop.call_soon(one.loop.call_soon, self._trim, one)

    def _trim(self, latest: Guarded) -> None:
        """Close the oldest of too many waiting connections, but none that came after `latest`."""
        waiting = self.waiting
        same = waiting.each[latest.address] - waiting.most_each
        if same <= 0 and len(waiting.members) <= waiting.most:
            return
        old = [one for one in waiting.members if one.number <= latest.number]
        for one in [one for one in old if one.address == latest.address][: max(0, same)]:
            one.turn_out()
        for one in [one for one in old if one in waiting.members][: max(0, len(waiting.members) - waiting.most)]:
            one.turn_out()

    def asked(self, one: Guarded) -> None:
        """Register that a request is complete; if the connection waits, it is closed last."""
        if one in self.waiting.members:
            self.waiting.members[one] = self.waiting.members.pop(one)

    def admit(self, one: Guarded) -> str | None:
        """Admit a connection, or return why it is refused."""
        admitted = self.admitted
        if one in admitted.members:
            return None
        if admitted.each[one.address] >= admitted.most_each:
            return _too_many("connections of this address", admitted.most_each)
        if len(admitted.members) >= admitted.most:
            return _too_many("connections", admitted.most)
        self.waiting.discard(one)
        admitted.add(one)
        return None

    def leave(self, one: Guarded) -> None:
        """Remove a connection from the counts."""
        self.waiting.discard(one)
        self.admitted.discard(one)


class Guarded(H11Protocol):
    """HTTP connection with limits on its time."""

    limiter: ConnectionLimiter
    _numbers = count()

    def __init__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, {**app_state, _ADMIT: lambda: self.limiter.admit(self)}, _loop)
        self.number = next(self._numbers)
        self.address = ""
        self._header: asyncio.TimerHandle | None = None
        self._stall: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as its base
        """Start the time limit for a request."""
        super().connection_made(transport)
        self.address = network_of(self.client[0]) if self.client else ""
        self._header = self.loop.call_later(self.limiter.limits.header_timeout, self._too_slow)
        self.limiter.arrive(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Remove the connection from the counts."""
        self.limiter.leave(self)
        self._forget_header()
        self._forget_stall()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read on; a header sent slowly has no more time than one that is not sent."""
        super().data_received(data)
        if self._answering():
            self._forget_header()
            self.limiter.asked(self)
        elif self._header is None and not self.transport.is_closing():
            self._header = self.loop.call_later(self.limiter.limits.header_timeout, self._too_slow)

    def pause_writing(self) -> None:
        """Start the time limit of a client that does not read."""
        super().pause_writing()
        self._stall = self.loop.call_later(STALLED, self.transport.abort)

    def resume_writing(self) -> None:
        """Continue an answer."""
        super().resume_writing()
        self._forget_stall()

    def turn_out(self) -> None:
        """Close a waiting connection to make room for others."""
        self.limiter.leave(self)
        if self._answering():
            # What has been sent of the answer may never be taken: it is not waited for.
            self.transport.abort()
        else:
            waiting = self.limiter.waiting
            allowed = f"allowed {waiting.most_each} from one address and {waiting.most} in all"
            self._close("busy", f"connections that no request was let in on: found too many, {allowed}", AGAIN)

    def _too_slow(self) -> None:
        """Close a connection whose request did not arrive in time."""
        self._close("too-slow", f"allowed {self.limiter.limits.header_timeout:g} s for the header of a request")

    def _close(self, kind: str, detail: str, again: int | None = None) -> None:
        """Close a connection; one that has begun a request gets an error first."""
        if self.transport.is_closing():
            return
        if self.conn.our_state is h11.IDLE and self.conn.trailing_data[0]:
            self.transport.write(_last_answer(kind, detail, again))
        self.transport.close()

    def _answering(self) -> bool:
        """Return whether a complete request is still being answered."""
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is not None and not cycle.response_complete

    def _forget_header(self) -> None:
        if self._header is not None:
            self._header.cancel()
            self._header = None

    def _forget_stall(self) -> None:
        if self._stall is not None:
            self._stall.cancel()
            self._stall = None


def watched_by(limiter: ConnectionLimiter) -> type[Guarded]:
    """Return the protocol factory of limited connections, for uvicorn."""

    class Watched(Guarded):
        pass

    Watched.limiter = limiter
    return Watched


def admitted(request: Request) -> str | None:
    """Admit the connection of a request, or return the error that there is no room."""
    admit: Callable[[], str | None] | None = request.scope.get("state", {}).get(_ADMIT)
    return None if admit is None else admit()


def network_of(host: str) -> str:
    """Return the network of a client: its IPv4 address, or the first 64 bits of its IPv6 address.

    Examples
    --------
    >>> network_of("192.0.2.7"), network_of("::ffff:192.0.2.7"), network_of("2001:db8::1:2"), network_of("a name")
    ('192.0.2.7', '192.0.2.7', '2001:db8::/64', 'a name')
    """
    try:
        address = ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if not isinstance(address, IPv6Address):
        return str(address)
    return str(address.ipv4_mapped or ip_network((address, 64), strict=False))


def _too_many(what: str, most: int) -> str:
    """Return the error of one connection too many."""
    return f"{what}: found {most} open, allowed {most} or fewer"


def _last_answer(kind: str, detail: str, again: int | None) -> bytes:
    """Return the bytes of an error answer for a request that was never complete."""
    status, title = KINDS[kind]
    problem = {"type": f"urn:knitlab:problem:{kind}", "title": title, "status": status, "detail": detail}
    body = json.dumps(problem).encode()
    lines = [
        f"HTTP/1.1 {status} {HTTPStatus(status).phrase}",
        f"Content-Type: {MEDIA_TYPE}",
        f"Content-Length: {len(body)}",
        *([] if again is None else [f"Retry-After: {again}"]),
        "Connection: close",
    ]
    return "\r\n".join([*lines, "", ""]).encode() + body

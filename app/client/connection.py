"""Requests to a service over HTTP, and what their answers say."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final
from uuid import uuid4

import httpx
from httpx_sse import EventSource, SSEError

from app.records.folder import whole_file
from app.service.errors import ServiceError, UnreachableError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from httpx_sse import ServerSentEvent

_TRIES: Final = 3
PAUSE: Final = 0.5
"""Between two tries [s]."""

_QUIET: Final = 60.0
"""Longest silence of an event stream [s]; the service sends a comment every 15 s."""


class Connection:
    """Connection to a service.

    Parameters
    ----------
    server : str
        Its address.
    token : str or None
        The token that it was started with.
    timeout : float
        How long an answer may take [s].

    Raises
    ------
    UnreachableError
        If address or token are none; by every method, if nobody answers.
    ServiceError
        By every method, if the service refuses or fails.
    """

    def __init__(self, server: str, token: str | None, timeout: float) -> None:
        self.server = server.rstrip("/")
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        try:
            self._http = httpx.Client(base_url=self.server, headers=headers, timeout=timeout)
        except (httpx.InvalidURL, UnicodeEncodeError) as error:
            raise UnreachableError(self.server, "not an address, or not a token, that HTTP knows") from error

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def post_once(
        self, path: str, body: object, key: str | None, asked: Mapping[str, str], *, patience: float = 0.0
    ) -> Any:  # noqa: ANN401 (what JSON holds)
        """Post a body under an idempotency key, and retry if the connection breaks: it is accepted once.

        Where an answer may take long, `patience` [s] goes before the timeout.
        """
        headers = {"Idempotency-Key": key or str(uuid4())}
        own = self._http.timeout
        given: dict[str, Any] = {"json": body, "headers": headers, "params": asked, "timeout": own}
        if own.read is not None and patience > own.read:
            given["timeout"] = httpx.Timeout(connect=own.connect, read=patience, write=own.write, pool=own.pool)
        for _ in range(_TRIES - 1):
            try:
                return self.json("POST", path, **given)
            except UnreachableError as error:
                if isinstance(error.__cause__, httpx.ConnectError):
                    raise
                time.sleep(PAUSE)
        return self.json("POST", path, **given)

    def json(self, method: str, path: str, **given: Any) -> Any:  # noqa: ANN401 (what JSON holds)
        """Return the JSON of an answer."""
        try:
            return self.send(method, path, **given).json()
        except ValueError as error:
            raise UnreachableError(self.server, "what answers is not knitlab") from error

    def send(self, method: str, path: str, **given: Any) -> httpx.Response:  # noqa: ANN401 (what a request may have)
        """Send a request and return the answer; raise if it is a refusal."""
        try:
            response = self._http.request(method, path, **given)
        except httpx.TransportError as error:
            raise UnreachableError(self.server, _reason(error)) from error
        _check(response)
        return response

    def fetch(self, path: str, target: Path, params: Mapping[str, str] | None = None, *, timeout: float = 0.0) -> Path:
        """Write an answer to a file, atomically; where it may take long, `timeout` [s] goes before the usual."""
        target.parent.mkdir(parents=True, exist_ok=True)
        limit: Any = {"timeout": timeout} if timeout else {}
        try:
            with self._http.stream("GET", path, params=params, **limit) as response:
                _check(response)
                with whole_file(target) as temporary, temporary.open("wb") as stream:
                    stream.writelines(response.iter_bytes())
        except httpx.TransportError as error:
            raise UnreachableError(self.server, _reason(error)) from error
        return target

    def events(self, path: str, last: str) -> Iterator[ServerSentEvent]:
        """Yield the events of a stream, from after that of id `last`."""
        headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
        try:
            with self._http.stream("GET", path, headers=headers, timeout=_QUIET) as response:
                _check(response)
                if response.status_code != httpx.codes.NO_CONTENT:
                    yield from EventSource(response).iter_sse()
        except (httpx.TransportError, SSEError) as error:
            raise UnreachableError(self.server, _reason(error)) from error


def _check(response: httpx.Response) -> None:
    """Raise if an answer is a refusal."""
    if response.is_success:
        return
    response.read()
    try:
        problem = response.json()
        detail, kind = str(problem["detail"]), str(problem.get("type", "")).rpartition(":")[2]
    except (ValueError, KeyError, TypeError, AttributeError):
        detail, kind = f"answer {response.status_code} without a reason", ""
    raise ServiceError(response.status_code, detail, kind)


def _reason(error: Exception) -> str:
    """Return the reason why a connection failed, in few words."""
    return (str(error) or type(error).__name__).lower()

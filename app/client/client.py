"""HTTP client of a service."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any, Final, Self
from urllib.parse import quote
from uuid import uuid4

import httpx
from httpx_sse import EventSource, SSEError

from app.client.answers import Event, File, Job, Page, file_of, job_of
from app.records.folder import whole_file
from app.service.address import DEFAULT_SERVER
from app.service.errors import ServiceError, UnreachableError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

_TRIES: Final = 3
_PAUSE: Final = 0.5
_LONG: Final = 600.0
"""How long the service may take to look at all jobs of a sweep [s]."""

_QUIET: Final = 60.0
"""Longest silence of an event stream [s]; the service sends a comment every 15 s."""


class Client:
    """Client of a knitlab service.

    Parameters
    ----------
    server : str
        Its address.
    token : str or None
        The token that it was started with.
    timeout : float
        How long an answer may take [s].
    patience : float
        How long `follow` waits for a service that is gone, and may be restarting [s].

    Raises
    ------
    UnreachableError
        By every method, if nobody answers.
    ServiceError
        By every method, if the service refuses or fails.
    """

    def __init__(
        self, server: str = DEFAULT_SERVER, token: str | None = None, *, timeout: float = 30.0, patience: float = 60.0
    ) -> None:
        self.server, self.patience = server.rstrip("/"), patience
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        try:
            self._http = httpx.Client(base_url=self.server, headers=headers, timeout=timeout)
        except (httpx.InvalidURL, UnicodeEncodeError) as error:
            raise UnreachableError(self.server, "not an address, or not a token, that HTTP knows") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def submit(
        self,
        protocol: str,
        *,
        name: str = "test",
        materials: str = "",
        key: str | None = None,
        timeout: float | None = None,
        memory: int | None = None,
        pictures: bool = True,
    ) -> Job:
        """Submit a protocol, once even if the connection breaks before the answer.

        Parameters
        ----------
        protocol : str
            Its YAML.
        name : str
            Name of a protocol that gives itself none.
        materials : str
            The YAML of the file that it names under `materials`.
        key : str or None
            What tells this submission from others; None makes one.
        timeout : float or None
            Longest time that the job may run [s]; None for no bound.
        memory : int or None
            Most memory that its process may hold [bytes]; None for what the service allows by itself.
        pictures : bool
            Whether to draw the plot and the knit too.
        """
        body = _envelope(protocol, name, materials)
        return job_of(self._post_once("/v1/jobs", body, key, _limits(timeout, memory, pictures=pictures)))

    def sweep(
        self,
        protocols: str | Sequence[str],
        *,
        values: Mapping[str, Sequence[str | float]] | None = None,
        name: str = "test",
        materials: str = "",
        key: str | None = None,
        timeout: float | None = None,
        memory: int | None = None,
        pictures: bool = True,
    ) -> tuple[Job, ...]:
        """Submit a sweep, once: all of its jobs or none. The service may take minutes over thousands of them.

        Parameters
        ----------
        protocols : str or sequence of str
            One protocol over values of its `params`, or many protocols; the first is read much faster.
        values : mapping of str to sequence, optional
            Values of each parameter, every combination a job; None for the `sweep:` of the protocol itself.
        name, materials, key, timeout, memory, pictures
            As of `submit`, for each job.
        """
        body: dict[str, Any]
        if isinstance(protocols, str):
            body = _envelope(protocols, name, materials)
            if values is not None:
                body["values"] = {parameter: list(listed) for parameter, listed in values.items()}
        else:
            body = {"protocols": [_envelope(protocol, name, materials) for protocol in protocols]}
        asked = _limits(timeout, memory, pictures=pictures)
        found = self._post_once("/v1/sweeps", body, key, asked, patience=_LONG)
        return tuple(job_of(one) for one in found["jobs"])

    def job(self, job: str) -> Job:
        """Return a job."""
        return job_of(self._json("GET", f"/v1/jobs/{_safe(job)}"))

    def jobs(
        self, *, limit: int = 50, cursor: str | None = None, state: str | None = None, sweep: str | None = None
    ) -> Page:
        """Return a page of jobs, newest first."""
        asked = {"limit": limit, "cursor": cursor, "state": state, "sweep": sweep}
        found = self._json("GET", "/v1/jobs", params={name: value for name, value in asked.items() if value})
        return Page(jobs=tuple(job_of(one) for one in found["jobs"]), cursor=found["cursor"])

    def cancel(self, job: str) -> Job:
        """Ask a job to end."""
        return job_of(self._json("POST", f"/v1/jobs/{_safe(job)}/cancel"))

    def pause(self, job: str) -> Job:
        """Pause a job at its checkpoint."""
        return job_of(self._json("POST", f"/v1/jobs/{_safe(job)}/pause"))

    def resume(self, job: str) -> Job:
        """Resume a paused job."""
        return job_of(self._json("POST", f"/v1/jobs/{_safe(job)}/resume"))

    def delete(self, job: str) -> None:
        """Delete a job that has ended, and its files."""
        self._send("DELETE", f"/v1/jobs/{_safe(job)}")

    def files(self, job: str) -> tuple[File, ...]:
        """Return the files of a job."""
        return tuple(file_of(one) for one in self._json("GET", f"/v1/jobs/{_safe(job)}/files")["files"])

    def download(self, job: str, name: str, path: Path) -> Path:
        """Fetch a file of a job to `path`, atomically."""
        return self._fetch(f"/v1/jobs/{_safe(job)}/files/{quote(name)}", path)

    def log(self, job: str, dialect: str, path: Path) -> Path:
        """Fetch the log of a job in a dialect."""
        return self._fetch(f"/v1/jobs/{_safe(job)}/log", path, {"dialect": dialect})

    def events(self, job: str, last: str = "") -> Iterator[Event]:
        """Yield the events of one connection, from after the event of id `last`."""
        headers = {"Accept": "text/event-stream", **({"Last-Event-ID": last} if last else {})}
        path = f"/v1/jobs/{_safe(job)}/events"
        try:
            with self._http.stream("GET", path, headers=headers, timeout=_QUIET) as response:
                _check(response)
                if response.status_code == httpx.codes.NO_CONTENT:
                    return
                for event in EventSource(response).iter_sse():
                    yield Event(kind=event.event, data=json.loads(event.data or "{}"), id=event.id)
        except (httpx.TransportError, SSEError) as error:
            raise UnreachableError(self.server, _reason(error)) from error

    def follow(self, job: str, last: str = "") -> Iterator[Event]:
        """Yield the events of a job to its end, over as many connections as that takes."""
        lost: float | None = None
        while True:
            try:
                for event in self.events(job, last):
                    last, lost = event.id, None
                    yield event
                    if event.kind == "state" and job_of(event.data).over:
                        return
                if self.job(job).over:
                    return
            except (UnreachableError, ServiceError) as error:
                passing = isinstance(error, UnreachableError) or error.status >= httpx.codes.INTERNAL_SERVER_ERROR
                lost = time.monotonic() if lost is None else lost
                if not passing or time.monotonic() - lost > self.patience:
                    raise
            time.sleep(_PAUSE)

    def _post_once(
        self, path: str, body: object, key: str | None, asked: Mapping[str, str], *, patience: float = 0.0
    ) -> Any:  # noqa: ANN401 (what JSON holds)
        """Post a body under an idempotency key, and retry if the connection breaks: it is accepted once.

        Where an answer may take long, `patience` [s] goes before the client's own.
        """
        headers = {"Idempotency-Key": key or str(uuid4())}
        own = self._http.timeout
        given: dict[str, Any] = {"json": body, "headers": headers, "params": asked, "timeout": own}
        if own.read is not None and patience > own.read:
            given["timeout"] = httpx.Timeout(connect=own.connect, read=patience, write=own.write, pool=own.pool)
        for _ in range(_TRIES - 1):
            try:
                return self._json("POST", path, **given)
            except UnreachableError as error:
                if isinstance(error.__cause__, httpx.ConnectError):
                    raise
                time.sleep(_PAUSE)
        return self._json("POST", path, **given)

    def _json(self, method: str, path: str, **given: Any) -> Any:  # noqa: ANN401 (what JSON holds)
        """Return the JSON of an answer."""
        try:
            return self._send(method, path, **given).json()
        except ValueError as error:
            raise UnreachableError(self.server, "what answers is not knitlab") from error

    def _send(self, method: str, path: str, **given: Any) -> httpx.Response:  # noqa: ANN401 (what a request may have)
        """Send a request and return the answer; raise if it is a refusal."""
        try:
            response = self._http.request(method, path, **given)
        except httpx.TransportError as error:
            raise UnreachableError(self.server, _reason(error)) from error
        _check(response)
        return response

    def _fetch(self, path: str, target: Path, params: Mapping[str, str] | None = None) -> Path:
        """Write an answer to a file, atomically."""
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            with self._http.stream("GET", path, params=params) as response:
                _check(response)
                with whole_file(target) as temporary, temporary.open("wb") as stream:
                    stream.writelines(response.iter_bytes())
        except httpx.TransportError as error:
            raise UnreachableError(self.server, _reason(error)) from error
        return target


def _envelope(protocol: str, name: str, materials: str) -> dict[str, Any]:
    """Return a protocol with its name and materials as the body of a request."""
    return {"protocol": protocol, "name": name, **({"materials": materials} if materials else {})}


def _limits(timeout: float | None, memory: int | None, *, pictures: bool) -> dict[str, str]:
    """Return the query parameters of a submission; those left out are the service's defaults."""
    asked = {} if timeout is None else {"timeout": repr(float(timeout))}
    asked |= {} if memory is None else {"memory": str(memory)}
    return asked if pictures else {**asked, "pictures": "false"}


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


def _safe(job: str) -> str:
    """Return an id quoted as one part of a path."""
    return quote(job, safe="")


def _reason(error: Exception) -> str:
    """Return the reason why a connection failed, in few words."""
    return (str(error) or type(error).__name__).lower()

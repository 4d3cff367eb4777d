"""HTTP client of a service."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any, Final, Self
from urllib.parse import quote

import httpx

from app.client.answers import Event, File, Job, JobComparison, Page, comparison_of, file_of, job_of
from app.client.connection import PAUSE, Connection
from app.service.address import DEFAULT_SERVER
from app.service.errors import ServiceError, UnreachableError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

_LONG: Final = 600.0
"""How long the service may take to look at all jobs of a sweep, or to draw a report [s]."""

_KINDS: Final = {".csv": "text/csv", ".tsv": "text/tab-separated-values"}


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
        self._service = Connection(server, token, timeout)
        self.server, self.patience = self._service.server, patience

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._service.close()

    def submit(
        self,
        protocol: str,
        *,
        name: str = "test",
        materials: str = "",
        files: Mapping[str, str] | None = None,
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
        files : mapping of str to str, optional
            Texts of the CSV files that it names, by their names.
        key : str or None
            What tells this submission from others; None makes one.
        timeout : float or None
            Longest time that the job may run [s]; None for no bound.
        memory : int or None
            Most memory that its process may hold [bytes]; None for what the service allows by itself.
        pictures : bool
            Whether to draw the plot and the knit too.
        """
        body = _envelope(protocol, name, materials, files)
        return job_of(self._service.post_once("/v1/jobs", body, key, _limits(timeout, memory, pictures=pictures)))

    def sweep(
        self,
        protocols: str | Sequence[str],
        *,
        values: Mapping[str, Sequence[str | float]] | None = None,
        name: str = "test",
        materials: str = "",
        files: Mapping[str, str] | None = None,
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
        name, materials, files, key, timeout, memory, pictures
            As of `submit`, for each job.
        """
        body: dict[str, Any]
        if isinstance(protocols, str):
            body = _envelope(protocols, name, materials, files)
            if values is not None:
                body["values"] = {parameter: list(listed) for parameter, listed in values.items()}
        else:
            body = {"protocols": [_envelope(protocol, name, materials, files) for protocol in protocols]}
        asked = _limits(timeout, memory, pictures=pictures)
        found = self._service.post_once("/v1/sweeps", body, key, asked, patience=_LONG)
        return tuple(job_of(one) for one in found["jobs"])

    def job(self, job: str) -> Job:
        """Return a job."""
        return job_of(self._service.json("GET", f"/v1/jobs/{_safe(job)}"))

    def jobs(
        self, *, limit: int = 50, cursor: str | None = None, state: str | None = None, sweep: str | None = None
    ) -> Page:
        """Return a page of jobs, newest first."""
        asked = {"limit": limit, "cursor": cursor, "state": state, "sweep": sweep}
        found = self._service.json("GET", "/v1/jobs", params={name: value for name, value in asked.items() if value})
        return Page(jobs=tuple(job_of(one) for one in found["jobs"]), cursor=found["cursor"])

    def cancel(self, job: str) -> Job:
        """Ask a job to end."""
        return job_of(self._service.json("POST", f"/v1/jobs/{_safe(job)}/cancel"))

    def pause(self, job: str) -> Job:
        """Pause a job at its checkpoint."""
        return job_of(self._service.json("POST", f"/v1/jobs/{_safe(job)}/pause"))

    def resume(self, job: str) -> Job:
        """Resume a paused job."""
        return job_of(self._service.json("POST", f"/v1/jobs/{_safe(job)}/resume"))

    def delete(self, job: str) -> None:
        """Delete a job that has ended, and its files."""
        self._service.send("DELETE", f"/v1/jobs/{_safe(job)}")

    def files(self, job: str) -> tuple[File, ...]:
        """Return the files of a job."""
        return tuple(file_of(one) for one in self._service.json("GET", f"/v1/jobs/{_safe(job)}/files")["files"])

    def download(self, job: str, name: str, path: Path) -> Path:
        """Fetch a file of a job to `path`, atomically."""
        return self._service.fetch(f"/v1/jobs/{_safe(job)}/files/{quote(name)}", path)

    def log(self, job: str, dialect: str, path: Path) -> Path:
        """Fetch the log of a job in a dialect."""
        return self._service.fetch(f"/v1/jobs/{_safe(job)}/log", path, {"dialect": dialect})

    def report(self, job: str, path: Path) -> Path:
        """Fetch the report of a job as one HTML page to `path`, atomically; of a test that goes on as far as it is."""
        return self._service.fetch(f"/v1/jobs/{_safe(job)}/report", path, timeout=_LONG)

    def compare(
        self,
        job: str,
        measured: Path,
        *,
        axis: str | None = None,
        cycle: int = 1,
        slack: str | None = None,
        offset: bool = False,
        gauge_length: str | None = None,
        width: str | None = None,
        thickness: str | None = None,
    ) -> JobComparison:
        """Lay a measured file over the test of a job: curves of both, and scores.

        Parameters
        ----------
        job : str
            Its id.
        measured : Path
            The file, as the instrument writes it: text between commas, semicolons or tabs.
        axis : str or None
            That axis alone; a file that names none is of it.
        cycle : int
            Which cycle of each.
        slack : str or None
            Force from where strain counts, ``"50 mN"``.
        offset : bool
            Whether force counts from its mean before the test begins to move.
        gauge_length, width, thickness : str or None
            What the file does not say itself, with units: ``"45 mm"``.

        Raises
        ------
        ServiceError
            If the file is no table, with its line; if the two cannot be compared; while the test has no rows.
        """
        asked = {
            "name": measured.name,
            "axis": axis,
            "cycle": str(cycle),
            "slack": slack,
            "offset": str(offset).lower(),
        }
        asked |= {"gauge_length": gauge_length, "width": width, "thickness": thickness}
        found = self._service.json(
            "POST",
            f"/v1/jobs/{_safe(job)}/compare",
            params={name: value for name, value in asked.items() if value is not None},
            content=measured.read_bytes(),
            headers={"Content-Type": _KINDS.get(measured.suffix.lower(), "text/plain")},
        )
        return comparison_of(found)

    def events(self, job: str, last: str = "") -> Iterator[Event]:
        """Yield the events of one connection, from after the event of id `last`."""
        for event in self._service.events(f"/v1/jobs/{_safe(job)}/events", last):
            yield Event(kind=event.event, data=json.loads(event.data or "{}"), id=event.id)

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
            time.sleep(PAUSE)


def _envelope(protocol: str, name: str, materials: str, files: Mapping[str, str] | None) -> dict[str, Any]:
    """Return a protocol with its name, materials and files as the body of a request."""
    beside = {"materials": materials, "files": dict(files or {})}
    return {"protocol": protocol, "name": name, **{kind: sent for kind, sent in beside.items() if sent}}


def _limits(timeout: float | None, memory: int | None, *, pictures: bool) -> dict[str, str]:
    """Return the query parameters of a submission; those left out are the service's defaults."""
    asked = {} if timeout is None else {"timeout": repr(float(timeout))}
    asked |= {} if memory is None else {"memory": str(memory)}
    return asked if pictures else {**asked, "pictures": "false"}


def _safe(job: str) -> str:
    """Return an id quoted as one part of a path."""
    return quote(job, safe="")

"""Jobs, and the interface of a store of jobs between API and queue."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal, Protocol, get_args

from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from datetime import datetime
    from pathlib import Path

State = Literal["queued", "running", "paused", "cancelling", "succeeded", "failed", "cancelled"]
STATES: Final[tuple[State, ...]] = get_args(State)
FINAL: Final[frozenset[State]] = frozenset({"succeeded", "failed", "cancelled"})
"""States that a job never leaves."""

GIBIBYTE: Final = 1024**3


class UnknownJobError(KnitlabError):
    """No job has this id."""

    def __init__(self, job: str) -> None:
        super().__init__(f"job {job!r}: there is none")
        self.job = job


class NotEndedError(KnitlabError):
    """A job that has not ended cannot be deleted."""

    def __init__(self, job: str, state: str) -> None:
        super().__init__(f"job {job!r}: found {state}, allowed succeeded, failed or cancelled; cancel it first")
        self.job = job


class KeyReusedError(KnitlabError):
    """An idempotency key came with another body before."""

    def __init__(self, key: str) -> None:
        super().__init__(f"idempotency key {key!r}: came with another body before; use a new key for a new job")
        self.key = key


@dataclass(frozen=True, slots=True, kw_only=True)
class JobSpec:
    """Specification of a job: protocol, name, materials, limits.

    Attributes
    ----------
    name : str
        Name of the protocol; its logs are named after it.
    protocol, materials : str
        Texts of the protocol and of the materials file it names, verbatim; the second may be empty.
    timeout : float or None
        Longest time that the job may run, all attempts together [s].
    memory : int or None
        Most memory that its process may hold [bytes].
    pictures : bool
        Whether the plot and the pictures of the knit are drawn; a large sweep may do without.
    point : mapping of str to scalar
        Values of the parameters that its sweep varies; empty of a job that is no point of one.
    """

    name: str
    protocol: str
    materials: str = ""
    timeout: float | None = None
    memory: int | None = 8 * GIBIBYTE
    pictures: bool = True
    point: Mapping[str, str | float | bool] = field(default_factory=dict)

    def text(self) -> str:
        """Return the specification as JSON."""
        return json.dumps({name: getattr(self, name) for name in sorted(self.__slots__)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a job.

    Attributes
    ----------
    share : float
        Share of the protocol that is done, 0 to 1.
    text : str
        What is being done, for people.
    strain : mapping of str to float
        Strain of every driven axis [1].
    force : mapping of str to float
        Force of every driven axis [N].
    seconds_left : float or None
        Estimate of the time to the end [s].
    rows : int
        Equilibria so far.
    crossings : sequence of mapping
        Where a fibre passed a limit of its material so far, as `LimitCrossing.data` gives it.
    losses : sequence of mapping
        Where clasps let go so far, as `ClaspLoss.data` gives it.
    """

    share: float = 0.0
    text: str = ""
    strain: Mapping[str, float] = field(default_factory=dict)
    force: Mapping[str, float] = field(default_factory=dict)
    seconds_left: float | None = None
    rows: int = 0
    crossings: Sequence[Mapping[str, Any]] = ()
    losses: Sequence[Mapping[str, Any]] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """State of a job at one moment.

    Attributes
    ----------
    id, name : str
        Its id in this store, and the name of its protocol.
    state : State
        A test that ruptured or overloaded has *succeeded*; `end` is how it ended.
    created, started, finished : datetime
        When it was accepted, first begun and ended, in UTC.
    attempts : int
        How often its process was started.
    end : str or None
        How the test ended (``target``, ``rupture``, ``limit`` ...); of a failed job what stopped it
        (``crash``, ``timeout``, ``memory``, ``diverged``, ``error``).
    message : str
        One line for people.
    progress : Progress
        How far it is.
    sweep : str or None
        The sweep it belongs to.
    wanted : str or None
        ``pause`` while a running job is asked to pause and has not stopped yet.
    """

    id: str
    name: str
    state: State
    created: datetime
    started: datetime | None = None
    finished: datetime | None = None
    attempts: int = 0
    end: str | None = None
    message: str = ""
    progress: Progress = field(default_factory=Progress)
    sweep: str | None = None
    wanted: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """Some jobs, newest first, and the cursor of the next page; None at the end."""

    jobs: tuple[Job, ...]
    cursor: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """State of a sweep at one moment.

    Attributes
    ----------
    id, name : str
        Its id in this store, and the name of its first job, without the number of the job.
    created : datetime
        When it was accepted, in UTC.
    counts : mapping of State to int
        How many of its jobs are in each state.
    """

    id: str
    name: str
    created: datetime
    counts: Mapping[State, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPage:
    """Some sweeps, newest first, and the cursor of the next page; None at the end."""

    sweeps: tuple[Sweep, ...]
    cursor: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PointPage:
    """Some jobs of a sweep with their specifications, oldest first, and the cursor of the next page."""

    points: tuple[tuple[Job, JobSpec], ...]
    cursor: str | None


class UnknownSweepError(KnitlabError):
    """No job is of a sweep of this id."""

    def __init__(self, sweep: str) -> None:
        super().__init__(f"sweep {sweep!r}: there is none")
        self.sweep = sweep


class JobStore(Protocol):
    """Store of jobs; every method may be called from any thread."""

    def submit(self, spec: JobSpec, *, key: str | None = None) -> Job:
        """Accept a job durably; the same key and body return the job accepted before.

        Raises
        ------
        KeyReusedError
            If the key came with another body before.
        """
        ...

    def submit_all(self, specs: Sequence[JobSpec], *, key: str | None = None) -> list[Job]:
        """Accept a sweep: all of it or nothing; its jobs share a sweep id."""
        ...

    def get(self, job: str) -> Job:
        """Return a job.

        Raises
        ------
        UnknownJobError
            If there is none of this id.
        """
        ...

    def list(
        self, limit: int = 50, cursor: str | None = None, state: State | None = None, sweep: str | None = None
    ) -> Page:
        """Return a page of jobs, newest first."""
        ...

    def counts(self, sweep: str | None = None) -> dict[State, int]:
        """Return how many jobs are in each state."""
        ...

    def sweeps(self, limit: int = 50, cursor: str | None = None) -> SweepPage:
        """Return a page of sweeps, newest first."""
        ...

    def sweep(self, sweep: str) -> Sweep:
        """Return a sweep.

        Raises
        ------
        UnknownSweepError
            If no job is of it.
        """
        ...

    def points(self, sweep: str, limit: int = 200, cursor: str | None = None) -> PointPage:
        """Return a page of the jobs of a sweep, in the order in which they were accepted."""
        ...

    def cancel(self, job: str) -> Job:
        """Ask a job to end; it is `cancelling` until its process has stopped. A finished job stays as it is."""
        ...

    def pause(self, job: str) -> Job:
        """Pause a queued or running job at its checkpoint; any other stays as it is."""
        ...

    def resume(self, job: str) -> Job:
        """Queue a paused job again; any other stays as it is."""
        ...

    def delete(self, job: str) -> None:
        """Delete a job that has ended, and its files.

        Raises
        ------
        NotEndedError
            If it has not ended.
        """
        ...

    def spec(self, job: str) -> JobSpec:
        """Return the specification of a job."""
        ...

    def folder(self, job: str) -> Path:
        """Return the folder of the job's files."""
        ...

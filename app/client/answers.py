"""Answers of a service, as dataclasses."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from app.plain_data import from_data
from app.service.jobs import FINAL, Progress

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["FINAL", "Event", "File", "Job", "Page", "Progress", "file_of", "job_of", "progress_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """State of a job at one moment.

    Attributes
    ----------
    id, name : str
        Its id, and the name of its protocol.
    state : str
        One of queued, running, paused, cancelling, succeeded, failed, cancelled.
    created, started, finished : str or None
        Times as ISO 8601 has them, in UTC.
    attempts : int
        How often it was started.
    end, message : str
        How it ended, and one line for people.
    progress : Progress
        How far it is.
    sweep : str or None
        The sweep it belongs to.
    """

    id: str
    name: str
    state: str
    created: str | None = None
    started: str | None = None
    finished: str | None = None
    attempts: int = 0
    end: str | None = None
    message: str = ""
    progress: Progress = field(default_factory=Progress)
    sweep: str | None = None

    @property
    def over(self) -> bool:
        """Return whether it has ended."""
        return self.state in FINAL


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """Some jobs, newest first, and the cursor of the next page; None at the end."""

    jobs: tuple[Job, ...]
    cursor: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class File:
    """A file of a job: its path within the job, its size [bytes] and what it holds."""

    name: str
    size: int
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Event of a stream: `state` (a job), `progress` or `rows`, and the id from which to continue."""

    kind: str
    data: Mapping[str, Any]
    id: str


def job_of(data: Mapping[str, Any]) -> Job:
    """Return the job that an answer describes."""
    return from_data(Job, data, progress=progress_of(data.get("progress") or {}))


def progress_of(data: Mapping[str, Any]) -> Progress:
    """Return the progress that an answer describes."""
    return from_data(Progress, data)


def file_of(data: Mapping[str, Any]) -> File:
    """Return the file that an answer describes."""
    return from_data(File, data)

"""What a service answers, as dataclasses."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

FINAL: Final = frozenset({"succeeded", "failed", "cancelled"})
"""States that a job never leaves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """Progress of a job: share done [1], current activity, strain [1] and force [N] by axis, time left [s].

    `crossings` says where a fibre passed a limit of its material: row, time [s], strain [1], and `text` for people;
    `losses` the same of clasps that let go.
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
        """Tell whether it has ended."""
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
    return Job(**{**_known(Job, data), "progress": progress_of(data.get("progress") or {})})


def progress_of(data: Mapping[str, Any]) -> Progress:
    """Return the progress that an answer describes."""
    return Progress(**_known(Progress, data))


def file_of(data: Mapping[str, Any]) -> File:
    """Return the file that an answer describes."""
    return File(**_known(File, data))


def _known(kind: type, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that this client knows; a newer service may send more."""
    return {one.name: data[one.name] for one in fields(kind) if one.name in data}

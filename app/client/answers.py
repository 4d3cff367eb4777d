"""Answers of a service, as dataclasses."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from app.plain_data import from_data
from app.service.jobs import FINAL, Progress

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "FINAL",
    "Curve",
    "Event",
    "File",
    "Job",
    "JobComparison",
    "Page",
    "Progress",
    "Score",
    "comparison_of",
    "file_of",
    "job_of",
    "progress_of",
]


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A curve of a comparison, SI units.

    Attributes
    ----------
    name, axis : str
        The test, and the axis that was pulled.
    measured : bool
        Whether it is of the measured file.
    part : str
        loading or unloading; of repeats mean, low, high or repeat.
    x, y : tuple of float
        Its points: strain [1] and stress [Pa], or travel [m] and force [N].
    """

    name: str
    axis: str
    measured: bool
    part: str
    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """A figure of a test in a comparison, SI units; of repeats a mean with the least and the largest."""

    name: str
    axis: str
    cycle: int
    figure: str
    value: float
    unit: str
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JobComparison:
    """A measured file over the test of a job.

    Attributes
    ----------
    across, along : str
        What is compared over what: strain or travel, stress or force.
    curves : tuple of Curve
        The curves of both.
    scores : tuple of Score
        NRMSE, secants, loops.
    """

    across: str
    along: str
    curves: tuple[Curve, ...]
    scores: tuple[Score, ...]


def job_of(data: Mapping[str, Any]) -> Job:
    """Return the job that an answer describes."""
    return from_data(Job, data, progress=progress_of(data.get("progress") or {}))


def progress_of(data: Mapping[str, Any]) -> Progress:
    """Return the progress that an answer describes."""
    return from_data(Progress, data)


def file_of(data: Mapping[str, Any]) -> File:
    """Return the file that an answer describes."""
    return from_data(File, data)


def comparison_of(data: Mapping[str, Any]) -> JobComparison:
    """Return the comparison that an answer describes."""
    curves = tuple(from_data(Curve, one, x=tuple(one["x"]), y=tuple(one["y"])) for one in data["curves"])
    scores = tuple(from_data(Score, one) for one in data["scores"])
    return from_data(JobComparison, data, curves=curves, scores=scores)

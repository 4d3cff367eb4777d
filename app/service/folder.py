"""Files of a job: spec, progress, rows, log, lock, result.

protocol.yaml, spec.json  what was asked, for people and for the process
run/                      the run folder: run.h5, checkpoint, logs, plots
figures.json              what the test came to: moduli, loop areas, cost
rows.jsonl                one line per equilibrium, as they come
progress.json             how far it is; replaced whole
job.log                   what the process said
lock                      held by the process that works here
result.json               how it ended; made once, never changed
"""

from __future__ import annotations

import json
import os
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final, TypeVar

from app.file_lock import held, holder
from app.plain_data import from_data
from app.records.folder import write_whole
from app.service.jobs import JobSpec, Progress

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path


FIGURES: Final = "figures.json"
"""Name of the file of a job's figures."""

_DataT = TypeVar("_DataT", JobSpec, Progress, "Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """How a job's process ended its work.

    Attributes
    ----------
    end : str
        How the test ended, or what stopped it.
    message : str
        One line for people.
    failed : bool
        Whether the job has failed.
    """

    end: str
    message: str
    failed: bool


class JobFolder:
    """Folder of one job, with its files.

    Parameters
    ----------
    path : Path
        The folder; it is made with the first file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.run = path / "run"
        self.log = path / "job.log"
        self.rows_file = path / "rows.jsonl"

    def write_spec(self, spec: JobSpec) -> None:
        """Write the spec of the job."""
        self.path.mkdir(parents=True, exist_ok=True)
        write_whole(self.path / "protocol.yaml", [spec.protocol.encode()])
        write_whole(self.path / "spec.json", [spec.text().encode()])

    def read_spec(self) -> JobSpec:
        """Return the spec of the job."""
        return read_as(JobSpec, (self.path / "spec.json").read_bytes())

    def write_progress(self, progress: Progress, ran: float) -> None:
        """Write the progress of the job and its run time over all attempts [s]."""
        # Not synchronised to disk: after a power cut the next attempt writes it again.
        temporary = self.path / f".progress-{os.getpid()}.json"
        temporary.write_text(json.dumps({**asdict(progress), "ran": ran}), encoding="utf-8")
        temporary.replace(self.path / "progress.json")

    def progress(self) -> Progress:
        """Return the progress of the job."""
        return read_as(Progress, self._progress())

    def ran(self) -> float:
        """Return the run time of the job so far [s]."""
        return float(json.loads(self._progress()).get("ran", 0.0))

    def _progress(self) -> bytes:
        """Return the content of the progress file; empty if it cannot be read, for progress is not essential."""
        with suppress(OSError, json.JSONDecodeError):
            data = (self.path / "progress.json").read_bytes()
            json.loads(data)
            return data
        return b"{}"

    def rows(self, since: int = 0, limit: int = 1000) -> list[dict[str, Any]]:
        """Return at most a given number of equilibria from number `since` on, in the order of time.

        Each has ``row`` (its number, from 0), ``time`` [s], ``phase``, ``cycle``, ``tag``, and per driven axis
        ``strain`` [1], ``displacement`` [m] and ``force`` [N].
        """
        found: list[dict[str, Any]] = []
        with suppress(FileNotFoundError), self.rows_file.open("rb") as file:
            for number, line in enumerate(file):
                if len(found) >= limit or not line.endswith(b"\n"):
                    break
                if number >= since:
                    found.append(json.loads(line))
        return found

    def write_figures(self, figures: Sequence[tuple[str, float, str]]) -> None:
        """Write the figures of the test: name, value, unit of each."""
        rows = [{"name": name, "value": value, "unit": unit} for name, value, unit in figures]
        write_whole(self.path / FIGURES, [json.dumps(rows).encode()])

    def figures(self) -> list[dict[str, Any]] | None:
        """Return the figures of the test, each with ``name``, ``value`` and ``unit``; None before its end."""
        try:
            return list(json.loads((self.path / FIGURES).read_bytes()))
        except FileNotFoundError:
            return None

    def write_result(self, result: Result) -> None:
        """Write how the job ended; the first result stays."""
        whole = write_whole(self.path / f".result-{os.getpid()}.json", [json.dumps(asdict(result)).encode()])
        try:
            with suppress(FileExistsError):
                os.link(whole, self.path / "result.json")
        finally:
            whole.unlink()

    def result(self) -> Result | None:
        """Return how the job ended; None if it has not."""
        try:
            return read_as(Result, (self.path / "result.json").read_bytes())
        except FileNotFoundError:
            return None

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Lock the folder; the system releases the lock when the process ends.

        Raises
        ------
        LockedError
            If another process holds it.
        """
        with held(self.path / "lock"):
            yield

    def holder(self) -> int | None:
        """Return the process on this host that holds the lock; None if there is none, or it is elsewhere."""
        return holder(self.path / "lock")


def read_as(kind: type[_DataT], data: bytes | str) -> _DataT:
    """Parse JSON into a dataclass; fields of a newer version are ignored."""
    return from_data(kind, json.loads(data))

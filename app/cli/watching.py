"""Watch a job of a service to its end, and fetch what its instruments logged."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from app.client.answers import job_of, progress_of
from app.service.errors import ServiceError

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.client import Client, Job

_RUN = "run/"


def watch_job(client: Client, job: Job, show: Callable[[float, str], None]) -> Job:
    """Follow a job to its end.

    Parameters
    ----------
    client : Client
        The service.
    job : Job
        The job, as it was.
    show : callable
        Told the share done [1] and what is being done.

    Returns
    -------
    Job
        As it ended.
    """
    now = job
    show(now.progress.share, now.progress.text or now.state)
    if now.over:
        return now
    for event in client.follow(job.id):
        match event.kind:
            case "state":
                now = job_of(event.data)
            case "progress":
                now = replace(now, progress=progress_of(event.data))
            case _:
                continue
        working = now.state == "running" and now.progress.text
        show(now.progress.share, now.progress.text if working else now.state)
    return now if now.over else client.job(job.id)


def fetch_logs(client: Client, job: str, folder: Path, *, everything: bool = False) -> list[Path]:
    """Fetch the logs of a job, under the names that `knitlab run` gives them.

    Parameters
    ----------
    client : Client
        The service.
    job : str
        The job's id.
    folder : Path
        Folder to write them into.
    everything : bool
        Also the record, pictures and whatever else the run folder holds.

    Raises
    ------
    ServiceError
        If a file would be outside the folder.
    """
    wanted = [one for one in client.files(job) if one.name.startswith(_RUN) and (everything or one.kind == "log")]
    return [client.download(job, one.name, folder / _inside(one.name.removeprefix(_RUN))) for one in wanted]


def _inside(name: str) -> Path:
    """Return a file's path within a folder; a path from a service that leads outside is refused."""
    plain = PurePosixPath(name)
    if plain.is_absolute() or ".." in plain.parts or not plain.parts or any(sign in name for sign in "\\:\0"):
        raise ServiceError(502, f"file {name!r}: leads out of the job")
    return Path(*plain.parts)

"""Start real workers, on SQLite or a real PostgreSQL, and see what becomes of jobs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

import psutil

from app.service.jobs import FINAL, JobSpec
from app.service.settings import settings
from app.service.store import Store
from app.service.warmup_protocol import PROTOCOL

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from app.service.folder import JobFolder
    from app.service.jobs import Job

ROOT: Final = Path(__file__).parents[2]
PATIENCE: Final = 180.0

#: A real test of three rows: a fraction of a second.
TINY: Final = JobSpec(name="tiny", protocol=PROTOCOL, pictures=False)
#: The same cycle hundreds of times: minutes, unless something stops it.
LONG: Final = JobSpec(name="long", protocol=PROTOCOL.replace("n: 1", "n: 2000"), pictures=False)
#: A knit so large that nearly all its time is spent inside kernels, with more cycles than it is given time for.
BUSY: Final = JobSpec(
    name="busy", protocol=PROTOCOL.replace("[2, 2]", "[12, 12]").replace("n: 1", "n: 500"), pictures=False
)


def cycles(count: int) -> JobSpec:
    """Return a test of so many cycles, two rows each."""
    return JobSpec(name=f"cycles-{count}", protocol=PROTOCOL.replace("n: 1", f"n: {count}"), pictures=False)


def until(what: Callable[[], object], patience: float = PATIENCE, every: float = 0.05) -> None:
    """Wait until something is true.

    Raises
    ------
    TimeoutError
        If it is not, for as long as a very busy machine would take.
    """
    began = time.monotonic()
    while not what():
        if time.monotonic() - began > patience:
            raise TimeoutError(f"not true after {patience:g} s")
        time.sleep(every)


class Lab:
    """A store and the workers that serve it.

    Parameters
    ----------
    folder : Path
        Data folder.
    database : str
        URL of a PostgreSQL database; empty for SQLite.
    """

    def __init__(self, folder: Path, database: str = "") -> None:
        self.folder = folder
        self.environment = {**os.environ, "KNITLAB_DB": database, "PYTHONPATH": str(ROOT)}
        self.store = Store(settings(folder, self.environment))
        self.workers: list[subprocess.Popen[str]] = []

    def start(self, slots: int = 2, lease: float = 3.0, root: Path = ROOT) -> subprocess.Popen[str]:
        """Start a worker; what `root` has of the sources goes before ours."""
        command = [
            sys.executable,
            "-c",
            "from app.cli.main import main; main()",
            "worker",
            "--data",
            str(self.folder),
        ]
        worker = subprocess.Popen(  # noqa: S603 (our own)
            [*command, "--slots", str(slots), "--lease", str(lease)],
            cwd=root,
            env={**self.environment, "PYTHONPATH": os.pathsep.join([str(root), str(ROOT)])},
            text=True,
        )
        self.workers.append(worker)
        return worker

    def kill(self, worker: subprocess.Popen[str]) -> None:
        """Kill a worker as a crash would: it alone, at once."""
        worker.kill()
        worker.wait()

    def job(self, job: Job) -> Job:
        """Return the job as it is now."""
        return self.store.get(job.id)

    def files(self, job: Job) -> JobFolder:
        """Return the job's files."""
        return self.store.files(job.id)

    def process(self, job: Job) -> psutil.Process | None:
        """Return the process that works on a job; None if none does."""
        with suppress(FileNotFoundError, psutil.Error, json.JSONDecodeError, KeyError):
            pid = json.loads((self.files(job).path / "lock").read_bytes())["pid"]
            process = psutil.Process(pid)
            return process if not gone(process) and self.files(job).holder() == pid else None
        return None

    def has_rows(self, job: Job, count: int) -> bool:
        """Tell whether a job has so many rows by now."""
        return len(self.files(job).rows(limit=count)) >= count

    def finished(self) -> bool:
        """Tell whether every job has ended."""
        counts = self.store.counts()
        return all(state in FINAL for state, count in counts.items() if count)

    def close(self) -> None:
        """Stop everything."""
        for worker in self.workers:
            if worker.poll() is None:
                worker.send_signal(signal.SIGCONT)
                worker.kill()
            worker.wait()
        self.store.close()


@contextmanager
def manned(folder: Path) -> Iterator[Lab]:
    """Lend a lab on SQLite with a worker of one slot."""
    lab = Lab(folder)
    lab.start(slots=1)
    yield lab
    lab.close()


def gone(process: psutil.Process) -> bool:
    """Tell whether a process has ended."""
    try:
        return bool(process.status() == psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return True


def begun(files: JobFolder) -> int:
    """Return how many processes began to work on a job."""
    return files.log.read_text().count(" begins\n") if files.log.exists() else 0


def ended(files: JobFolder) -> int:
    """Return how many times a job's test was done to its end."""
    return files.log.read_text().count(" the test ended: ")

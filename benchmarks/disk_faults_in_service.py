"""Let calls to the disk fail below the data folder of a service: in the server, its database and the jobs' processes.

    python -m benchmarks.disk_faults_in_service --trials 48

Needs Linux and a C compiler. `knitlab serve` runs with the library of `benchmarks.disk_faults` loaded before all
others; server and jobs share one plan of what fails. In each trial a job is posted until it is accepted; calls fail
from a random one on for some seconds, or one call fails; then nothing fails any more, and the job has to end with the
log of one that met no fault. Counted is what ``POST`` answered, how the job ended and how many processes it took; a
traceback in the log of job or service counts against it.
"""

from __future__ import annotations

import argparse
import ctypes
import errno
import os
import random
import re
import subprocess
import sys
import tempfile
import time
import uuid
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import httpx

from benchmarks.disk_faults import ALL, FAULTS, SOURCE
from benchmarks.disks import PROTOCOL, show

PATIENCE: Final = 240.0
"""Longest time that a job may take when nothing fails any more [s]."""

FAILING: Final = 4.0
"""Time for which calls fail from the first on [s]."""

FINAL: Final = ("succeeded", "failed", "cancelled")


@dataclass(kw_only=True)
class Service:
    """A service whose calls below its data folder can be made to fail.

    Attributes
    ----------
    folder : Path
        Folder of its data, its log and the plan of faults.
    """

    folder: Path
    server: subprocess.Popen[bytes] | None = None
    address: str = ""
    answers: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        library, plan = self.folder / "disk_faults.so", self.folder / "plan"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(library), str(SOURCE), "-ldl"], check=True)
        plan.write_bytes(bytes(8192))
        os.environ["KNITLAB_FAULTS"] = str(plan)
        self.library = ctypes.CDLL(str(library))
        self.library.fault_calls.restype = self.library.fault_failed.restype = ctypes.c_long
        self.environment = {
            **os.environ,
            "LD_PRELOAD": str(library),
            "KNITLAB_THREADS": "1",
            "PYTHONPATH": str(Path.cwd()),
        }
        self.data, self.log = self.folder / "data", self.folder / "serve.log"

    def start(self) -> None:
        """Start the server, unless it runs."""
        if self.server is not None and self.server.poll() is None:
            return
        command = [sys.executable, "-c", "from app.cli.main import main; main()", "serve", "--port", "0"]
        with self.log.open("ab") as log:
            begin = log.tell()
            self.server = subprocess.Popen(
                [*command, "--slots", "1", "--data", str(self.data)], stderr=log, env=self.environment
            )
        while (found := re.search(rb"serves on (http://\S+),", self.log.read_bytes()[begin:])) is None:
            time.sleep(0.1)
        self.address = found[1].decode()

    def fail(self, number: int, first: int, count: int, *, reads: bool) -> None:
        """Let calls fail from one on."""
        where = os.fsencode(self.data)
        self.library.fault_begin(where, number, ctypes.c_long(first), ctypes.c_long(count), int(reads))

    def heal(self) -> None:
        """Let no call fail."""
        self.library.fault_begin(b"", 0, ctypes.c_long(0), ctypes.c_long(0), 0)

    def get(self, path: str) -> httpx.Response | None:
        """Return an answer that is not an error; None if there is none now."""
        try:
            answer = httpx.get(f"{self.address}{path}", timeout=30.0)
        except httpx.TransportError:
            return None
        self.answers[f"GET {answer.status_code}"] += 1
        return answer if answer.is_success else None


def try_job(service: Service, heal: float, report: Counter[str]) -> str:
    """Post a job until it is accepted, and return its id when it has ended; empty if it does not end."""
    key, job, began, failing = uuid.uuid4().hex, "", time.monotonic(), 0.0
    while time.monotonic() - began < PATIENCE:
        now = time.monotonic()
        if not failing and service.library.fault_failed():
            failing = now
        if failing and now - failing > heal:
            service.heal()
        service.start()
        if not job:
            headers = {"Content-Type": "application/yaml", "Idempotency-Key": key}
            try:
                answer = httpx.post(f"{service.address}/v1/jobs", content=PROTOCOL, headers=headers, timeout=30.0)
            except httpx.TransportError as error:
                report[f"POST {type(error).__name__}"] += 1
                continue
            report[f"POST {answer.status_code}"] += 1
            job = answer.json()["id"] if answer.status_code == 202 else ""
        elif (found := service.get(f"/v1/jobs/{job}")) is not None and found.json()["state"] in FINAL:
            return job
        time.sleep(0.1)
    return ""


def verdict_of(service: Service, job: str, truth: bytes | None, said: str) -> str:
    """Return how a job ended."""
    service.heal()
    if not job:
        return "LOST"
    found = service.get(f"/v1/jobs/{job}")
    state = "no answer" if found is None else found.json()["state"]
    folder = service.data / "jobs" / job[:2] / job
    verdict = state if state == "succeeded" else f"{state.upper()} {'' if found is None else found.json()['message']}"
    logs = sorted(folder.glob("run/*.csv"))
    if truth is not None and (not logs or logs[0].read_bytes() != truth):
        verdict += ", OTHER LOG"
    if (folder / ".crash").exists():
        verdict += ", CRASHED"
    if "Traceback" in (folder / "job.log").read_text():
        verdict += ", TRACEBACK IN JOB.LOG"
    return verdict + ", TRACEBACK" * ("Traceback" in said)


def trials(service: Service, count: int, seed: int) -> None:
    """Try faults at random calls of a job."""
    chance = random.Random(seed)
    most, truth = {}, None
    for reads in (False, True):
        service.start()
        service.fail(0, sys.maxsize, 1, reads=reads)
        job = try_job(service, 0.0, Counter())
        if not job:
            raise SystemExit(service.log.read_text())
        most[reads] = service.library.fault_calls()
        truth = next((service.data / "jobs" / job[:2] / job).glob("run/*.csv")).read_bytes()
    table: dict[str, Counter[str]] = {}
    for trial in range(count):
        number = FAULTS[trial % len(FAULTS)]
        reads = trial // len(FAULTS) % 4 == 3  # every fourth
        times = ALL if trial // (2 * len(FAULTS)) % 2 else 1
        # A share of them at the posting, which makes few of the calls.
        first = chance.randrange(most[reads] if trial % 5 else 20)
        begin, report = service.log.stat().st_size, Counter[str]()
        service.start()
        service.fail(number, first, times, reads=reads)
        job = try_job(service, FAILING if times == ALL else 0.0, report)
        failed = service.library.fault_failed()
        said = service.log.read_bytes()[begin:].decode(errors="replace")
        verdict = verdict_of(service, job, truth, said)
        tries = (service.data / "jobs" / job[:2] / job / "job.log").read_text().count(" begins\n") if job else 0
        label = f"{errno.errorcode[number]}, {'once' if times == 1 else f'for {FAILING:g} s'}{', reads too' * reads}"
        sys.stdout.write(f"{trial}: {label}, call {first} of {most[reads]}, {failed} failed: {verdict}; ")
        sys.stdout.write(f"{tries} processes; {dict(report)}\n")
        if "TRACEBACK" in verdict or not job:
            sys.stdout.write(said[-4000:])
        sys.stdout.flush()
        table.setdefault(label, Counter())[verdict] += 1
        table[label].update(report)
    show(table)
    sys.stdout.write(f"GET: {dict(service.answers)}\n")


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=48)
    parser.add_argument("--seed", type=int, default=12)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        service = Service(folder=Path(name).resolve())
        try:
            trials(service, asked.trials, asked.seed)
        finally:
            if service.server is not None:
                service.server.terminate()
                service.server.wait()


if __name__ == "__main__":
    main()

"""Submit many real jobs, kill what runs them at random, and count what became of them."""

from __future__ import annotations

import hashlib
import random
import signal
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import psutil

from tests.service.lab import begun, cycles, ended, until

if TYPE_CHECKING:
    from app.service.jobs import Job
    from tests.service.lab import Lab


SHORT = 20
"""Jobs of a storm that is over before a frozen worker is back."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Storm:
    """Say what is done to the jobs: how many there are, how many killings of each kind, and the seed."""

    jobs: int
    workers: int = 1
    children_killed: int = 0
    workers_killed: int = 0
    workers_frozen: int = 0
    workers_told_to_leave: int = 0
    seed: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """Count jobs after a storm.

    Attributes
    ----------
    submitted, finished, succeeded, lost : int
        `lost` were accepted and never ended.
    interrupted : int
        Jobs whose process was killed after it had begun and before its test had ended.
    twice : int
        Jobs whose test came to its end more than once.
    redone : int
        Jobs that began more than once.
    different : int
        Jobs whose log differs from that of the others; all run the same protocol.
    seconds : float
        From the first job submitted to the last one ended.
    """

    submitted: int
    finished: int
    succeeded: int
    lost: int
    interrupted: int
    twice: int
    redone: int
    different: int
    seconds: float


def endure(lab: Lab, storm: Storm, slots: int = 2) -> Tally:
    """Run jobs through a storm and count.

    A worker that is killed is followed by a new one, as a host would do it.
    """
    chance = random.Random(storm.seed)  # noqa: S311 (nothing secret)
    began = time.monotonic()
    jobs = [lab.store.submit(cycles(15)) for _ in range(storm.jobs // 2)]
    jobs += lab.store.submit_all([cycles(15)] * (storm.jobs - len(jobs)))
    for _ in range(storm.workers):
        lab.start(slots)
    blows = (
        ["child"] * storm.children_killed
        + ["kill"] * storm.workers_killed
        + ["freeze"] * storm.workers_frozen
        + ["leave"] * storm.workers_told_to_leave
    )
    chance.shuffle(blows)
    if storm.jobs <= SHORT:
        # Its jobs are all done while a worker is frozen: kill in the middle of one before.
        blows.sort(key=lambda blow: blow != "child")
    hit: set[str] = set()
    for number, blow in enumerate(blows):
        # Spread over the storm: a blow falls when its share of the jobs is done.
        due = storm.jobs * number // (len(blows) + 1)
        while _ended(lab) <= due and not lab.finished():
            time.sleep(0.05)
        _strike(lab, blow, jobs, hit, chance, slots)
    until(lab.finished, patience=1800.0, every=0.2)
    return _count(lab, jobs, hit, time.monotonic() - began)


def _ended(lab: Lab) -> int:
    counts = lab.store.counts()
    return counts["succeeded"] + counts["failed"]


def _strike(lab: Lab, blow: str, jobs: list[Job], hit: set[str], chance: random.Random, slots: int) -> None:
    """Do one harm."""
    if blow == "child":
        until(lambda: _killed_one(lab, jobs, hit) or lab.finished(), every=0.005)
        return
    worker = chance.choice([one for one in lab.workers if one.poll() is None])
    if blow == "freeze":
        worker.send_signal(signal.SIGSTOP)
        time.sleep(6.0)
        worker.send_signal(signal.SIGCONT)
        return
    worker.send_signal(signal.SIGTERM if blow == "leave" else signal.SIGKILL)
    worker.wait(timeout=120.0)
    lab.start(slots)


def _killed_one(lab: Lab, jobs: list[Job], hit: set[str]) -> bool:
    """Kill a process in the middle of a job, of each job once: a job whose process dies three times has failed.

    The process is suspended before the log is read: a test of a fraction of a second could end in between.
    """
    running = {job.id for job in lab.store.list(100, state="running").jobs} - hit
    for job in jobs:
        if job.id not in running or (process := lab.process(job)) is None:
            continue
        with suppress(psutil.NoSuchProcess):
            process.suspend()
            if begun(lab.files(job)) and not ended(lab.files(job)):
                process.kill()
                hit.add(job.id)
                return True
            process.resume()
    return False


def _count(lab: Lab, jobs: list[Job], hit: set[str], seconds: float) -> Tally:
    counts, files = lab.store.counts(), [lab.files(job) for job in jobs]
    finished = sum(counts[state] for state in ("succeeded", "failed", "cancelled"))
    logs = [hashlib.sha256(b"".join(path.read_bytes() for path in one.run.glob("*.csv"))).digest() for one in files]
    return Tally(
        submitted=len(jobs),
        finished=finished,
        succeeded=counts["succeeded"],
        lost=len(jobs) - finished,
        interrupted=len(hit),
        twice=sum(ended(one) > 1 for one in files),
        redone=sum(begun(one) > 1 for one in files),
        different=sum(log != max(set(logs), key=logs.count) for log in logs),
        seconds=seconds,
    )

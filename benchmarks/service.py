"""Print how fast the queue takes and hands out jobs, and what an idle worker costs: `python -m benchmarks.service`."""

from __future__ import annotations

import statistics
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import psutil

from app.service.deliveries import QUEUE, VERSION
from tests.service.databases import postgres, postgres_programs
from tests.service.lab import TINY, Lab, until

if TYPE_CHECKING:
    from collections.abc import Callable

MANY = 100_000
IDLE = 20.0


def times(do: Callable[[], object], count: int) -> list[float]:
    """Return how long something takes, again and again [s], in rising order."""
    found = []
    for _ in range(count):
        began = time.perf_counter()
        do()
        found.append(time.perf_counter() - began)
    return sorted(found)


def half_and_most(found: list[float]) -> str:
    """Return the 50th and 99th percentile [ms]."""
    return f"p50 {1e3 * statistics.median(found):.1f} ms, p99 {1e3 * found[int(0.99 * len(found))]:.1f} ms"


def measure(lab: Lab, name: str) -> None:
    """Print the figures of one database."""
    print(f"{name}: submit, {half_and_most(times(lambda: lab.store.submit(TINY), 300))}", flush=True)
    began = time.perf_counter()
    lab.store.submit_all([TINY] * MANY)
    print(f"{name}: a sweep of {MANY}, {time.perf_counter() - began:.1f} s", flush=True)
    queue = lab.store.client.register_queue(QUEUE, worker_concurrency=1)
    database = lab.store.client._sys_db  # noqa: SLF001 (what a worker calls)
    taken = times(lambda: database.start_queued_workflows(queue, "benchmark", VERSION, None), 100)
    print(f"{name}: take one of {MANY}, {half_and_most(taken)}", flush=True)


def idle(lab: Lab, name: str) -> None:
    """Print what a worker costs that has nothing to do, and how long a job waits for it."""
    worker = psutil.Process(lab.start(slots=2).pid)
    first = lab.store.submit(TINY)
    until(lambda: lab.job(first).state == "succeeded")
    family = [worker, *worker.children(recursive=True)]
    before = [one.cpu_times() for one in family]
    time.sleep(IDLE)
    spent = [one.cpu_times() for one in family]
    share = sum(b.user + b.system - a.user - a.system for a, b in zip(before, spent, strict=True)) / IDLE
    memory = "; ".join(f"{one.memory_info().rss / 1e6:.0f} MB" for one in family)
    print(f"{name}: idle worker {share:.1%} of a processor; {memory} (server, then its helpers)", flush=True)
    waits = [wait(lab) for _ in range(10)]
    print(f"{name}: from submitted to running, median {statistics.median(waits):.2f} s", flush=True)


def wait(lab: Lab) -> float:
    """Return how long a job waits until it runs [s]."""
    job, began = lab.store.submit(TINY), time.monotonic()
    until(lambda: lab.job(job).started is not None, every=0.005)
    return time.monotonic() - began


def main() -> None:
    """Print the figures of SQLite, and of PostgreSQL where it is installed."""
    for name in ("SQLite", "PostgreSQL"):
        if name == "PostgreSQL" and postgres_programs() is None:
            continue
        for what in (idle, measure):
            with ExitStack() as stack:
                folder = stack.enter_context(tempfile.TemporaryDirectory())
                lab = Lab(Path(folder), stack.enter_context(postgres()) if name == "PostgreSQL" else "")
                stack.callback(lab.close)
                what(lab, name)


if __name__ == "__main__":
    main()

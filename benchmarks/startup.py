"""What stands between a command and its files: ``python -m benchmarks.startup [REPEATS]``; ``cold`` for the first run.

Processor seconds and memory are those of the command and of the processes it starts; on a busy machine the first say
more than wall time. Memory is the largest proportional set size (PSS) of all of them at one time, on Linux.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from statistics import median
from time import perf_counter, sleep

import psutil

from app.runs.compile_ahead import compiling_beside

PROTOCOL = """\
schema: knitlab/protocol@1
name: two
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: on, seed: 1}
steps:
  - cycle: {axes: [C, W], lower: 0, upper: 10 %, rate: 0.2 mm/s, n: 1}
"""
CLI = "from app.cli.main import main; import sys; sys.argv[0] = 'knitlab'; main()"
FIRST_ROW = "from benchmarks.startup import first_row; first_row()"
MEGABYTE = 2.0**20


def started(code: str, *words: str, **more: str) -> subprocess.Popen[bytes]:
    """Start code in an interpreter of its own."""
    nowhere = subprocess.DEVNULL
    command = [sys.executable, "-c", code, *words]
    return subprocess.Popen(command, stdout=nowhere, stderr=nowhere, env={**os.environ, **more})  # noqa: S603


def timed(code: str, *words: str, **more: str) -> tuple[float, float]:
    """Run code in an interpreter of its own; return wall and processor seconds, its children's included."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    if started(code, *words, **more).wait():
        raise RuntimeError(f"{words} failed")
    wall, after = perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def memory(code: str, *words: str) -> float:
    """Run code as `timed` does; return the largest memory of all its processes [MB], looked at every 20 ms."""
    process = started(code, *words)
    most = 0
    with suppress(psutil.NoSuchProcess):
        first = psutil.Process(process.pid)
        while process.poll() is None:
            most = max(most, sum(_share(one) for one in (first, *first.children(recursive=True))))
            sleep(0.02)
    return most / MEGABYTE


def _share(process: psutil.Process) -> int:
    """Return the memory of a process, what it shares divided by those who share it [bytes]."""
    with suppress(psutil.Error):
        found = process.memory_full_info()
        return int(getattr(found, "pss", found.rss))
    return 0


def first_row() -> None:
    """Come to the first row of the main job, as a run does."""
    from benchmarks import main_job  # noqa: PLC0415 (compiled beside from the start)

    with compiling_beside():
        main_job.first_row()


def main() -> None:
    """Print the medians."""
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1:] == ["cold"]:
            for threads in ("1", "2"):
                cache = f"{folder}/{threads}"
                wall, used = timed(FIRST_ROW, KNITLAB_CACHE=cache, KNITLAB_THREADS=threads)
                print(f"first row ever, {threads} process(es)  {wall:6.2f} s, {used:6.2f} processor seconds")
            return
        repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 5
        protocol = Path(folder) / "two.yaml"
        protocol.write_text(PROTOCOL, encoding="utf-8")
        out = ["--out", f"{folder}/run"]
        for name, words in (
            ("check", ["check", str(protocol)]),
            ("run --no-pictures", ["run", str(protocol), "--no-pictures", *out]),
            ("run", ["run", str(protocol), *out]),
        ):
            timed(CLI, *words)
            walls, spent = zip(*(timed(CLI, *words) for _ in range(repeats)), strict=True)
            most = median(memory(CLI, *words) for _ in range(repeats))
            print(f"{name:20s} {median(walls):6.2f} s, {median(spent):6.2f} processor seconds, {most:4.0f} MB")


if __name__ == "__main__":
    main()

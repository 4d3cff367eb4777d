"""What stands between a command and its files: ``python -m benchmarks.startup [REPEATS]``; ``cold`` for the first run.

Processor seconds are those of the command and of the processes it starts; on a busy machine they say more than others.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

from app.runs.compile_ahead import compiling_beside

SMALL = Path(__file__).resolve().parent.parent / "examples" / "biaxial_small.yaml"
CLI = "from app.cli.main import main; import sys; sys.argv[0] = 'knitlab'; main()"
FIRST_ROW = "from benchmarks.startup import first_row; first_row()"


def timed(code: str, *words: str, **more: str) -> tuple[float, float]:
    """Run code in an interpreter of its own; return wall and processor seconds, its children's included."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    command = [sys.executable, "-c", code, *words]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **more})  # noqa: S603
    wall, after = perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


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
        out = ["--out", f"{folder}/run"]
        for name, words in (
            ("check", ["check", str(SMALL)]),
            ("run --no-pictures", ["run", str(SMALL), "--no-pictures", *out]),
            ("run", ["run", str(SMALL), *out]),
        ):
            timed(CLI, *words)
            walls, spent = zip(*(timed(CLI, *words) for _ in range(repeats)), strict=True)
            print(f"{name:20s} {median(walls):6.2f} s, {median(spent):6.2f} processor seconds")


if __name__ == "__main__":
    main()

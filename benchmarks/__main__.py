"""Time the laboratory: `make bench`. What it prints stands in README.md beside this file."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from statistics import median
from time import perf_counter

from benchmarks.linear_solvers import main as linear_solvers
from benchmarks.main_job import PARTS

REPEATS = 5


def child(*arguments: str, cache: str | None = None) -> str:
    """Run this interpreter with arguments; return what it prints."""
    environment = {**os.environ, **({} if cache is None else {"KNITLAB_CACHE": cache})}
    done = subprocess.run(  # noqa: S603  (our own interpreter and module)
        [sys.executable, *arguments], check=True, capture_output=True, text=True, env=environment
    )
    return done.stdout


def main() -> None:
    """Print every timing."""
    figures = json.loads(child("-m", "benchmarks.main_job", str(REPEATS)))
    n, steps = figures["iterations"], figures["steps"]
    print(f"processors                     {os.cpu_count()}")
    print(f"main job, first cycle, warm    {figures['wall']:.2f} s (median of {REPEATS}), {figures['memory']:.0f} MB")
    print(f"  steps {steps}, iterations {n} ({n / steps:.1f} a step), factorisations {figures['factorisations']}")
    named = sum(figures["parts"].values())
    for part in PARTS:
        print(f"  {part:12s} {1e3 * figures['parts'][part] / n:6.2f} ms an iteration")
    print(f"  {'outside':12s} {1e3 * (figures['wall'] - named) / n:6.2f} ms an iteration")

    with tempfile.TemporaryDirectory() as empty:
        cold = float(child("-m", "benchmarks.main_job", "first-row", cache=empty))
    print(f"first run ever, to first row   {cold:.1f} s")

    helps = []
    for _ in range(REPEATS):
        began = perf_counter()
        child("-m", "app.cli.main", "--help")
        helps.append(perf_counter() - began)
    print(f"knitlab --help, warm           {median(helps):.2f} s")

    linear_solvers()


if __name__ == "__main__":
    main()

"""The main job's first cycle, timed: a 6x6 knit to 40 % biaxial strain and back."""

from __future__ import annotations

import json
import resource
import sys
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.checks.dry_run import build_specimen
from app.schemas import load
from app.schemas.machine_data import machines_of
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Equilibrium

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.sparse.blocks import Pattern
    from rigs.machines.rig import Rig

PROTOCOL = Path(__file__).resolve().parent.parent / "examples" / "biaxial_cycle.yaml"
PARTS = (
    "pairs",
    "energy",
    "gradient",
    "assembly",
    "factor",
    "solve",
    "coupling",
    "friction",
    "neighbours",
    "analyse",
    "search",
)
"""Parts of a search; "search" is what its control takes."""


def peak_memory() -> float:
    """Return the largest memory this process has held [MB]."""
    unit = 1.0 if sys.platform == "darwin" else 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def first_cycle() -> tuple[Rig, list[Equilibrium]]:
    """Run the first cycle of the main job; return the stage and its rows."""
    loaded = load(PROTOCOL)
    stage, state = mount(build_specimen(loaded), loaded.protocol, machines_of(loaded.protocol))
    rows = []
    for event in perform(stage, state, loaded.protocol):
        if isinstance(event, Equilibrium):
            if event.cycle > 1:
                break
            rows.append(event)
    return stage, rows


def at_strain(strain: float) -> tuple[Rig, FloatArray]:
    """Pull the main job up to a strain; return the rig there, and its samples (N m, 3) one equilibrium before [r]."""
    loaded = load(PROTOCOL)
    stage, state = mount(build_specimen(loaded), loaded.protocol, machines_of(loaded.protocol))
    before = stage.work.placed.points.copy()
    for event in perform(stage, state, loaded.protocol):
        if isinstance(event, Equilibrium):
            if event.displacement["C"] >= strain * stage.gauges["C"]:
                break
            before = stage.work.placed.points.copy()
    return stage, before


def stiffness() -> tuple[Pattern, FloatArray]:
    """Return pattern and blocks of the free stiffness on the way up at 33 % strain."""
    stage, _ = at_strain(0.33)
    return stage.work.stiffness.pattern, stage.work.stiffness.blocks


def first_row() -> float:
    """Return the seconds to the first row, kernels compiled on the way if they must be."""
    began = perf_counter()
    loaded = load(PROTOCOL)
    stage, state = mount(build_specimen(loaded), loaded.protocol, machines_of(loaded.protocol))
    rows = (e for e in perform(stage, state, loaded.protocol) if isinstance(e, Equilibrium))
    next(rows)  # as mounted
    next(rows)  # the first that was solved for
    return perf_counter() - began


def timed(repeats: int) -> dict[str, Any]:
    """Time the first cycle `repeats` times after one to warm up; return medians."""
    first_cycle()
    runs: list[dict[str, Any]] = []
    for _ in range(repeats):
        began = perf_counter()
        stage, rows = first_cycle()
        wall = perf_counter() - began
        solved = [row for row in rows if row.iterations]
        runs.append(
            {
                "wall": wall,
                "steps": len(solved),
                "iterations": sum(row.iterations for row in rows),
                "factorisations": sum(row.factorisations for row in rows),
                "parts": {part: stage.work.clock.seconds.get(part, 0.0) for part in PARTS},
            }
        )
    middle = sorted(runs, key=lambda run: float(run["wall"]))[len(runs) // 2]
    return {**middle, "wall": median(float(run["wall"]) for run in runs), "memory": peak_memory()}


if __name__ == "__main__":
    if sys.argv[1:] == ["first-row"]:
        sys.stdout.write(f"{first_row():.3f}\n")
    else:
        sys.stdout.write(json.dumps(timed(int(sys.argv[1]))) + "\n")

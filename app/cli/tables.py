"""Tables of runs, sweeps and jobs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.table import Table

from app.views.tables import console_of, figures_data, print_crossings, print_figures, print_losses, print_steps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.client import Job
    from app.runs.sweeps import SweepResult
    from app.runs.use_cases import RunResult


def result_data(result: RunResult) -> dict[str, Any]:
    """Return the end of a run as plain data."""
    return {
        "outcome": result.outcome,
        "message": result.message,
        "folder": str(result.folder),
        "crossings": [one.data() for one in result.crossings],
        "losses": [one.data() for one in result.losses],
        "figures": figures_data(result.figures),
        "steps": [asdict(step) for step in result.steps],
    }


def print_result(result: RunResult) -> None:
    """Print how a run ended and its figures."""
    console = console_of()
    console.print(f"outcome: {result.outcome}; folder: {result.folder}", soft_wrap=True)
    if result.outcome == "target" and result.message:
        console.print(result.message, soft_wrap=True)
    print_crossings(result.crossings)
    print_losses(result.losses)
    print_steps(result.steps)
    print_figures(result.figures)


def sweep_data(result: SweepResult) -> dict[str, Any]:
    """Return a sweep as plain data."""
    points = [
        {
            "point": one.point.label,
            "values": dict(one.point.values),
            "folder": str(one.folder),
            "outcome": one.outcome,
            "message": one.message,
            "skipped": one.skipped,
            "crossings": [crossing.data() for crossing in one.crossings],
            "losses": [loss.data() for loss in one.losses],
            "figures": figures_data(one.figures),
        }
        for one in result.points
    ]
    plots = [str(path) for path in result.plot_files]
    return {"points": points, "table": str(result.table_file), "plot": str(result.plot_file), "plots": plots}


def print_sweep(result: SweepResult) -> None:
    """Print how the points of a sweep ended and where they are summed up."""
    table = Table("point", "outcome", "folder", "")
    for one in result.points:
        table.add_row(one.point.label, one.outcome, str(one.folder), "done before" if one.skipped else "")
    console_of().print(table)
    for one in result.points:
        for crossing in one.crossings:
            console_of().print(f"{one.point.label}: beyond strength: {crossing}", soft_wrap=True)
        for loss in one.losses:
            console_of().print(f"{one.point.label}: let go: {loss}", soft_wrap=True)
    for name, path in (
        ("table", result.table_file),
        *(("plot", path) for path in (result.plot_file, *result.plot_files)),
    ):
        console_of().print(f"{name}: {path}", soft_wrap=True)


def jobs_data(found: Sequence[Job]) -> list[dict[str, Any]]:
    """Return jobs as plain data."""
    return [asdict(job) for job in found]


def print_jobs(found: Sequence[Job]) -> None:
    """Print a table of jobs."""
    table = Table()
    for name in ("id", "name", "state", "done", "created", "end"):
        # An id must stay whole, to be copied.
        table.add_column(name, no_wrap=name == "id", overflow="fold")
    for job in found:
        created = (job.created or "")[:16].replace("T", " ")
        table.add_row(job.id, job.name, job.state, f"{job.progress.share:.0%}", created, job.end or "")
    console_of().print(table)

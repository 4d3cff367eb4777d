"""Commands for several runs, or for a finished one; `app.cli.main` registers them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from app.cli.exit_codes import INTERRUPTED
from app.cli.terminal import AsJson, ProtocolPath, complain
from rigs.axes import Axis  # noqa: TC001 (typer reads the annotations)


def sweep(
    protocol: ProtocolPath,
    *,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the sweep.", show_default="runs/ and its name", file_okay=False)
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 1,
    plot: Annotated[
        list[str] | None,
        typer.Option("--plot", metavar="FIGURE", help="Words of a figure to plot: secant_peak_C; may be repeated."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Run every point of a protocol with `sweep:`, each into a folder named by its values, such as pre=0.1.

    Points that are done are skipped, those cut off are gone on with. One table and one plot sum them up; --plot draws
    figures of the table over the parameter, maps over two, or main effects of up to eight.
    """
    from app.cli.tables import print_sweep, sweep_data  # noqa: PLC0415
    from app.runs.sweeps import run_sweep  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    with Bar(hidden=quiet) as bar:
        result = run_sweep(protocol, out, bar.show, jobs=jobs, figures=plot or ())
    if as_json:
        print_json(sweep_data(result))
    else:
        print_sweep(result)
    for one in result.points:
        if one.outcome != "target":
            complain(f"{protocol}: {one.point.label}: {one.outcome}: {one.message}")
    if any(one.outcome == "abort" for one in result.points):
        raise typer.Exit(INTERRUPTED)


def plot(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders, or run.h5 files.")],
    *,
    out: Annotated[Path, typer.Option(help="File of the figure.", dir_okay=False)] = Path("stress_strain.png"),
    by_modulus: Annotated[
        bool, typer.Option("--by-modulus", help="Divide the stress by Young's modulus of the yarn.")
    ] = False,
    axis: Annotated[Axis | None, typer.Option(help="Draw one axis alone.")] = None,
) -> None:
    """Plot stress over strain of every axis that the runs pulled, coloured by axis, dashed by run."""
    from app.views.compare import compare_runs  # noqa: PLC0415

    sys.stdout.write(f"plot: {compare_runs(runs, out, by_modulus=by_modulus, axis=axis)}\n")

"""The command `knitlab report`."""

from __future__ import annotations

import sys
from pathlib import Path  # noqa: TC003 (typer reads the annotations)
from typing import Annotated, Final

import typer

from app.cli.terminal import AsJson  # noqa: TC001 (typer reads the annotations)

REPORT_HELP: Final = """\b
Examples:
  knitlab report runs/biaxial_cycle
  knitlab report runs/course runs/wale --out both.html --pdf"""


def report(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders, or run.h5 files.")],
    *,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File of the report.", show_default="in the run folder; of several runs report.html", dir_okay=False
        ),
    ] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write it as PDF too (knitlab[pdf]).")] = False,
    as_json: AsJson = False,
) -> None:
    """Write the report of runs, side by side: one HTML file with all that there is to know of them.

    Protocol, specimen, curves, results, pictures along the test, energies, what was assumed, versions and checksums;
    all from the records.
    """
    from app.views.report.page import report as reported  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    written = [str(path) for path in reported(runs, out, pdf=pdf)]
    if as_json:
        print_json({"files": written})
    else:
        sys.stdout.writelines(f"report: {path}\n" for path in written)

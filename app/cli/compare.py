"""The command `knitlab compare`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from app.cli.measured_options import (
    Cycle,
    GaugeLength,
    LeaveOut,
    Mapping,
    Offset,
    OneAxis,
    Slack,
    Thickness,
    Width,
    mapping_of,
)
from app.cli.terminal import AsJson  # noqa: TC001 (typer reads the annotations)

COMPARE_HELP: Final = """\b
Examples:
  knitlab compare examples/fabric/measured/course.csv --leave-out 1
  knitlab compare runs/course fabric.csv --axis C --slack 50mN --out course.png
  knitlab compare runs/course Specimen_RawData_*.csv --repeats --axis C
  knitlab compare runs/a runs/b --cycle 2 --table scores.csv
  knitlab compare tests.yaml"""


def compare(  # noqa: PLR0913 (each is an option)
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="RUN|FILE...", help="Run folders, files of instruments, and YAML files that list them."),
    ],
    *,
    out: Annotated[Path, typer.Option(help="File of the figure.", dir_okay=False)] = Path("comparison.png"),
    table: Annotated[
        Path | None, typer.Option(help="Write the scores to this .csv or .parquet file.", dir_okay=False)
    ] = None,
    axis: OneAxis = None,
    cycle: Cycle = 1,
    slack: Slack = None,
    offset: Offset = False,
    leave_out: LeaveOut = None,
    repeats: Annotated[bool, typer.Option("--repeats", help="All files are repeats of one test: one band.")] = False,
    mapping: Mapping = None,
    gauge_length: GaugeLength = None,
    width: Width = None,
    thickness: Thickness = None,
    as_json: AsJson = False,
) -> None:
    """Lay runs and measured files over each other: a figure, and scores against the first measured file.

    Repeats in a file make a band. Units and directions are made the same; each difference has its row in the table.
    """
    from app.records.table_files import write_table  # noqa: PLC0415
    from app.schemas.measured import alignment_of  # noqa: PLC0415
    from app.views.figure_tables import print_table  # noqa: PLC0415
    from app.views.overlay import compare as compared  # noqa: PLC0415

    found = compared(
        sources,
        out,
        mapping=mapping_of(mapping, gauge_length, width, thickness),
        alignment=alignment_of(cycle, slack, offset=offset),
        axis=axis,
        leave_out=leave_out or (),
        repeats=repeats,
    )
    if table is not None:
        write_table(found.scores, table)
    print_table(found.scores, as_json=as_json)
    if not as_json:
        sys.stdout.write(f"plot: {found.figure}\n")

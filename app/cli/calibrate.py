"""The command `knitlab calibrate`."""

from __future__ import annotations

import sys
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from app.cli.exit_codes import INTERRUPTED
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
from app.cli.terminal import AsJson, Chosen, ProtocolPath, complain, values_of

if TYPE_CHECKING:
    from app.studies.calibration import CalibrationResult

CALIBRATE_HELP: Final = """\b
Examples:
  knitlab calibrate fabric.yaml fabric.csv --fit E=0.5GPa:2GPa --fit mu=0.1:0.6 --axis C
  knitlab calibrate cell.yaml runs/a/cell.csv runs/b --fit E --fit r --jobs 2 --out runs/fit"""


def calibrate(  # noqa: PLR0913 (each is an option)
    protocol: ProtocolPath,
    measured: Annotated[
        list[Path], typer.Argument(metavar="MEASURED...", help="Files of instruments, logs, and run folders.")
    ],
    *,
    fit: Annotated[
        list[str],
        typer.Option(
            "--fit", metavar="NAME[=LOW:HIGH]", help="A name under params; half to twice its value unless said."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder of runs, tables and figure.", file_okay=False)] = Path(
        "runs/calibration"
    ),
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 1,
    chosen: Chosen = None,
    axis: OneAxis = None,
    cycle: Cycle = 1,
    slack: Slack = None,
    offset: Offset = False,
    leave_out: LeaveOut = None,
    mapping: Mapping = None,
    gauge_length: GaugeLength = None,
    width: Width = None,
    thickness: Thickness = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Fit parameters of a protocol to measured files or runs: estimates with intervals, table and figure.

    Loading, holds and unloading of a cycle are compared as `knitlab compare` aligns them. What the data do not tell is
    said and not estimated. Runs are kept: the same command again goes on where it was.
    """
    from app.schemas.measured import alignment_of  # noqa: PLC0415
    from app.studies.calibration import calibrate as calibrated  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    try:
        with Bar(hidden=quiet) as bar:
            found = calibrated(
                protocol,
                measured,
                fit,
                out,
                bar.show,
                jobs=jobs,
                chosen=values_of(chosen),
                mapping=mapping_of(mapping, gauge_length, width, thickness),
                alignment=alignment_of(cycle, slack, offset=offset),
                axis=axis,
                leave_out=leave_out or (),
            )
    except KeyboardInterrupt:
        complain(f"{protocol}: interrupted; the same command goes on with the runs in {out}")
        raise typer.Exit(INTERRUPTED) from None
    if as_json:
        print_json(calibration_data(found))
    else:
        _print(found)
    for line in (*found.estimates.unseen, *found.notes):
        complain(f"{protocol}: WARNING: {line}")


def calibration_data(found: CalibrationResult) -> dict[str, Any]:
    """Return a calibration as plain data; what is not known is null."""
    parameters = {
        one.parameter.name: {
            "unit": one.parameter.unit or "1",
            "estimate": _known(one.value),
            "low_95": _known(one.low),
            "high_95": _known(one.high),
            "used": one.used,
            "start": one.parameter.start,
            "bounds": [one.parameter.low, one.parameter.high],
            "at_bound": one.at_bound or None,
        }
        for one in found.estimates.each
    }
    return {
        "parameters": parameters,
        "correlation": [[_known(value) for value in row] for row in found.estimates.correlation.tolist()],
        "singular_values": found.estimates.singular_values.tolist(),
        "not_identifiable": list(found.estimates.unseen),
        "notes": list(found.notes),
        "rms_start": found.first,
        "rms": found.last,
        "runs": found.runs,
        "reused": found.reused,
        "files": [str(path) for path in found.files],
    }


def _known(value: float) -> float | None:
    return value if isfinite(value) else None


def _print(found: CalibrationResult) -> None:
    """Print estimates and correlations."""
    from rich.table import Table  # noqa: PLC0415

    from app.studies.fit_tables import note_of  # noqa: PLC0415
    from app.views.tables import console_of  # noqa: PLC0415

    names = [one.parameter.name for one in found.estimates.each]
    table = Table(
        "parameter", "estimate", "95 % interval", "start", "bounds", *names, "note", title="correlations at right"
    )
    for one, row in zip(found.estimates.each, found.estimates.correlation, strict=True):
        what = one.parameter
        unit = f"{' ' * bool(what.unit)}{what.unit}"
        table.add_row(
            what.name,
            f"{one.value:.5g}{unit}" if isfinite(one.value) else "-",
            f"{one.low:.5g} to {one.high:.5g}{unit}" if isfinite(one.low) else "-",
            f"{what.start:.5g}{unit}",
            f"{what.low:.4g} to {what.high:.4g}{unit}",
            *(f"{value:.2f}" if isfinite(value) else "-" for value in row),
            note_of(one),
        )
    console_of().print(table)
    sys.stdout.write(
        f"difference of the curves (rms, in their range): {100.0 * found.first:.3g} % at first, "
        f"{100.0 * found.last:.3g} % now\n"
        f"runs: {found.runs}, {found.reused} of them done before\n"
    )
    for label, path in zip(("table", "curves", "plot"), found.files, strict=True):
        sys.stdout.write(f"{label}: {path}\n")

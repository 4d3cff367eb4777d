"""The command `knitlab analyse`."""

from __future__ import annotations

import sys
from pathlib import Path  # noqa: TC003 (typer reads the annotations)
from typing import TYPE_CHECKING, Annotated, Final

import typer

from app.cli.measured_options import GaugeLength, Mapping, Thickness, Width, mapping_of
from app.cli.terminal import AsJson  # noqa: TC001 (typer reads the annotations)
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from rigs.analysis.choices import Choices, Window

ANALYSE_HELP: Final = """\b
Tables of any test:
  results        maximum force, what holds there and at break, moduli, hysteresis of every cycle
  curves         every row: time, travel, force, strain, stress
  fits           exponential fit of every loading, and its test against a kinked line
  repeatability  NRMSE of every two loadings
  holds          relaxation and creep
  poisson        contraction over stretch, row by row

\b
Tables of runs alone:
  energy    shares of the stored energy; what was lost of the work
  contacts  touching pairs
  hooks     force of a hook along its pole over the one it pulls with
  bonds     histogram of the breaks of fused points over strain
  shapes    stretch of the yarn, angles of the loops' legs, contraction

\b
Examples:
  knitlab analyse runs/first --json
  knitlab analyse runs/first --table energy --out energy.parquet
  knitlab analyse fabric.csv --gauge-length 69.2mm --width 66.56mm --window 0:5% --window 30%:40%"""


def analyse(
    place: Annotated[
        Path, typer.Argument(metavar="RUN|FILE", help="Run folder, run.h5 file, or an instrument's file.")
    ],
    *,
    table: Annotated[
        str | None, typer.Option(help="One of the tables below.", show_default="results of a file")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the table to this .csv or .parquet file.", dir_okay=False)
    ] = None,
    window: Annotated[
        list[str] | None,
        typer.Option(metavar="FROM:TO", help="Strains of a modulus, from where a cycle sets out; may be repeated."),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(metavar="FROM:TO", help="Strains between which is fitted.", show_default="2 % of the stress on"),
    ] = None,
    mapping: Mapping = None,
    gauge_length: GaugeLength = None,
    width: Width = None,
    thickness: Thickness = None,
    as_json: AsJson = False,
) -> None:
    """Work out the figures of a run, or of a file that an instrument wrote.

    Of a run without --table it prints how the steps ended, and stresses, secant moduli and loop areas of every cycle.
    """
    from app.records.analysis import analyse as table_of  # noqa: PLC0415
    from app.records.analysis import is_run  # noqa: PLC0415
    from app.records.table_files import write_table  # noqa: PLC0415
    from app.views.figure_tables import print_table  # noqa: PLC0415

    if table is None and out is None and is_run(place):
        _summary(place, as_json=as_json)
        return
    known = mapping_of(mapping, gauge_length, width, thickness)
    found = table_of(place, table or "results", mapping=known, choices=choices_of(window, fit))
    if out is not None:
        sys.stdout.write(f"table: {write_table(found, out)}\n")
    else:
        print_table(found, as_json=as_json)


def _summary(place: Path, *, as_json: bool) -> None:
    """Print how the steps of a run ended, and its figures."""
    from dataclasses import asdict  # noqa: PLC0415

    from app.records.reader import read_run  # noqa: PLC0415
    from app.records.results import figures_of  # noqa: PLC0415
    from app.views.tables import (  # noqa: PLC0415
        figures_data,
        print_crossings,
        print_figures,
        print_json,
        print_losses,
        print_steps,
    )

    found = read_run(place)
    figures = figures_of(found)
    if as_json:
        steps = [asdict(step) for step in found.steps]
        crossings, losses = [one.data() for one in found.crossings], [one.data() for one in found.losses]
        data = {"outcome": found.outcome.end, "crossings": crossings, "losses": losses, "steps": steps}
        print_json({**data, "figures": figures_data(figures)})
    else:
        print_crossings(found.crossings)
        print_losses(found.losses)
        print_steps(found.steps)
        print_figures(figures)


def choices_of(windows: list[str] | None, fit: str | None) -> Choices:
    """Return what is asked of an analysis by words of the command line."""
    from rigs.analysis.choices import Choices  # noqa: PLC0415

    plain = Choices()
    return Choices(
        windows=tuple(_window("--window", one) for one in windows) if windows else plain.windows,
        fit=None if fit is None else _window("--fit", fit),
    )


def _window(option: str, text: str) -> Window:
    """Return the two strains of a window, ``0:5%`` [1]."""
    from app.schemas.units import parse  # noqa: PLC0415

    first, colon, last = text.partition(":")
    try:
        ends = [parse(float(end) if not end.strip().endswith("%") else end, "strain", option) for end in (first, last)]
    except ValueError as error:
        raise SpecificationError(option, text, "two strains, such as 0:5% or 0.3:0.4") from error
    if not colon or ends[0] >= ends[1]:
        raise SpecificationError(option, text, "two strains that rise, such as 0:5% or 0.3:0.4")
    return ends[0], ends[1]

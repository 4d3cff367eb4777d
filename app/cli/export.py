"""The command `knitlab export`."""

from __future__ import annotations

import sys
from pathlib import Path  # noqa: TC003 (typer reads the annotations)
from typing import Annotated, Final, Literal, TypeAlias

import typer

from app.cli.terminal import AsJson  # noqa: TC001 (typer reads the annotations)

Kind: TypeAlias = Literal["link", "copy"]

EXPORT_HELP: Final = """\b
Dialects:
  biotester           the biaxial stage's, as CellScale's BioTester
  bluehill-universal  the frame's, as Instron's Bluehill Universal
  bluehill3           the frame's cycles, as Instron's Bluehill 3
  bluehill3-quoted    the frame's with strain and stress, as Instron's Bluehill 3
  bluehill3-results   the frame's results table and raw data, as Instron's Bluehill 3
  triaxial            stage and frame of the triaxial rig in one table
  alemnis             the nanoindenter's workbook, as Alemnis'
  alemnis-tsv         the same columns as text between tabs
  shear-stage         the shear stage's: displacement, force, strain and stress of every axis

\b
Examples:
  knitlab export runs/biaxial_cycle
  knitlab export runs/uniaxial_course --dialect bluehill3 --locale de
  knitlab export runs/uniaxial_course --dialect bluehill-universal --units force=mN,length=um
  knitlab export runs/uniaxial_course --shapes link"""


def export(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder, or run.h5 file.", show_default=False)],
    *,
    dialect: Annotated[
        str | None, typer.Option(help="One of those below.", show_default="that of each machine")
    ] = None,
    locale: Annotated[str, typer.Option(help="Marks of numbers and dates: en, de or fr.")] = "en",
    units: Annotated[
        str | None,
        typer.Option(help="Other units, by quantity: force=mN,length=um.", show_default="the dialect's"),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the files.", show_default="the run folder", file_okay=False)
    ] = None,
    shapes: Annotated[
        Kind | None,
        typer.Option(
            help="Write no log but run.h5 as NAME.vtkhdf, which ParaView and pyvista open by its name: "
            "a link to the same file, or a copy."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write the logs of a run from its run.h5, under the names that the instruments give them; or its shapes."""
    from app.records.export import export_run  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    files: tuple[Path, ...]
    if shapes is not None:
        files, kind = (_shapes(run, shapes, dialect, locale, units, out),), "shapes"
    else:
        files, kind = export_run(run, dialect=dialect, locale=locale, units=units, out=out), "log"
    if as_json:
        print_json({"files": [str(path) for path in files]})
    else:
        sys.stdout.writelines(f"{kind}: {path}\n" for path in files)


def _shapes(run: Path, kind: Kind, dialect: str | None, locale: str, units: str | None, out: Path | None) -> Path:
    """Write the shapes; options of logs are none of theirs."""
    from app.records.export_shapes import export_shapes  # noqa: PLC0415
    from knitlab_core.errors import SpecificationError  # noqa: PLC0415

    if dialect is not None or units is not None or locale != "en":
        raise SpecificationError("--shapes", "an option of logs beside it", "--shapes with --out and --json alone")
    return export_shapes(run, kind, out)

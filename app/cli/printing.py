"""Command that checks a knit for a 3D printer and writes its surface; `app.cli.main` registers it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from app.cli.exit_codes import NOT_PRINTABLE
from app.cli.terminal import AsJson, ProtocolPath  # noqa: TC001 (typer reads the annotations)

PRINT_HELP: Final = """\b
Examples:
  knitlab print examples/biaxial_cycle.yaml --out print --slices
  knitlab print examples/biaxial_cycle.yaml --printer nanoscribe --format stl --json"""


def print_(
    protocol: ProtocolPath,
    *,
    printer: Annotated[str, typer.Option(help="j35, nanoscribe, or the path of a printer's YAML file.")] = "j35",
    out: Annotated[
        Path | None, typer.Option(help="Folder for the files.", show_default="the current folder", file_okay=False)
    ] = None,
    kind: Annotated[Literal["stl", "3mf", "both"], typer.Option("--format", help="File of the surface.")] = "both",
    chord_error: Annotated[
        str | None,
        typer.Option(help="How far the mesh may lie off the fibre: 10 um.", show_default="half a layer"),
    ] = None,
    slices: Annotated[bool, typer.Option("--slices", help="Also cut layers; a sheet of twelve.")] = False,
    every: Annotated[
        int | None, typer.Option(help="Also draw every N-th layer, to scale.", min=1, show_default=False)
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Make the surface of a knit, check that a printer can make it, and write it as STL and 3MF in mm.

    Each fibre is a closed tube along the smooth yarn. It must be whole, thick enough to print, and clear of itself
    by more than the printer fuses; found and allowed stand side by side. Files are written all the same; a check that
    is not met ends with exit code 6. Needs the extra: pip install 'knitlab[printing]'.
    """
    from app.printing import require_extra  # noqa: PLC0415

    require_extra()
    from app.printing.job import Wanted, print_knit  # noqa: PLC0415
    from app.printing.printers import read_printer_data  # noqa: PLC0415
    from app.printing.show import print_data, show_print  # noqa: PLC0415
    from app.schemas import load  # noqa: PLC0415
    from app.schemas.units import parse  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    data = read_printer_data(printer)
    wanted = Wanted(
        formats=("stl", "3mf") if kind == "both" else (kind,),
        sheet=slices,
        every=every,
        chord_error=None if chord_error is None else parse(chord_error, "length", "--chord-error"),
    )
    with Bar(hidden=quiet) as bar:
        made = print_knit(load(protocol), data, Path() if out is None else out, wanted, bar.show)
    if as_json:
        print_json(print_data(made, data))
    else:
        show_print(made, data)
    raise typer.Exit(0 if made.printable else NOT_PRINTABLE)

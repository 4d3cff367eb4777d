"""The command `knitlab images`."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path  # noqa: TC003 (typer asks for the types of the options)
from typing import Annotated, Final

import typer

SHORT: Final = "Render a run's frames as an electron microscope shows them."
EXAMPLE: Final = "\b\nExample:\n  knitlab images runs/fig5_micro --tilt 60 --width 2048"


def images(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder, or run.h5 file.", show_default=False)],
    *,
    tilt: Annotated[
        float | None,
        typer.Option(help="Beam to pile, degrees: 0 from above, 90 across.", show_default="by the specimen"),
    ] = None,
    rotation: Annotated[
        float | None, typer.Option(help="Specimen about its pile, degrees.", show_default="by the specimen")
    ] = None,
    width: Annotated[int, typer.Option(help="Pixels along an image: 1024 or 2048.")] = 1024,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the images.", show_default="images in the run's", file_okay=False)
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
) -> None:
    """Render a run's frames as an electron microscope shows them: TIFF with scale, data bar and ZEISS tag.

    These are the frames that the protocol took images of; of a run without, those of its picture of the knit.
    """
    from app.file_names import file_stem  # noqa: PLC0415 (as those below)
    from app.records.reader import read_run  # noqa: PLC0415 (heavy)
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.sem.images import IMAGES, usual_look, write_images  # noqa: PLC0415

    record = read_run(run)
    look = usual_look(record, width)
    look = replace(
        look,
        tilt=look.tilt if tilt is None else tilt,
        rotation=look.rotation if rotation is None else rotation,
    )
    name = file_stem(str(record.provenance.get("name", "knit")))
    with Bar(hidden=quiet) as bar:
        written = write_images(record, record.path.parent / IMAGES if out is None else out, name, look, bar.show)
    for one in written:
        sys.stdout.write(f"image: {one}\n")

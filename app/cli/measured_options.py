"""Options of commands that take measured files: what a file does not say, and how tests are laid over each other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from rigs.analysis.alignment import Alignment
    from rigs.readers.mapping import FileMapping

Mapping = Annotated[
    Path | None,
    typer.Option(
        help="What a measured file does not say (YAML).", show_default="one of its name beside it", dir_okay=False
    ),
]
GaugeLength = Annotated[str | None, typer.Option(help="Distance of the hooks at no strain: 45 mm.")]
Width = Annotated[str | None, typer.Option(help="Width of the specimen, for stress: 40 mm.")]
Thickness = Annotated[str | None, typer.Option(help="Its thickness.", show_default="1 mm")]
OneAxis = Annotated[str | None, typer.Option(help="Take one axis alone; files that name none are of it.")]
Cycle = Annotated[int, typer.Option(help="Which cycle of each.", min=1)]
Slack = Annotated[
    str | None, typer.Option(help="Count strain from where this force is reached: 50 mN.", show_default="off")
]
Offset = Annotated[bool, typer.Option("--offset", help="Count force from its mean before the start.")]
LeaveOut = Annotated[
    list[int] | None, typer.Option("--leave-out", help="Repeat of the files to leave out; may be repeated.")
]


def mapping_of(path: Path | None, gauge_length: str | None, width: str | None, thickness: str | None) -> FileMapping:
    """Return what is known of a measured file: a mapping, and lengths that go before its own."""
    from dataclasses import replace  # noqa: PLC0415

    from app.schemas.measured import load_mapping  # noqa: PLC0415
    from app.schemas.units import parse  # noqa: PLC0415
    from rigs.readers.mapping import FileMapping  # noqa: PLC0415

    known = FileMapping() if path is None else load_mapping(path)

    def length(option: str, text: str | None, otherwise: float) -> float:
        if text is None:
            return otherwise
        found = parse(text, "length", option)
        if found <= 0.0:
            raise SpecificationError(option, text, "a length above 0 m")
        return found

    return replace(
        known,
        gauge_length=length("--gauge-length", gauge_length, known.gauge_length),
        width=length("--width", width, known.width),
        thickness=length("--thickness", thickness, known.thickness),
    )


def alignment_of(cycle: int, slack: str | None, *, offset: bool) -> Alignment:
    """Return how tests are laid over each other by the options of a command.

    Raises
    ------
    SpecificationError
        If the slack is no force.
    """
    from app.schemas.units import parse  # noqa: PLC0415
    from rigs.analysis.alignment import Alignment  # noqa: PLC0415

    return Alignment(cycle=cycle, slack=None if slack is None else parse(slack, "force", "--slack"), offset=offset)

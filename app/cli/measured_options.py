"""Options of commands that take measured files: what a file does not say, and how tests are laid over each other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
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
    from app.schemas.measured import load_mapping, with_lengths  # noqa: PLC0415
    from rigs.readers.mapping import FileMapping  # noqa: PLC0415

    return with_lengths(FileMapping() if path is None else load_mapping(path), gauge_length, width, thickness)

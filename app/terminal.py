"""What the commands share: their commonest arguments, and how they complain."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

ProtocolPath = Annotated[Path, typer.Argument(metavar="PROTOCOL", help="Protocol file (YAML).", show_default=False)]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of tables.")]


def complain(message: str) -> None:
    """Print one line to stderr."""
    sys.stderr.write(" ".join(message.split()) + "\n")


def warn(protocol: Path, warnings: Sequence[str]) -> None:
    """Print each warning on a line of its own to stderr."""
    for warning in warnings:
        complain(f"{protocol}: WARNING: {warning}")

"""Arguments that commands share, and how they report errors and warnings."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.schemas.document import Data
    from knitlab_core.errors import KnitlabError

MOST_MISTAKES: Final = 20
"""Lines in which a protocol's mistakes are said."""

ProtocolPath = Annotated[Path, typer.Argument(metavar="PROTOCOL", help="Protocol file (YAML).", show_default=False)]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of tables.")]
Token = Annotated[
    str | None,
    typer.Option(envvar="KNITLAB_TOKEN", help="Token of the service.", show_envvar=True, show_default=False),
]
Chosen = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Value for one of its params; may be repeated."),
]


def values_of(chosen: list[str] | None) -> dict[str, Data]:
    """Parse values of parameters given on the command line.

    Raises
    ------
    SpecificationError
        If a word is not NAME=VALUE.

    Examples
    --------
    >>> values_of(["pre=0.1", "rate=0.2 mm/s"])
    {'pre': 0.1, 'rate': '0.2 mm/s'}
    """
    from app.schemas.document import scalar  # noqa: PLC0415

    values: dict[str, Data] = {}
    for word in chosen or ():
        name, sign, value = word.partition("=")
        if not (name and sign and value):
            raise SpecificationError("--set", word, "NAME=VALUE, such as pre=0.1")
        values[name] = scalar(value)
    return values


def complain(message: str) -> None:
    """Print one line to stderr."""
    with suppress(OSError):  # stderr may go to a full disk too
        sys.stderr.write(" ".join(message.split()) + "\n")


def complain_of(error: KnitlabError) -> None:
    """Print the errors, one line each, at most the first twenty."""
    every = [error, *error.more] if isinstance(error, SpecificationError) else [error]
    for one in every[:MOST_MISTAKES]:
        complain(str(one))
    if len(every) > MOST_MISTAKES:
        complain(f"... and {len(every) - MOST_MISTAKES} more")


def warn(protocol: Path, warnings: Sequence[str]) -> None:
    """Print each warning on a line of its own to stderr."""
    for warning in warnings:
        complain(f"{protocol}: WARNING: {warning}")

"""Errors of SCPI-99 that a live rig gives, and which of them an error of knitlab is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError, UnitError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.errors import KnitlabError

ERRORS: Final[Mapping[int, str]] = {
    0: "No error",
    -101: "Invalid character",
    -102: "Syntax error",
    -104: "Data type error",
    -108: "Parameter not allowed",
    -109: "Missing parameter",
    -113: "Undefined header",
    -131: "Invalid suffix",
    -200: "Execution error",
    -221: "Settings conflict",
    -222: "Data out of range",
    -223: "Too much data",
    -224: "Illegal parameter value",
    -350: "Queue overflow",
    -363: "Input buffer overrun",
}
"""Errors of SCPI-99 that a rig gives."""


class CommandError(Exception):
    """A command that cannot be done: the number of its error, and what is wrong."""

    def __init__(self, number: int, detail: str) -> None:
        super().__init__(number, detail)
        self.number = number
        self.detail = detail


def as_command_error(error: KnitlabError) -> CommandError:
    """Return an error of knitlab under its number in SCPI."""
    number = -200
    if isinstance(error, UnitError):
        number = -131
    elif isinstance(error, SpecificationError):
        ended = isinstance(error.found, str) and error.found.startswith(("a test that has ended", "a rig that is"))
        number = -221 if ended else -222
    return CommandError(number, str(error))

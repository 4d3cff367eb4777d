"""Say where in a protocol file an error stands: file:line:column, as editors and compilers do."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterable

_LONGEST: Final = 80


class Mark(Protocol):
    """Be a place in a text, counted from 0."""

    line: int
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """Be a place in a text, counted from 1."""

    line: int
    column: int

    @classmethod
    def at(cls, mark: Mark) -> Spot:
        """Return the spot of a parser's mark."""
        return cls(line=mark.line + 1, column=mark.column + 1)


class ProtocolError(SpecificationError):
    """Refuse a protocol at one spot of its file.

    Parameters
    ----------
    path : str
        The file.
    spot : Spot
        Where in it.
    field : str
        Which field, dotted from the root.
    found : object
        What was found there, ready to print.
    expected : str
        What is allowed.

    Examples
    --------
    >>> print(ProtocolError("p.yaml", Spot(line=3, column=7), "rig", "'hook'", "biaxial-hook"))
    p.yaml:3:7: rig: found 'hook', allowed biaxial-hook
    """

    def __init__(self, path: str, spot: Spot, field: str, found: str, expected: str) -> None:
        super().__init__(field, found, expected)
        self.path = path
        self.spot = spot

    def __str__(self) -> str:
        """Return one line: ``file:line:column: field: found X, allowed Y``."""
        field = self.field if len(self.field) <= _LONGEST else f"{self.field[:_LONGEST]}..."
        line = f"{self.path}:{self.spot.line}:{self.spot.column}: {field}: found {self.found}, allowed {self.expected}"
        # A terminal obeys control characters, and a file may hold any.
        return " ".join("".join(char if char.isprintable() else " " for char in line).split())


def shown(value: object) -> str:
    """Return a value as an error shows it: short, on one line.

    Examples
    --------
    >>> shown("8 mm"), shown({"a": 1}), shown([1, 2]), shown(None)
    ("'8 mm'", 'a mapping', 'a list', 'nothing')
    """
    match value:
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case str() | int() | float():
            text = repr(value)
            return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
        case _:
            return str(value)


def nearest(name: str, known: Iterable[str]) -> str:
    """Return a question after the known name a misspelt one may mean, or nothing.

    Examples
    --------
    >>> nearest("specimn", ["specimen", "steps"])
    ' (did you mean specimen?)'
    """
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f" (did you mean {close[0]}?)" if close else ""

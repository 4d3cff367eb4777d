"""Errors of a protocol file with their place, ``file:line:column``, as compilers write it."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol, TypeVar

from knitlab_core.errors import SpecificationError, raise_all

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

_LONGEST: Final = 80
_T = TypeVar("_T")


class Mark(Protocol):
    """A place in a text, counted from 0."""

    line: int
    column: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """A place in a text, counted from 1."""

    line: int
    column: int

    @classmethod
    def at(cls, mark: Mark) -> Spot:
        """Return the spot of a parser's mark."""
        return cls(line=mark.line + 1, column=mark.column + 1)


class ProtocolError(SpecificationError):
    """A protocol file is wrong at one place.

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
    missing : bool
        Whether a field of the file is wanting, so that the spot is that of what should hold it.

    Examples
    --------
    >>> print(ProtocolError("p.yaml", Spot(line=3, column=7), "rig", "'hook'", "biaxial-hook"))
    p.yaml:3:7: rig: found 'hook', allowed biaxial-hook
    """

    def __init__(self, path: str, spot: Spot, field: str, found: str, expected: str, *, missing: bool = False) -> None:
        super().__init__(field, found, expected)
        self.path = path
        self.spot = spot
        self.missing = missing

    def __reduce__(self) -> tuple[object, ...]:
        """Support pickling, for errors of other processes."""
        return (
            type(self),
            (self.path, self.spot, self.field, self.found, self.expected),
            {"more": self.more, "missing": self.missing},
        )

    def __str__(self) -> str:
        """Return one line: ``file:line:column: field: found X, allowed Y``."""
        field = self.field if len(self.field) <= _LONGEST else f"{self.field[:_LONGEST]}..."
        line = f"{self.path}:{self.spot.line}:{self.spot.column}: {field}: found {self.found}, allowed {self.expected}"
        # Control characters of a file must not reach a terminal.
        return " ".join("".join(char if char.isprintable() else " " for char in line).split())


class SweptProtocolError(ProtocolError):
    """A protocol is a sweep where one test is wanted."""


class Faults:
    """Collector of the errors of several parts of a protocol, so that all are reported at once."""

    def __init__(self) -> None:
        self.found: list[SpecificationError] = []

    def of(self, make: Callable[[], _T], otherwise: _T) -> _T:
        """Return a part, or record its error and return a substitute."""
        try:
            return make()
        except SpecificationError as error:
            self.found.append(error)
            return otherwise

    def raise_any(self) -> None:
        """Raise the errors that were recorded, if any."""
        raise_all(self.found)


def in_order(errors: Sequence[ProtocolError]) -> ProtocolError:
    """Return the first of some errors with the others as its `more`: in the order of the file, what is missing last.

    Of several at one spot the first stays: what follows from a mistake is none of its own.
    """
    single = [one for error in errors for one in (error, *error.more) if isinstance(one, ProtocolError)]
    by_spot: dict[object, ProtocolError] = {}
    for one in single:
        by_spot.setdefault((one.path, one.spot, one.field if one.found == "nothing" else ""), one)
    first, *others = sorted(by_spot.values(), key=lambda one: (one.missing, one.path, one.spot.line, one.spot.column))
    first.more = tuple(others)
    return first


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
    """Return a question that suggests the most similar known name; empty if none is similar.

    What begins as the name does goes before what has it for a word, and that before what is spelt much like it.

    Examples
    --------
    >>> nearest("specimn", ["specimen", "steps"]), nearest("biaxial", ["triaxial", "biaxial-hook"])
    (' (did you mean specimen?)', ' (did you mean biaxial-hook?)')
    """
    plain, options = name.strip().casefold(), list(known)
    folded = [option.casefold() for option in options]
    starting = [option for option, text in zip(options, folded, strict=True) if plain and text.startswith(plain)]
    worded = [option for option, text in zip(options, folded, strict=True) if plain in re.split(r"[\W_]+", text)]
    # One or two letters are a hint only if a single name starts with them.
    found = starting[:1] if len(plain) > 2 or len(starting) == 1 else []
    close = difflib.get_close_matches(plain, folded, n=1, cutoff=0.6)
    found += worded[:1] + [options[folded.index(text)] for text in close]
    return f" (did you mean {found[0]}?)" if found else ""

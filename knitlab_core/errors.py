"""Errors of knitlab.

KnitlabError                          anything knitlab raises on purpose
├── SpecificationError                a value that was asked for is not allowed
│   ├── UnitError                     ... because of its unit
│   └── GeometryError                 ... because strands overlap or are not knitted
├── SolverError                       the physics could not be computed
│   └── ConvergenceError              an equilibrium was not found
└── FormatError                       a file has not the content that it should

Rupture, overload and limits are outcomes of a test, not errors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


class KnitlabError(Exception):
    """Base of every error that knitlab raises on purpose."""


class SpecificationError(KnitlabError):
    """Value out of its range: the field, what was found and what is allowed.

    Parameters
    ----------
    field : str
        Name of the field, dotted from the root: ``specimen.radius``.
    found : object
        The value that was given; shown by its ``repr``.
    expected : str
        What is allowed, as a phrase: ``a length above 0 m``.

    Attributes
    ----------
    more : tuple of SpecificationError
        What else is wrong, where several values were checked together.

    Examples
    --------
    >>> print(SpecificationError("specimen.rows", -1, "a whole number from 1"))
    specimen.rows: found -1, allowed a whole number from 1
    """

    def __init__(self, field: str, found: object, expected: str) -> None:
        super().__init__(field, found, expected)
        self.field = field
        self.found = found
        self.expected = expected
        self.more: tuple[SpecificationError, ...] = ()

    def __str__(self) -> str:
        """Return one line: ``field: found X, allowed Y``."""
        line = f"{self.field}: found {self.found!r}, allowed {self.expected}"
        return " ".join(line.split())


def raise_all(faults: Sequence[SpecificationError]) -> None:
    """Raise the first of some faults, with the others as its `more`; nothing if there is none."""
    single = [one for fault in faults for one in (fault, *fault.more)]
    if single:
        first, *others = single
        first.more = tuple(others)
        raise first


class UnitError(SpecificationError):
    """Quantity whose unit is missing, unknown or of another dimension."""


class GeometryError(SpecificationError):
    """Specimen whose strands overlap, or whose loops do not hold each other."""


class SolverError(KnitlabError):
    """Base of the errors of the solver."""


class ConvergenceError(SolverError):
    """Report that no equilibrium was found.

    Parameters
    ----------
    report : object
        The solver's account of its last attempt; its ``str`` is the message and names the place.
    """

    def __init__(self, report: object) -> None:
        super().__init__(report)
        self.report = report


class FormatError(KnitlabError):
    """File that is wrong at one of its lines.

    Parameters
    ----------
    path : str or Path
        The file.
    line : int
        Line number, from 1.
    expected : str
        What should have stood there.

    Examples
    --------
    >>> print(FormatError("log.csv", 3, "a header of ten columns"))
    log.csv:3: expected a header of ten columns
    """

    def __init__(self, path: str | Path, line: int, expected: str) -> None:
        super().__init__(path, line, expected)
        self.path = path
        self.line = line
        self.expected = expected

    def __str__(self) -> str:
        """Return one line: ``path:line: expected Y``."""
        return f"{self.path}:{self.line}: expected {self.expected}"

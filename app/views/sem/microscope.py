"""Reader of the microscope's data file."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING

from app.schemas.machine_data import read_numbers
from knitlab_core.errors import FormatError
from rigs.machines.microscope import Microscope

if TYPE_CHECKING:
    from pathlib import Path


def read_microscope(path: Path | None = None) -> Microscope:
    """Read the numbers of the microscope.

    Parameters
    ----------
    path : Path or None
        A file in the form of ``rigs/data/sem.yaml``; None for that one.

    Raises
    ------
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    """
    source = path or files("rigs") / "data" / "sem.yaml"
    built = read_numbers(Microscope, source)
    if not isinstance(built, Microscope):
        raise FormatError(source.name, 1, "the numbers of a microscope")
    return built

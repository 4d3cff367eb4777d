"""Printers by name, and their data files."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.schemas.machine_data import read_numbers
from knitlab_core.errors import FormatError, SpecificationError
from knitlab_core.knits.loop_shape import is_positive
from rigs.machines.printer import PrinterData

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

_LENGTHS: Final = ("layer_height", "resolution", "smallest_feature", "clearance")


def printer_names() -> tuple[str, ...]:
    """Return the names of the printers that come with the package."""
    names = (entry.name for entry in _printers().iterdir())
    return tuple(sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml")))


def read_printer_data(printer: str) -> PrinterData:
    """Read the numbers of a printer.

    Parameters
    ----------
    printer : str
        A name of `printer_names`, or the path of a file in the form of ``rigs/data/printers/j35.yaml``.

    Returns
    -------
    PrinterData
        Every number with its source.

    Raises
    ------
    SpecificationError
        If there is no such printer, or one of its numbers is not above 0.
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    """
    names = printer_names()
    if printer in names:
        source: Traversable = _printers() / f"{printer}.yaml"
    elif printer.endswith((".yaml", ".yml")) and Path(printer).is_file():
        source = Path(printer)
    else:
        raise SpecificationError("printer", printer, f"{', '.join(names)}, or the path of a .yaml file")
    built = read_numbers(PrinterData, source)
    if not isinstance(built, PrinterData):
        raise FormatError(source.name, 1, "the numbers of a printer")
    for name in _LENGTHS:
        datum = getattr(built, name)
        if not is_positive(datum.value):
            raise SpecificationError(f"{source.name}: {name}", datum.value, "a length above 0 m")
        if datum.unit != "m":
            raise SpecificationError(f"{source.name}: {name}.unit", datum.unit, "m")
    return built


def _printers() -> Traversable:
    return files("rigs") / "data" / "printers"

"""Whether the knit of a protocol can be printed: a quick look for proposals, all checks for the last one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from app.checks.specimen_facts import facts_of
from app.printing import require_extra
from app.printing.job import Wanted, print_knit
from app.printing.printers import read_printer_data
from app.runs.runner import quiet
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from app.printing.checks import Check
    from app.schemas import Loaded
    from rigs.machines.printer import PrinterData

NONE: Final = "none"
"""Printer of a design that is not to be printed."""


def printer_of(name: str) -> PrinterData | None:
    """Return the numbers of a design's printer; None for one that is not to be printed.

    Raises
    ------
    SpecificationError, FormatError
        If there is no such printer, or the extra for its checks is not installed.
    """
    if name == NONE:
        return None
    require_extra()
    return read_printer_data(name)


def refusal(loaded: Loaded, printer: PrinterData | None) -> str:
    """Return why a knit cannot be knitted or printed, by its thickness and its narrowest gap; empty if it can."""
    try:
        facts = facts_of(loaded.protocol)
    except SpecificationError as error:
        return str(error)
    if printer is None:
        return ""
    if loaded.protocol.specimen.measured is not None:
        return "a yarn by measurement is spun, not printed (printer: none)"
    for name, found, least in (
        ("fibre diameter", 2.0 * facts.fibre_radius, printer.smallest_feature.value),
        ("gap", facts.clearance, printer.clearance.value),
    ):
        if found < least:
            return f"{name} of {1e3 * found:.4g} mm, {printer.printer} needs {1e3 * least:.4g} mm"
    return ""


def print_checks(loaded: Loaded, printer: PrinterData, folder: Path) -> Sequence[Check]:
    """Return all checks of a knit for a printer, no files written; of a cell those of the specimen of its stitches."""
    spec = replace(loaded.protocol.specimen, periodic=False)
    alone = replace(loaded, protocol=replace(loaded.protocol, specimen=spec))
    return print_knit(alone, printer, folder, Wanted(formats=()), quiet).checks

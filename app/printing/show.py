"""Output of a print check: tables in a terminal, or plain data."""

from __future__ import annotations

from dataclasses import fields
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from rigs.machines.machine import Datum

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.printing.checks import Check
    from app.printing.job import Print
    from rigs.machines.printer import PrinterData

_LISTED: Final = 4


def print_data(made: Print, printer: PrinterData) -> dict[str, Any]:
    """Return the outcome as plain data, SI units."""
    return {
        "printable": made.printable,
        "printer": {
            "name": printer.printer,
            **{
                f"{name}_m": {"value": datum.value, "source": datum.source, "assumed": datum.assumed}
                for name, datum in _numbers(printer)
            },
        },
        "checks": [_check_data(check) for check in made.checks],
        "surface": {
            "fibres": made.fibres,
            "sides": made.sides,
            "rings": made.rings,
            "triangles": made.triangles,
            "chord_error_m": made.chord_error,
        },
        "extent_m": list(made.extent),
        "volume_m3": made.volume,
        "layers": made.layers,
        "files": [str(path) for path in made.files],
    }


def show_print(made: Print, printer: PrinterData) -> None:
    """Print the printer's numbers, the table of checks and the files to stdout."""
    console = Console(highlight=False, markup=False)
    console.print(f"printer: {printer.printer}")
    numbers = (
        f"{_words(name)} {_metres(datum.value)}{' (assumed)' if datum.assumed else ''}"
        for name, datum in _numbers(printer)
    )
    console.print(f"  {', '.join(numbers)}", soft_wrap=True)
    sizes = " x ".join(_metres(side) for side in made.extent)
    console.print(f"print: {sizes}, {made.layers} layers, {1e9 * made.volume:.4g} mm³ of material", soft_wrap=True)
    console.print(
        f"surface: {made.fibres} fibre(s), {made.triangles} triangles "
        f"({made.rings} rings of {made.sides}), chord error {_metres(made.chord_error)}",
        soft_wrap=True,
    )
    table = Table(box=SIMPLE, pad_edge=False)
    for heading in ("check", "found", "allowed", "", ""):
        table.add_column(heading, no_wrap=True)
    for check in made.checks:
        verdict = "met" if check.met else "NOT MET"
        table.add_row(check.name, _figure(check, check.found), _allowed(check), verdict, check.note)
    console.print(table)
    console.print(f"printable: {'yes' if made.printable else 'no'}")
    for path in made.files[:_LISTED]:
        console.print(f"file: {path}", soft_wrap=True)
    if len(made.files) > _LISTED:
        console.print(f"... and {len(made.files) - _LISTED} files more, to {made.files[-1]}", soft_wrap=True)


def _numbers(printer: PrinterData) -> Iterator[tuple[str, Datum]]:
    """Yield the name and value of each number of a printer."""
    for field in fields(printer):
        value = getattr(printer, field.name)
        if isinstance(value, Datum):
            yield field.name, value


def _check_data(check: Check) -> dict[str, Any]:
    """Return a check as plain data; lengths in m, missing bounds as null."""
    scale = 1e-3 if check.unit == "mm" else 1.0
    found, least, most = (scale * one if isfinite(one) else None for one in (check.found, check.least, check.most))
    return {
        "name": check.name,
        "found": found,
        "least": least,
        "most": most,
        "unit": "m" if check.unit == "mm" else check.unit,
        "met": check.met,
        "note": check.note,
    }


def _allowed(check: Check) -> str:
    """Return the bounds of a check as text."""
    least, most = _figure(check, check.least), _figure(check, check.most)
    if check.least == check.most:
        return least
    if not isfinite(check.least):
        return f"≤ {most}" if check.most else "0"
    return f"≥ {least}" if not isfinite(check.most) else f"{least} to {most}"


def _figure(check: Check, value: float) -> str:
    """Return a figure of a check with its unit."""
    return _metres(1e-3 * value) if check.unit == "mm" else f"{value:.4g}"


def _words(name: str) -> str:
    return name.replace("_", " ")


def _metres(length: float) -> str:
    """Return a length [m] as text, in µm below 1 mm."""
    return f"{1e3 * length:.4g} mm" if abs(length) >= 1e-3 else f"{1e6 * length:.4g} µm"

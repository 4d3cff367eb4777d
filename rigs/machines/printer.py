"""Data of a 3D printer, each number with its source."""

from __future__ import annotations

from dataclasses import dataclass

from rigs.machines.machine import Datum  # noqa: TC001 (what reads the file asks for the types of the fields)


@dataclass(frozen=True, slots=True, kw_only=True)
class PrinterData:
    """Resolution of a printer.

    Attributes
    ----------
    printer : str
        Its name.
    layer_height : Datum
        Height of a layer [m].
    resolution : Datum
        Width of a dot within a layer [m].
    smallest_feature : Datum
        Least thickness that is printed whole [m].
    clearance : Datum
        Least gap that stays open [m].
    """

    printer: str
    layer_height: Datum
    resolution: Datum
    smallest_feature: Datum
    clearance: Datum

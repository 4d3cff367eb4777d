"""Columns of a dialect in other units."""

from __future__ import annotations

import re
from dataclasses import replace
from math import ceil, log10
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.logs.dialect import Column, Dialect

UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e3, "min": 1.0 / 60.0},
    "length": {"m": 1.0, "mm": 1e3, "um": 1e6, "nm": 1e9},
    "force": {"N": 1.0, "mN": 1e3, "uN": 1e6, "kN": 1e-3},
    "stress": {"Pa": 1.0, "kPa": 1e-3, "MPa": 1e-6},
    "strain": {"%": 1e2, "mm/mm": 1.0, "1": 1.0},
}
"""Factors from the SI unit of each quantity to units that columns may be shown in."""


def factor(unit: str) -> float:
    """Return how many of a unit are one SI unit; 1 for none."""
    return next((units[unit] for units in UNITS.values() if unit in units), 1.0)


def in_units(dialect: Dialect, wanted: Mapping[str, str]) -> Dialect:
    """Return a dialect with its columns in other units, no digit lost.

    Parameters
    ----------
    dialect : Dialect
        The dialect.
    wanted : mapping of str to str
        The unit of each quantity that is to change, ``{"force": "mN"}``.

    Raises
    ------
    SpecificationError
        If a quantity or a unit is unknown, or the dialect has no column in which the unit is said.
    """
    for quantity, unit in wanted.items():
        if quantity not in UNITS:
            raise SpecificationError("units", quantity, f"one of {', '.join(UNITS)}")
        if unit not in UNITS[quantity]:
            raise SpecificationError(f"units.{quantity}", unit, f"one of {', '.join(UNITS[quantity])}")
        columns = tuple(_shown_in(column, unit, UNITS[quantity]) for column in dialect.columns)
        if not any(_says(column, UNITS[quantity]) for column in dialect.columns):
            raise SpecificationError(f"units.{quantity}", unit, f"none: {dialect.name} says no unit of {quantity}")
        dialect = replace(dialect, columns=columns)
    return dialect


def _says(column: Column, units: Mapping[str, float]) -> bool:
    return column.unit in units and "{unit}" in f"{column.name}{column.below}"


def _shown_in(column: Column, unit: str, units: Mapping[str, float]) -> Column:
    digits = re.fullmatch(r"(,?)\.(\d+)f", column.form or "")
    if not _says(column, units) or digits is None:
        return column
    shift = ceil(log10(units[column.unit] / units[unit]) - 1e-9)
    return replace(column, unit=unit, form=f"{digits[1]}.{max(0, int(digits[2]) + shift)}f")

"""Tables of a calibration: its estimates, and the curves with their residuals."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING, Final

from rigs.analysis.table import Table, table_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.analysis.comparison import Across, Along
    from rigs.analysis.estimation import Estimate, Estimates
    from rigs.analysis.residuals import Residuals
    from rigs.analysis.table import Cell

UNITS: Final[Mapping[str, str]] = {"strain": "1", "travel": "m", "stress": "Pa", "force": "N"}


def estimate_table(found: Estimates) -> Table:
    """Return a row for each parameter: bounds, first value, estimate with its interval, correlations, what is amiss.

    Numbers are in the unit of the parameter; the estimate is ``nan`` where the data do not tell it, and `used` is what
    the best run had.
    """
    rows: list[dict[str, Cell]] = []
    for number, one in enumerate(found.each):
        what = one.parameter
        rows.append(
            {
                "parameter": what.name,
                "unit": what.unit or "1",
                "estimate": one.value,
                "low 95 %": one.low,
                "high 95 %": one.high,
                "used": one.used,
                "start": what.start,
                "lower bound": what.low,
                "upper bound": what.high,
                **{
                    f"correlation with {other.parameter.name}": float(found.correlation[number, k])
                    for k, other in enumerate(found.each)
                },
                "note": note_of(one),
            }
        )
    return Table(name="calibration", columns={name: [row[name] for row in rows] for name in rows[0]})


def note_of(one: Estimate) -> str:
    """Return what is amiss with an estimate; empty where nothing is."""
    if isnan(one.value):
        return "not identifiable"
    return f"at its {one.at_bound} bound" if one.at_bound else ""


def curve_table(parts: Mapping[tuple[str, str], list[Residuals]], across: Across, along: Along) -> Table:
    """Return measured and fitted curves with residuals in the range of the cycle; x of a hold is its time [s]."""
    rows: list[dict[str, Cell]] = [
        {
            "test": name,
            "axis": axis,
            "branch": one.name,
            f"{across}, or time of a hold": float(x),
            f"measured {along}": float(measured),
            f"fitted {along}": float(model),
            "residual": float(scaled),
        }
        for (name, axis), each in parts.items()
        for one in each
        for x, measured, model, scaled in zip(one.x, one.measured, one.model, one.scaled, strict=True)
    ]
    units = {
        f"{across}, or time of a hold": f"{UNITS[across]}, or s",
        f"measured {along}": UNITS[along],
        f"fitted {along}": UNITS[along],
        "residual": "1",
    }
    return table_of("fit", rows, units, "test", "axis", "branch")

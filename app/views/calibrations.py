"""The figure of a calibration: measured and fitted curves, and their residuals below."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.views.curves import force_unit, stress_unit
from app.views.labels import shortened
from app.views.plots import framed, write_figure

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from matplotlib.figure import Figure

    from rigs.analysis.comparison import Across, Along
    from rigs.analysis.residuals import Name, Residuals

MEASURED, FITTED = "#404040", "#D55E00"
STYLES: Final[Mapping[Name, str]] = {"loading": "-", "hold": ":", "unloading": "--"}
MOST_PANELS: Final = 6
"""Columns of panels; further tests are in the table."""


def calibration_plot(
    parts: Mapping[tuple[str, str], list[Residuals]], quantity: tuple[Across, Along], path: Path
) -> Path:
    """Write the figure of a calibration."""
    return write_figure(calibration_figure(parts, quantity), path)


def calibration_figure(parts: Mapping[tuple[str, str], list[Residuals]], quantity: tuple[Across, Along]) -> Figure:
    """Draw each measured test with the fit over it, and the residuals in percent of the range below.

    Parameters
    ----------
    parts : Mapping
        Residuals of each test by name and axis.
    quantity : (Across, Along)
        What is drawn over what.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    across, along = quantity
    shown = list(parts.items())[:MOST_PANELS]
    factor, unit = (stress_unit if along == "stress" else force_unit)(
        [one.measured for _, each in shown for one in each]
    )
    figure = Figure(figsize=(6.4 * len(shown), 6.4), layout="constrained")
    grid = figure.subplots(2, len(shown), squeeze=False, sharex="col", height_ratios=(2.2, 1.0))
    scale = 100.0 if across == "strain" else 1e3
    label = "effective strain [%]" if across == "strain" else "travel [mm]"
    for (upper, lower), ((name, axis), each) in zip(grid.T, shown, strict=True):
        # A hold is over time, so that only its residuals' size shows: in the table.
        drawn = [one for one in each if one.name != "hold"]
        for one in drawn:
            x = scale * one.x
            upper.plot(x, factor * one.measured, ".", color=MEASURED, ms=4, label=f"measured, {one.name}", alpha=0.6)
            upper.plot(x, factor * one.model, STYLES[one.name], color=FITTED, lw=1.6, label=f"fitted, {one.name}")
            lower.plot(x, 100.0 * one.scaled, STYLES[one.name], color=FITTED, lw=1.0, label=one.name)
        upper.set_title(f"{shortened(name)}{', ' * bool(axis)}{axis}", fontsize=11, loc="left")
        upper.set_ylabel(f"effective stress [{unit}]" if along == "stress" else f"force [{unit}]", fontsize=12)
        lower.set_ylabel("fitted - measured\n[% of the range]", fontsize=11)
        lower.set_xlabel(label, fontsize=12)
        lower.axhline(0.0, color=MEASURED, lw=0.8)
        if drawn:
            upper.legend(frameon=False, fontsize=10, loc="upper left")
    return framed(figure, list(grid.flat))

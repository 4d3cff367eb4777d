"""Curves of all points of a sweep in one figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.views.curve_styles import LINES, NAMES, ROLE_LABELS, STYLES
from app.views.curves import curves_of, stress_unit
from app.views.plots import draw_marks, draw_part, framed, quantity_of, stress_label, write_figure

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from app.records.reader import RunReader
    from app.schemas.sweep import Point
    from rigs.axes import Axis

MOST_LABELS: Final = 12
"""Points that the legend names."""


def curves_plot(records: Sequence[tuple[Point, RunReader]], path: Path) -> Path:
    """Write the figure of all points."""
    return write_figure(sweep_figure(records), path)


def sweep_figure(records: Sequence[tuple[Point, RunReader]]) -> Figure:
    """Plot stress over strain of all points that have rows, one panel an axis, dark to light."""
    from matplotlib import colormaps  # noqa: PLC0415 - imported when a plot is wanted
    from matplotlib.figure import Figure  # noqa: PLC0415

    drawn = [(point, run.size, curves_of(run)) for point, run in records if len(run.trace)]
    every = [curve for _, _, curves in drawn for curve in curves]
    axes = tuple(dict.fromkeys(curve.axis for curve in every))
    factor, unit = stress_unit([part.stress for curve in every for part in curve.parts])
    figure = Figure(figsize=(1.0 + 5.6 * max(len(axes), 1), 5.2), layout="constrained")
    panels = figure.subplots(1, max(len(axes), 1), squeeze=False)[0]
    named: dict[Axis, set[str]] = {axis: set() for axis in axes}
    for number, (point, _, curves) in enumerate(drawn):
        colour = colormaps["viridis"](0.9 * number / max(len(drawn) - 1, 1))
        for curve in curves:
            panel = panels[axes.index(curve.axis)]
            label: str | None = point.label if number < MOST_LABELS else None
            for part in curve.parts:
                draw_part(panel, part, factor, ls=STYLES[part.role], color=colour, lw=1.6, label=label)
                label = None
            draw_marks(panel, [curve], lambda mark: (100.0 * mark.strain, factor * mark.stress), named[curve.axis])
    for axis, panel in zip(axes, panels, strict=False):
        roles = [role for role in STYLES if any(role in curve.roles for curve in every if curve.axis == axis)]
        words = ", ".join(f"{ROLE_LABELS[role]} {LINES[STYLES[role]]}" for role in roles if len(roles) > 1)
        panel.set_title(f"{NAMES[axis]}{': ' * bool(words)}{words}", fontsize=11, loc="left")
        panel.set_xlabel(f"{quantity_of([axis], 'strain')} [%]", fontsize=12)
        panel.set_ylabel(stress_label(drawn[0][1], unit, [axis]), fontsize=12)
        panel.legend(frameon=False, fontsize=10, loc="upper left")
    return framed(figure, panels)

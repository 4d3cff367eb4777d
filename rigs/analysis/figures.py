"""Figures of measurements under the names that testers know from Instron's Bluehill."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, nan
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.analysis.branches import branch
from rigs.analysis.cycles import LEVELS, cycle_figures
from rigs.analysis.maxima import row_of_break, row_of_maximum
from rigs.analysis.moduli import secant_modulus
from rigs.analysis.regression import segment_modulus
from rigs.analysis.table import Table, table_of
from rigs.analysis.work import cycle_work, loading_work_ratios, summed_hysteresis
from rigs.axes import SHEARS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigs.analysis.choices import Choices, Window
    from rigs.analysis.cycles import CycleFigures
    from rigs.axes import IntArray
    from rigs.measurement import Measurement

WHOLE: Final = 0
"""Cycle under which figures of a whole test stand."""

ALL: Final = "all"
"""Axis under which figures of all axes together stand."""

RETURNED: Final = 0.05
"""Share of a cycle's range of strain within which a log with noise came back [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """One number: what it is of, its name, value and unit, and its confidence interval where it has one."""

    name: str
    axis: str
    cycle: int
    figure: str
    value: float
    unit: str
    low: float = nan
    high: float = nan


_SHEAR_WORDS: Final = (
    ("Tensile", "Shear"),
    ("tensile", "shear"),
    ("Modulus", "Shear modulus"),
    ("Extension", "Shear displacement"),
)
"""What a figure of a pull is called in a shear: its words, and those in their place."""


def figure_name(name: str, axis: str) -> str:
    """Return the name of a figure along an axis.

    Examples
    --------
    >>> figure_name("Modulus (secant to peak)", "C"), figure_name("Modulus (secant to peak)", "WC")
    ('Modulus (secant to peak)', 'Shear modulus (secant to peak)')
    """
    for pull, shear in _SHEAR_WORDS if axis in SHEARS else ():
        name = name.replace(pull, shear)
    return name


def results_table(whole: Sequence[Measurement], cycled: Sequence[Measurement], choices: Choices) -> Table:
    """Return the figures of a test as a tidy table, those without a value left out.

    Parameters
    ----------
    whole : sequence of Measurement
        The whole test, axis by axis.
    cycled : sequence of Measurement
        Its parts whose cycles count; the same where the test has no such parts.
    choices : Choices
        Windows and the drop at break.
    """
    found: list[Figure] = []
    for one in whole:
        found += _of_whole(one, choices.drop)
    for one in cycled:
        found += of_cycles(one, choices.windows)
    found += _over_axes(cycled)
    return figures_table("results", found)


def figures_table(name: str, figures: Iterable[Figure]) -> Table:
    """Return figures as a tidy table, those without a value left out."""
    names = tuple(Figure.__dataclass_fields__)
    named = [replace(one, figure=figure_name(one.figure, one.axis)) for one in figures if isfinite(one.value)]
    rows = [{field: getattr(one, field) for field in names} for one in named]
    return table_of(name, rows, {}, *names)


def _of_whole(test: Measurement, drop: float) -> Iterator[Figure]:
    """Yield the largest force and what holds there, and the same at break."""
    rows = {"maximum force": row_of_maximum(test.force), "break": row_of_break(test.travel, test.force, drop)}
    for where, row in rows.items():
        if row is None:
            continue
        first = "Maximum force" if where == "maximum force" else "Force at break"
        values = (
            (first, float(test.force[row]), "N"),
            (f"Time at {where}", float(test.time[row]), "s"),
            (f"Extension at {where}", float(test.travel[row]), "m"),
            (f"Tensile strain at {where}", float(test.strain[row]), "1"),
            (f"Tensile stress at {where}", float(test.stress[row]), "Pa"),
            (f"Energy at {where}", cycle_work(test.travel[: row + 1], test.force[: row + 1]), "J"),
        )
        for name, value, unit in values:
            yield Figure(name=test.name, axis=test.axis, cycle=WHOLE, figure=name, value=value, unit=unit)


def of_cycles(test: Measurement, windows: Iterable[Window]) -> Iterator[Figure]:
    """Yield the figures of every cycle of a measurement along one axis."""
    if not test.has_strain:
        return
    cycles = figures_by_cycle(test)
    ratios = loading_work_ratios([one.loading_work for one in cycles])
    for figures, ratio in zip(cycles, ratios.tolist(), strict=True):
        up = branch(test.phase, test.cycle, figures.cycle, ["Stretch"])
        values = [
            ("Maximum force", float(np.nanmax(test.force[up])), "N"),
            ("Tensile strain at maximum force", float(test.strain[up][np.nanargmax(test.force[up])]), "1"),
            ("Tensile stress at maximum force", float(np.nanmax(test.stress[up])), "Pa"),
            *((f"Tensile stress at tensile strain {at:.0%}", figures.stress[at], "Pa") for at in LEVELS),
            ("Modulus (secant to peak)", figures.peak_secant, "Pa"),
            ("Energy density of loading", figures.loading_work, "J/m3"),
            ("Hysteresis energy density", figures.loop_area, "J/m3"),
            ("Hysteresis ratio", figures.hysteresis, "1"),
            ("Energy of loading over that of the first cycle", ratio, "1"),
        ]
        for name, value, unit in values:
            yield Figure(name=test.name, axis=test.axis, cycle=figures.cycle, figure=name, value=value, unit=unit)
        yield from _moduli(test, up, figures.cycle, windows)


def figures_by_cycle(test: Measurement) -> tuple[CycleFigures, ...]:
    """Return the figures of the cycles; a log with noise need not come back to where it set out to the last digit."""
    within = RETURNED if test.sampled else 1e-3
    return cycle_figures(test.axis, test.strain, test.stress, test.phase, test.cycle, within)


def _moduli(test: Measurement, up: IntArray, cycle: int, windows: Iterable[Window]) -> Iterator[Figure]:
    """Yield the moduli of a loading branch over windows of strain: through both ends, and by regression."""
    strain, stress = test.strain[up], test.stress[up]
    start = float(strain[0])
    for first, last in windows:
        where = f"{100 * first:g} % - {100 * last:g} %"
        secant = secant_modulus(strain, stress, start + last, start + first)
        line = segment_modulus(strain, stress, start + first, start + last)
        values = (
            (f"Modulus (secant {where})", secant, nan, nan),
            (f"Modulus (segment {where})", line.slope, line.low, line.high),
        )
        for name, value, low, high in values:
            yield Figure(
                name=test.name, axis=test.axis, cycle=cycle, figure=name, value=value, unit="Pa", low=low, high=high
            )


def _over_axes(parts: Sequence[Measurement]) -> Iterator[Figure]:
    """Yield what all axes together lost in a cycle: loops and works of axes that are driven together add up."""
    by_name: dict[str, list[tuple[CycleFigures, ...]]] = {}
    for part in parts:
        if part.has_strain:
            by_name.setdefault(part.name, []).append(figures_by_cycle(part))
    for name, axes in by_name.items():
        if len(axes) < 2:
            continue
        for cycle in zip(*axes, strict=False):
            loops, works = [one.loop_area for one in cycle], [one.loading_work for one in cycle]
            number = cycle[0].cycle
            yield Figure(
                name=name,
                axis=ALL,
                cycle=number,
                figure="Hysteresis energy density",
                value=float(np.sum(loops)),
                unit="J/m3",
            )
            ratio = summed_hysteresis(loops, works)
            yield Figure(name=name, axis=ALL, cycle=number, figure="Hysteresis ratio", value=ratio, unit="1")

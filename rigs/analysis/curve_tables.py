"""Tables of measurements: their rows, fits, repeatability, holds and contraction."""

from __future__ import annotations

from itertools import combinations
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from rigs.analysis.branches import branch, holds
from rigs.analysis.fits import exponential_fit, exponential_or_kinked
from rigs.analysis.holding import creeps, hold_figures
from rigs.analysis.repeatability import curve_nrmse
from rigs.analysis.shapes import poisson_ratio
from rigs.analysis.table import Table, table_of
from rigs.measurement import COLUMNS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigs.analysis.choices import Choices, Window
    from rigs.analysis.table import Cell
    from rigs.axes import FloatArray
    from rigs.measurement import Measurement

TOE = 0.02
"""Share of the largest stress from which on a branch is fitted, unless a window is given."""

UNITS = {"time": "s", "travel": "m", "force": "N", "strain": "1", "stress": "Pa", "transverse": "1"}


def curves_table(tests: Sequence[Measurement]) -> Table:
    """Return every row of the measurements."""
    columns: dict[str, list[Cell]] = {name: [] for name in ("name", "axis", "cycle", "phase", *COLUMNS)}
    for test in tests:
        columns["name"] += [test.name] * len(test)
        columns["axis"] += [test.axis] * len(test)
        columns["cycle"] += test.cycle.tolist()
        columns["phase"] += test.phase
        for name in COLUMNS:
            columns[name] += getattr(test, name).tolist()
    return Table(name="curves", columns=columns, units=UNITS)


def loading_branches(test: Measurement) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """Yield cycle, strain [1] and stress [Pa] of every loading branch of a measurement, known rows alone."""
    for cycle in np.unique(test.cycle[np.asarray(test.phase, dtype=object) == "Stretch"]):
        rows = branch(test.phase, test.cycle, int(cycle), ["Stretch"])
        strain, stress = test.strain[rows], test.stress[rows]
        known = np.isfinite(strain) & np.isfinite(stress)
        if np.count_nonzero(known) > 1:
            yield int(cycle), strain[known], stress[known]


def fits_table(tests: Sequence[Measurement], choices: Choices) -> Table:
    """Return the exponential fit of every loading branch, and its test against a kinked line."""
    rows: list[Mapping[str, Cell]] = []
    for test in tests:
        for cycle, strain, stress in loading_branches(test):
            first, last = choices.fit or from_toe(strain, stress)
            fit, shape = (
                exponential_fit(strain, stress, first, last),
                exponential_or_kinked(strain, stress, first, last),
            )
            rows.append(
                {
                    "name": test.name,
                    "axis": test.axis,
                    "cycle": cycle,
                    "points": fit.points,
                    "first strain": first,
                    "last strain": last,
                    "rate": fit.rate,
                    "rate low": fit.rate_low,
                    "rate high": fit.rate_high,
                    "amplitude": fit.amplitude,
                    "r2 of ln stress": fit.r2,
                    "r2 exponential": shape.exponential_r2,
                    "r2 kinked": shape.kinked_r2,
                    "weight of exponential": shape.weight,
                    "kink strain": shape.kink,
                    "modulus below kink": shape.below,
                    "modulus above kink": shape.above,
                }
            )
    names = ("first strain", "last strain", "rate", "rate low", "rate high")
    more = ("r2 of ln stress", "r2 exponential", "r2 kinked", "weight of exponential", "kink strain")
    units = dict.fromkeys(names, "1") | {"amplitude": "Pa"} | dict.fromkeys(more, "1")
    units |= {"modulus below kink": "Pa", "modulus above kink": "Pa"}
    return table_of("fits", rows, units, "name", "axis", "cycle", "points")


def from_toe(strain: FloatArray, stress: FloatArray) -> Window:
    """Return the window from `TOE` of the largest stress to that."""
    top = int(np.argmax(stress))
    low = np.flatnonzero(stress[: top + 1] < TOE * stress[top])
    first = strain[low[-1] + 1] if len(low) else strain[0]
    return float(first), float(strain[top])


def repeatability_table(tests: Sequence[Measurement]) -> Table:
    """Return the NRMSE of every two loading branches of each axis, the first of them the reference."""
    rows: list[Mapping[str, Cell]] = []
    for test in tests:
        branches = [(cycle, (strain, stress)) for cycle, strain, stress in loading_branches(test)]
        rows += [
            {"name": test.name, "axis": test.axis, "cycle": a, "other cycle": b, "NRMSE": curve_nrmse(one, other)}
            for (a, one), (b, other) in combinations(branches, 2)
        ]
    return table_of("repeatability", rows, {"NRMSE": "1"}, "name", "axis", "cycle", "other cycle")


def holds_table(tests: Sequence[Measurement]) -> Table:
    """Return how stress relaxed, or strain crept, in every hold; SI units by the kind: Pa of stress, 1 of strain."""
    rows: list[Mapping[str, Cell]] = []
    for test in tests:
        for part in holds(test.phase):
            time, strain, stress = test.time[part], test.strain[part], test.stress[part]
            if len(time) < 3 or not np.isfinite(time).all() or not np.isfinite(stress).all() or time[-1] <= time[0]:
                continue
            crept = creeps(strain, stress)
            found = hold_figures(time, strain if crept else stress)
            rows.append(
                {
                    "name": test.name,
                    "axis": test.axis,
                    "cycle": int(test.cycle[part][-1]),
                    "kind": "creep" if crept else "relaxation",
                    "unit": "1" if crept else "Pa",
                    "start time": float(time[0]),
                    "duration": found.duration,
                    "start": found.start,
                    "end": found.end,
                    "change": found.change,
                    "per decade": found.per_decade,
                    "per decade low": found.per_decade_low,
                    "per decade high": found.per_decade_high,
                    "r2": found.r2,
                    "final rate": found.final_rate,
                    "half time": found.half_time,
                    "compliance at end": float(strain[-1] / stress[-1]) if crept and stress[-1] else nan,
                }
            )
    units = {"start time": "s", "duration": "s", "start": "unit", "end": "unit", "change": "1"}
    units |= {"per decade": "unit", "per decade low": "unit", "per decade high": "unit", "r2": "1"}
    units |= {"final rate": "unit/s", "half time": "s", "compliance at end": "1/Pa"}
    return table_of("holds", rows, units, "name", "axis", "cycle", "kind", "unit")


def poisson_table(tests: Sequence[Measurement]) -> Table:
    """Return the ratio of contraction to stretch, ν(ε), at every row whose transverse strain is known."""
    rows: list[Mapping[str, Cell]] = []
    for test in tests:
        ratio = poisson_ratio(test.strain, test.transverse)
        rows += [
            {
                "name": test.name,
                "axis": test.axis,
                "cycle": int(test.cycle[row]),
                "strain": float(test.strain[row]),
                "transverse strain": float(test.transverse[row]),
                "Poisson's ratio": float(ratio[row]),
            }
            for row in np.flatnonzero(np.isfinite(ratio))
        ]
    units = {"strain": "1", "transverse strain": "1", "Poisson's ratio": "1"}
    return table_of("poisson", rows, units, "name", "axis", "cycle")

"""Results of several runs in one table: a row a figure, a column a run."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Final

from app.records.analysis import analyse_run
from app.records.results import figures_of
from app.views.curves import prefixed
from app.views.report.assumed import PLAIN
from rigs.analysis.figures import ALL, WHOLE
from rigs.axes import AXES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.records.reader import RunReader

    Key = tuple[str, str, str, str]

_AXES: Final = (*AXES, ALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureRow:
    """A figure of every run: what it is of, its name, its values as texts (empty where a run has none), their unit."""

    axis: str
    cycle: str
    figure: str
    values: tuple[str, ...]
    unit: str


def result_rows(runs: Sequence[RunReader]) -> list[FigureRow]:
    """Return the figures of `knitlab analyse` of every run; those with fewer than two rows have none."""
    return _rows([_results(run) for run in runs])


def soundness_rows(runs: Sequence[RunReader]) -> list[FigureRow]:
    """Return cost, energy balance and the other figures of every run that are not of a cycle."""
    return _rows(
        [
            {("", "", name, unit): value for name, value, unit in figures_of(run) if ", cycle" not in name}
            for run in runs
        ]
    )


def _results(run: RunReader) -> dict[Key, float]:
    if len(run.trace) < 2:
        return {}
    found: dict[Key, float] = {}
    whole = str(run.provenance.get("name", run.path.parent.name))
    for name, axis, cycle, figure, value, unit, *_ in analyse_run(run).rows():
        # A step of several that cycle has its tag in its name.
        step = str(name).removeprefix(whole).removeprefix(", ")
        where = "whole test" if cycle == WHOLE else f"{step}{', ' * bool(step)}cycle {cycle}"
        found[str(axis), where, str(figure), str(unit)] = float(value)
    return found


def _rows(found: Sequence[Mapping[Key, float]]) -> list[FigureRow]:
    keys = dict.fromkeys(key for one in found for key in one)
    # Axis by axis and cycle by cycle, each in the order in which the runs name its figures.
    cycles = list(dict.fromkeys(cycle for _, cycle, *_ in keys))
    ordered = sorted(keys, key=lambda key: (_AXES.index(key[0]) if key[0] in _AXES else -1, cycles.index(key[1])))
    return [_row(key, [one.get(key, float("nan")) for one in found]) for key in ordered]


def _row(key: Key, values: Sequence[float]) -> FigureRow:
    axis, cycle, figure, unit = key
    largest = max((abs(value) for value in values if isfinite(value)), default=0.0)
    factor, letter = (1.0, "") if unit in PLAIN else prefixed(largest, least=0.1)
    texts = tuple(f"{factor * value:.4g}" if isfinite(value) else "" for value in values)
    return FigureRow(axis=axis, cycle=cycle, figure=figure, values=texts, unit="" if unit == "1" else f"{letter}{unit}")

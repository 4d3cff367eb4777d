"""Sweeps: every point run in a folder of its own, with one table and one plot of all."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.file_names import file_stem
from app.records.folder import RECORD, write_whole
from app.records.reader import RunReader
from app.records.results import figures_of
from app.runs.runner import quiet
from app.runs.use_cases import RUNS, has_ended, resume_run, run_protocol
from app.schemas import load_sweep, to_data
from app.schemas.document import dotted
from app.schemas.errors import shown
from app.views.curves import curves_of, stress_unit
from app.views.plots import LINES, NAMES, ROLE_LABELS, STYLES, draw_marks, draw_part, finish, quantity_of, stress_label
from app.views.sweep_plots import plot_figure
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from app.records.results import Figure
    from app.runs.publishing import Progress
    from app.schemas import Loaded
    from app.schemas.document import Place
    from app.schemas.sweep import Point, Scalar
    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.axes import Axis
    from rigs.record import End

MOST_JOBS: Final = 64

MOST_LABELS: Final = 12
"""Points that the legend of the plot names."""


_QUANTITY: Final = re.compile(r"[+-]?\.?\d[\d.]*(?:[eE][+-]?\d+)?\s*[A-Za-zµμ%°]*(?:\s*/\s*[A-Za-zµμ]+)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class PointResult:
    """How one point of a sweep ended.

    Attributes
    ----------
    point : Point
        Its values and label.
    folder : Path
        Its run folder.
    outcome : End
        How it ended.
    message : str
        One line for the user; empty when there is nothing to add.
    figures : tuple of (name, value, unit)
        What it came to.
    skipped : bool
        Whether it had been run before.
    crossings : tuple of LimitCrossing
        Where a fibre passed a limit of its material.
    losses : tuple of ClaspLoss
        Where clasps let go.
    """

    point: Point
    folder: Path
    outcome: End
    message: str
    figures: tuple[Figure, ...]
    skipped: bool
    crossings: tuple[LimitCrossing, ...] = ()
    losses: tuple[ClaspLoss, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepResult:
    """Results of a sweep: its points in order, and the table and plots of all."""

    points: tuple[PointResult, ...]
    table: Path
    plot: Path
    plots: tuple[Path, ...] = ()


def run_sweep(
    path: Path | str,
    out: Path | str | None = None,
    progress: Progress = quiet,
    *,
    jobs: int = 1,
    figures: Sequence[str] = (),
) -> SweepResult:
    """Run all points of a sweep that have not been run.

    Parameters
    ----------
    path : Path or str
        The protocol file.
    out : Path, str or None
        Folder of the sweep; each point gets one in it, named by its values. None for one under ``runs/``.
    progress : callable, optional
        Told the share done [1] and what is being done.
    jobs : int
        Processes that run at once.
    figures : sequence of str
        Words of the figures to plot over the parameter, or to map over two.

    Returns
    -------
    SweepResult
        Every point, those done before too; after an interrupt those that were begun.

    Raises
    ------
    SpecificationError
        For whatever is wrong with the protocol, or if a point's folder holds another test.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise SpecificationError("--jobs", jobs, f"a whole number from 1 to {MOST_JOBS}")
    path = Path(path)
    swept = load_sweep(path)
    out = RUNS / file_stem(path.stem) if out is None else Path(out)
    out.mkdir(parents=True, exist_ok=True)
    done = {point.label: is_done(out / point.label, loaded) for point, loaded in swept}
    todo = [point for point, _ in swept if not done[point.label]]
    count = len(swept) - len(todo)
    progress(count / len(swept), f"{count} of {len(swept)} points done before")
    for point, end in _run_all(path, out, todo, progress if jobs == 1 else quiet, jobs):
        if end == "abort":
            # An interrupt of a point ends the sweep.
            break
        count += 1
        progress(count / len(swept), f"{point.label} done")
    records = [
        (point, RunReader(out / point.label / RECORD)) for point, _ in swept if (out / point.label / RECORD).exists()
    ]
    points = tuple(_result(point, run, skipped=done[point.label]) for point, run in records)
    table = write_whole(out / "sweep.csv", [_table(points).encode()])
    plots = [plot_figure([(one.point.values, one.figures) for one in points], words, out) for words in figures]
    return SweepResult(points=points, table=table, plot=_plot(records, out / "sweep.png"), plots=tuple(plots))


def is_done(folder: Path, loaded: Loaded) -> bool:
    """Return whether a folder holds the finished run of a point.

    Protocols are compared by content, not by text or file name, so that a sweep can be given more values.

    Raises
    ------
    SpecificationError
        If it holds another test; it says in what the two differ.
    """
    record = folder / RECORD
    if not record.exists():
        return False
    run = RunReader(record)
    there = run.test
    here = loaded.protocol
    if not _names_itself(loaded):
        here = replace(here, name=there.name)
    if there != here:
        place, said, had = next(_differences(to_data(here), to_data(there)), ("protocol", "this sweep's", "another"))
        expected = f"one with {place}: {said} as in this sweep, not {had}; or an empty folder"
        raise SpecificationError(str(folder), "the run of another protocol", expected)
    return has_ended(run) is not None


def _names_itself(loaded: Loaded) -> bool:
    """Return whether a protocol gives itself a name, instead of its file's."""
    return isinstance(loaded.document.data, dict) and loaded.document.data.get("name") is not None


def _differences(one: object, other: object, place: Place = ()) -> Iterator[tuple[str, str, str]]:
    """Yield where the data of two protocols differ, with both values."""
    if isinstance(one, dict) and isinstance(other, dict):
        for name in dict.fromkeys([*one, *other]):
            yield from _differences(one.get(name), other.get(name), (*place, str(name)))
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for number, (left, right) in enumerate(zip(one, other, strict=True)):
            yield from _differences(left, right, (*place, number))
    elif one != other:
        said, had = (f"{len(side)} of them" if isinstance(side, list) else shown(side) for side in (one, other))
        yield dotted(place), said, had


def _run_all(
    path: Path, out: Path, todo: Sequence[Point], progress: Progress, jobs: int
) -> Iterator[tuple[Point, End]]:
    """Run points, and yield each with its end."""
    if jobs == 1:
        for point in todo:
            yield point, _run_one(path, out / point.label, point, progress)
        return
    with ProcessPoolExecutor(max_workers=jobs, mp_context=get_context("spawn")) as pool:
        running = {pool.submit(_run_one, path, out / point.label, point, quiet): point for point in todo}
        for one in as_completed(running):
            yield running[one], one.result()


def _run_one(path: Path, folder: Path, point: Point, progress: Progress) -> End:
    """Run one point in its folder, or resume it."""
    if (folder / RECORD).exists():
        return resume_run(folder, progress).outcome
    return run_protocol(path, folder, progress, exact=True, chosen=point.values).outcome


def _result(point: Point, run: RunReader, *, skipped: bool) -> PointResult:
    """Return the result of a point from its record."""
    end, message = run.outcome.end, run.outcome.message
    return PointResult(
        point=point,
        folder=run.path.parent,
        outcome=end,
        message=message,
        figures=figures_of(run),
        skipped=skipped,
        crossings=run.crossings,
        losses=run.losses,
    )


def _table(points: Sequence[PointResult]) -> str:
    """Return a table of all points as CSV: values, outcome, every figure of any."""
    names = list(dict.fromkeys(f"{name} [{unit}]" for point in points for name, _, unit in point.figures))
    text = io.StringIO()
    writer = csv.writer(text)
    values = list(points[0].point.values) if points else []
    writer.writerow(["point", *values, "outcome", "message", *names])
    for one in points:
        found = {f"{name} [{unit}]": value for name, value, unit in one.figures}
        figures = [found.get(name, "") for name in names]
        given = [safe_cell(value) for value in one.point.values.values()]
        writer.writerow([one.point.label, *given, one.outcome, safe_cell(one.message), *figures])
    return text.getvalue()


def safe_cell(value: Scalar) -> Scalar:
    """Return a value as a cell that no spreadsheet evaluates as a formula; a negative quantity is none."""
    if not isinstance(value, str) or _QUANTITY.fullmatch(value):
        return value
    return f"'{value}" if unicodedata.normalize("NFKC", value).lstrip().startswith(("=", "+", "-", "@")) else value


def _plot(records: Sequence[tuple[Point, RunReader]], path: Path) -> Path:
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
    return finish(figure, list(panels), path)

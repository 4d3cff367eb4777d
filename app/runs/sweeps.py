"""Sweeps: every point run in a folder of its own, with one table and one plot of all."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from itertools import count as count_from
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.file_names import file_stem
from app.records.folder import RECORD, write_whole
from app.records.reader import RunReader
from app.records.results import figures_of
from app.runs.runner import quiet
from app.runs.sweep_tables import PointResult, as_csv, sweep_table
from app.runs.use_cases import RUNS, has_ended, resume_run, run_protocol
from app.schemas import Loaded, load, load_sweep, to_data
from app.schemas.document import dotted
from app.schemas.errors import shown
from app.schemas.sweep import Point
from app.views.drawing import draw_here
from app.views.sweep_curves import curves_plot
from app.views.sweep_plots import plot_figure
from knitlab_core.errors import SpecificationError
from rigs.protocol.protocol import Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from app.runs.publishing import Progress
    from app.schemas import Source
    from app.schemas.document import Place
    from app.schemas.sweep import Scalar
    from app.views.drawing import Draw
    from rigs.record import End

MOST_JOBS: Final = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepResult:
    """Results of a sweep: its points in order, its folder, and the files of the table and plots of all."""

    points: tuple[PointResult, ...]
    folder: Path
    table_file: Path
    plot_file: Path
    plot_files: tuple[Path, ...] = ()


def run_sweep(
    source: Source | Sequence[Source],
    out: Path | str | None = None,
    progress: Progress = quiet,
    *,
    jobs: int = 1,
    figures: Sequence[str] = (),
    values: Mapping[str, Sequence[Scalar]] | None = None,
    draw: Draw | None = draw_here,
) -> SweepResult:
    """Run all points of a sweep that have not been run.

    Parameters
    ----------
    source : Path, str, Mapping, Protocol, Loaded, or a list of them
        The protocol, or a list of protocols that are the points.
    out : Path, str or None
        Folder of the sweep; each point gets one in it, named by its values. None for one under ``runs/``.
    progress : callable, optional
        Told the share done [1] and what is being done.
    jobs : int
        Processes that run at once.
    figures : sequence of str
        Words of the figures to plot over the parameter, or to map over two.
    values : Mapping, optional
        Values of parameters to sweep over, in the place of the protocol's `sweep`.
    draw : callable or None
        Begins to draw plot and knit of a point; None for no pictures.

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
    swept = _points_of(source, values)
    out = RUNS / _stem(source, swept) if out is None else Path(out)
    out.mkdir(parents=True, exist_ok=True)
    done = {point.label: is_done(out / point.label, loaded) for point, loaded in swept}
    todo = [(point, loaded) for point, loaded in swept if not done[point.label]]
    count = len(swept) - len(todo)
    progress(count / len(swept), f"{count} of {len(swept)} points done before")
    for point, end in _run_all(out, todo, progress, jobs, len(swept), draw):
        if end == "abort":
            # An interrupt of a point ends the sweep.
            break
        count += 1
        progress(count / len(swept), f"{point.label} done")
    records = [
        (point, RunReader(out / point.label / RECORD)) for point, _ in swept if (out / point.label / RECORD).exists()
    ]
    points = tuple(_result(point, run, skipped=done[point.label]) for point, run in records)
    pairs = [(one.point.values, one.figures) for one in points]
    return SweepResult(
        points=points,
        folder=out,
        table_file=write_whole(out / "sweep.csv", [as_csv(sweep_table(points)).encode()]),
        plot_file=curves_plot(records, out / "sweep.png"),
        plot_files=tuple(plot_figure(pairs, words, out) for words in figures),
    )


def _points_of(
    source: Source | Sequence[Source], values: Mapping[str, Sequence[Scalar]] | None
) -> list[tuple[Point, Loaded]]:
    """Return the points of a protocol with a sweep, or protocols of a list, named apart."""
    if isinstance(source, str | Path | Mapping | Protocol | Loaded):
        return load_sweep(source, values=values)
    if values or not source:
        raise SpecificationError("sweep", f"a list of {len(source)} protocols", "values for one, or a list alone")
    found: dict[str, Loaded] = {}
    for one in source:
        loaded = load(one).one_test()
        stem = file_stem(loaded.protocol.name)
        free = (stem if number == 1 else f"{stem}-{number}" for number in count_from(1))
        found[next(name for name in free if name not in found)] = loaded
    return [(Point(label=label, values={}), loaded) for label, loaded in found.items()]


def _stem(source: Source | Sequence[Source], swept: Sequence[tuple[Point, Loaded]]) -> str:
    """Return the name of the folder of a sweep: that of its file, or of a protocol that names itself."""
    if isinstance(source, Path) or (isinstance(source, str) and "\n" not in source):
        return file_stem(Path(source).stem)
    first = swept[0][1]
    return file_stem(first.protocol.name) if _names_itself(first) and swept[0][0].values else "sweep"


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
    out: Path,
    todo: Sequence[tuple[Point, Loaded]],
    progress: Progress,
    jobs: int,
    points: int,
    draw: Draw | None,
) -> Iterator[tuple[Point, End]]:
    """Run points, and yield each with its end; of one at a time the progress is a share of all `points`."""
    if jobs == 1:
        before = points - len(todo)
        for number, (point, loaded) in enumerate(todo):
            share = _part_of(progress, (before + number) / points, 1.0 / points, point.label)
            yield point, _run_one(out / point.label, loaded, share, draw)
        return
    with ProcessPoolExecutor(max_workers=jobs, mp_context=get_context("spawn")) as pool:
        running = {pool.submit(_run_one, out / point.label, loaded, quiet, draw): point for point, loaded in todo}
        for one in as_completed(running):
            yield running[one], one.result()


def _part_of(progress: Progress, start: float, share: float, label: str) -> Progress:
    """Return the progress of a part of the work, told as progress of all of it."""
    return lambda done, words: progress(start + share * done, f"{label}: {words}")


def _run_one(folder: Path, loaded: Loaded, progress: Progress, draw: Draw | None) -> End:
    """Run one point in its folder, or resume it."""
    if (folder / RECORD).exists():
        return resume_run(folder, progress, draw=draw).outcome
    return run_protocol(loaded, folder, progress, exact=True, draw=draw).outcome


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

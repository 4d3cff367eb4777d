"""Measured tests and runs on top of each other: one figure, one table of scores."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.records.analysis import is_run, read_file
from app.records.folder import RECORD
from app.records.measurements import cycled, whole_test, zeroings_of
from app.records.reader import read_run
from app.schemas.listings import listed
from app.views.curve_styles import NAMES
from app.views.curves import force_unit, stress_unit
from app.views.labels import shortened
from app.views.plots import framed, quantity_of, write_figure
from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment, aligned
from rigs.analysis.comparison import Group, by_axis, comparison_table, quantities, reference_of

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rigs.analysis.comparison import Across, Along
    from rigs.analysis.table import Table
    from rigs.measurement import Measurement
    from rigs.readers.mapping import FileMapping

#: Okabe and Ito's palette: told apart by colour-blind readers. What was measured is drawn in the first.
MEASURED, *OTHERS = ("#404040", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlay:
    """Tests laid over each other, and their scores.

    Attributes
    ----------
    scores : Table
        Scores of every test: NRMSE, secants, loops.
    groups : sequence of Group
        The tests as they were laid over each other.
    quantity : (Across, Along)
        What is compared over what.
    figure : Path or None
        The overlay, where a file was asked for.
    """

    scores: Table
    groups: Sequence[Group]
    quantity: tuple[Across, Along]
    figure: Path | None


def compare(
    sources: Sequence[Path | str],
    out: Path | str | None = None,
    *,
    mapping: Path | FileMapping | None = None,
    alignment: Alignment | None = None,
    axis: str | None = None,
    leave_out: Collection[int] = (),
    repeats: bool = False,
) -> Overlay:
    """Lay runs and measured files over each other; draw them and score them.

    Repeats in a file are drawn as a band about their mean. Others are scored against the first measured file, or
    without one the first run.

    Parameters
    ----------
    sources : sequence of Path or str
        Run folders, files of instruments, and YAML files that list them (`app.schemas.listings`).
    out : Path, str or None
        File of the figure; None for none.
    mapping : Path, FileMapping or None
        What the measured files do not say themselves.
    alignment : Alignment or None
        Which cycle, and how tests are put on each other; None for the first cycle as it is.
    axis : str or None
        Compare this axis alone; a file that names no axis is of this one. None for all.
    leave_out : collection of int
        Repeats of the files that are left out, counted from 1.
    repeats : bool
        Whether the measured files are repeats of one test, one after the other.

    Raises
    ------
    SpecificationError
        If nothing is left to compare, a test lacks the cycle, or the axes of files and runs do not fit.
    """
    how = Alignment() if alignment is None else alignment
    groups = groups_of(sources, mapping, how, axis, leave_out, repeats=repeats)
    quantity = quantities(groups)
    scores = comparison_table(groups, *quantity)
    figure = None if out is None else write_figure(overlay_figure(groups, scores, quantity), Path(out))
    return Overlay(scores=scores, groups=groups, quantity=quantity, figure=figure)


def groups_of(
    sources: Sequence[Path | str],
    mapping: Path | FileMapping | None,
    how: Alignment,
    axis: str | None,
    leave_out: Collection[int] = (),
    *,
    repeats: bool = False,
) -> list[Group]:
    """Return the tests of runs and measured files, aligned, axis by axis; the arguments are those of `compare`."""
    if not sources:
        raise SpecificationError("sources", 0, "a run or a measured file, or several")
    found: list[tuple[str, list[Group]]] = []
    measured: list[Path] = []
    for source in (one for each in sources for one in listed(Path(each))):
        if is_run(source):
            folder = source.parent if source.name == RECORD else source
            found.append((folder.name, run_groups(source, how)))
        elif repeats:
            measured.append(source)
        else:
            found.append(("", _of_files([source], mapping, how, leave_out)))
    if measured:
        found.append(("", _of_files(measured, mapping, how, leave_out)))
    return _named_apart(_on_axes(_by_folder(found), axis))


def _by_folder(found: Sequence[tuple[str, list[Group]]]) -> list[Group]:
    """Return the groups of all sources; runs of one name have that of their folder too, where it tells them apart."""
    places = Counter((group.name, folder) for folder, groups in found for group in groups[:1])
    owners = Counter(name for name, _ in places)
    return [
        replace(group, name=f"{group.name}, {folder}") if folder and owners[groups[0].name] > 1 else group
        for folder, groups in found
        for group in groups
    ]


def run_groups(path: Path, how: Alignment) -> list[Group]:
    """Return the axes of a run that its cycles drive, or all of them."""
    run = read_run(path)
    if len(run.trace) < 2:
        raise SpecificationError(str(path), f"{len(run.trace)} rows", "a run with two rows or more")
    name = str(run.provenance.get("name", path.name))
    zeroings = zeroings_of(run)
    parts = cycled(run.trace, run.size, zeroings, run.test) or whole_test(run.trace, run.size, zeroings)
    return [
        Group(
            name=f"{name}, {part.name}" if part.name else name,
            axis=part.axis,
            tests=[aligned(part, how)],
            measured=False,
        )
        for part in parts
        if np.ptp(part.strain) > 0.0
    ]


def _of_files(
    paths: Sequence[Path], mapping: Path | FileMapping | None, how: Alignment, leave_out: Collection[int]
) -> list[Group]:
    """Return the axes of files that belong together, each with its repeats."""
    tests = [test for path in paths for test in read_file(path, mapping)]
    name = paths[0].name if len(paths) == 1 else f"{paths[0].name} and {len(paths) - 1} more"
    groups = []
    for axis in dict.fromkeys(test.axis for test in tests):
        repeats: list[Measurement] = [test for test in tests if test.axis == axis]
        kept = [test for number, test in enumerate(repeats, start=1) if number not in leave_out]
        if not kept:
            raise SpecificationError("--leave-out", sorted(leave_out), f"fewer than the {len(repeats)} of {name}")
        groups.append(Group(name=name, axis=axis, tests=[aligned(test, how) for test in kept], measured=True))
    return groups


def _on_axes(groups: Sequence[Group], axis: str | None) -> list[Group]:
    """Return the groups of the axis that is asked for; a file that names none is of that, or of the only one."""
    named = {group.axis for group in groups if group.axis}
    only = axis or (next(iter(named)) if len(named) == 1 else "")
    if named and not only and any(not group.axis for group in groups):
        nameless = next(group.name for group in groups if not group.axis)
        raise SpecificationError("--axis", "none", f"that of {nameless}: one of {', '.join(sorted(named))}")
    found = [
        Group(name=group.name, axis=group.axis or only, tests=group.tests, measured=group.measured) for group in groups
    ]
    kept = [group for group in found if axis is None or group.axis == axis]
    if not kept:
        raise SpecificationError("--axis", axis, f"one of {', '.join(sorted(named)) or 'none'}")
    return kept


def _named_apart(groups: Sequence[Group]) -> list[Group]:
    """Return the groups; of those of one name along one axis the second and later ones have a number."""
    seen: Counter[tuple[str, str]] = Counter()
    found = []
    for group in groups:
        seen[group.name, group.axis] += 1
        count = seen[group.name, group.axis]
        found.append(group if count == 1 else replace(group, name=f"{group.name} ({count})"))
    return found


def overlay_figure(groups: Sequence[Group], scores: Table, quantity: tuple[Across, Along]) -> Figure:
    """Draw the tests of each axis into a panel: repeats as a band about their mean, one alone as a line.

    Parameters
    ----------
    groups : sequence of Group
        The tests.
    scores : Table
        Their `comparison_table`, whose NRMSE the legend shows.
    quantity : (Across, Along)
        What is drawn over what.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    across, along = quantity
    panels = by_axis(groups)
    figure = Figure(figsize=(7.4 * len(panels), 5.4), layout="constrained")
    row = figure.subplots(1, len(panels), squeeze=False)[0]
    values = [y for group in groups for _, y in group.curves(across, along)]
    factor, unit = stress_unit(values) if along == "stress" else force_unit(values)
    for axes, (axis, here) in zip(row, panels.items(), strict=True):
        reference = reference_of(groups, axis)
        inks = cycle(OTHERS)
        for group in sorted(here, key=lambda one: one is not reference):
            colour = MEASURED if group is reference and group.measured else next(inks)
            _draw_group(axes, group, quantity, factor, colour, _label(group, scores))
        strain, stress = (quantity_of([axis], quantity) for quantity in ("strain", "stress"))
        axes.set_xlabel(f"{strain} [%]" if across == "strain" else "travel [mm]", fontsize=12)
        axes.set_ylabel(f"{stress} [{unit}]" if along == "stress" else f"force [{unit}]", fontsize=12)
        axes.legend(frameon=False, fontsize=11, loc="upper left")
        if len(panels) > 1:
            axes.set_title(panel_name(axis), fontsize=12, loc="left")
    return framed(figure, list(row))


def panel_name(axis: str) -> str:
    """Return an axis in words."""
    return {str(one): name for one, name in NAMES.items()}.get(axis, axis)


def _label(group: Group, scores: Table) -> str:
    """Return the entry of a group in the legend: its name, how many repeats, and its NRMSE."""
    count = len(group.tests)
    words = [f"mean of {count} with their band"] if count > 1 else []
    for name, axis, _, figure, value, *_ in scores.rows():
        if (name, axis, figure) == (group.name, group.axis, "NRMSE"):
            words.append(f"NRMSE {100.0 * float(value):.2g} %")
    name = shortened(group.name)
    return f"{name}: {', '.join(words)}" if words else name


def _draw_group(
    axes: Axes, group: Group, quantity: tuple[Across, Along], factor: float, colour: str, label: str
) -> None:
    across, along = quantity
    scale = 100.0 if across == "strain" else 1e3
    if len(group.tests) > 1:
        band = group.band(across, along)
        axes.fill_between(scale * band.x, factor * band.low, factor * band.high, color=colour, alpha=0.25, lw=0)
        axes.plot(scale * band.x, factor * band.mean, color=colour, lw=1.8, label=label)
        for x, y in group.curves(across, along):
            axes.plot(scale * x, factor * y, color=colour, lw=0.5, alpha=0.5)
        return
    one = group.tests[0]
    axes.plot(
        scale * getattr(one.loading, across), factor * getattr(one.loading, along), color=colour, lw=1.8, label=label
    )
    back = one.test.chosen(slice(int(np.argmax(one.test.travel)), None))
    axes.plot(scale * getattr(back, across), factor * getattr(back, along), color=colour, lw=1.2, ls="--", alpha=0.7)

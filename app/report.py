"""Plot what the instrument logged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from app.lettering import boxes_allowed, write_plainly
from app.run_folder import whole_file
from knitlab_core.errors import SpecificationError
from rigs.analysis import branch, stress_strain
from rigs.jumps import parted

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from app.run_reader import RunReader
    from rigs.record import FloatArray, IntArray, Phase, SpecimenSize
    from rigs.steps import Axis

#: Okabe and Ito's palette: told apart by colour-blind readers.
COLOURS: dict[Axis, str] = {"C": "#0072B2", "W": "#D55E00", "P": "#009E73"}
NAMES: dict[Axis, str] = {"C": "course", "W": "wale", "P": "pile"}
#: Curves that lie on each other show through each other's dashes.
DASHES: dict[Axis, str | tuple[float, tuple[float, ...]]] = {"C": "-", "W": (0, (4, 3)), "P": (0, (2, 2))}
WAYS: tuple[tuple[Phase, str, str], ...] = (("Stretch", "-", "loading"), ("Recover", "--", "unloading"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """Hold what was logged of one axis, by its instrument, or by the equilibria of a run that was cut off.

    Attributes
    ----------
    axis : Axis
        The axis.
    time, strain, stress, force : FloatArray, shape (n,)
        [s], effective strain [1] and stress [Pa], and force [N].
    cycle : IntArray, shape (n,)
        Counter of the set.
    phase : sequence of Phase, length n
        What the axis was doing.
    offset : FloatArray, shape (k, n)
        What zeroing took off the channels.
    """

    axis: Axis
    time: FloatArray
    strain: FloatArray
    stress: FloatArray
    force: FloatArray
    cycle: IntArray
    phase: Sequence[Phase]
    offset: FloatArray

    def branches(self) -> Iterator[tuple[int, str, IntArray]]:
        """Yield cycle, line style and rows of every loading and unloading, parted where a channel was zeroed."""
        for cycle in np.unique(self.cycle):
            for phase, style, _ in WAYS:
                rows = branch(self.phase, self.cycle, int(cycle), [phase])
                zeroed = np.any(np.diff(self.offset[:, rows]) != 0.0, axis=0)
                for piece in np.split(rows, np.flatnonzero(zeroed) + 1):
                    if len(piece) > 1:
                        yield int(cycle), style, piece


def curves_of(run: RunReader) -> tuple[Curve, ...]:
    """Return the curve of every axis that was driven.

    Raises
    ------
    SpecificationError
        If the run has no row.
    """
    trace, size = parted(run.trace), run.size
    if not len(trace):
        raise SpecificationError("run.equilibria", 0, "at least one row to plot")
    curves = []
    for axis in trace.axes:
        logged = next((log for log in run.samples.values() if f"force_{axis}" in log.reads.values()), None)
        if logged is None:
            columns = trace.columns
            travel, force = columns[f"displacement_{axis}"], columns[f"force_{axis}"]
            time, cycle, phase = columns["time"], columns["cycle"].astype(np.int64), trace.phase
            offset = np.zeros((1, len(time)))
        else:
            channel = {column: name for name, column in logged.reads.items()}
            travel, force = (logged.measured[channel[f"{column}_{axis}"]] for column in ("crosshead", "force"))
            time, cycle, phase = logged.true_time, logged.cycle, logged.phase
            offset = np.stack(list(logged.offset.values()))
        strain, stress = stress_strain(travel, force, axis, size)
        curves.append(
            Curve(
                axis=axis,
                time=time,
                strain=strain,
                stress=stress,
                force=force,
                cycle=cycle,
                phase=phase,
                offset=offset,
            )
        )
    return tuple(curves)


def stress_strain_plot(run: RunReader, path: Path) -> Path:
    """Plot stress over strain and force over time; axes, cycles and ways are told apart.

    Parameters
    ----------
    run : RunReader
        The run; one that was cut off is plotted as far as it went.
    path : Path
        Where the PNG shall stand.

    Returns
    -------
    Path
        The same path.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    curves = curves_of(run)
    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    main, beside = figure.subplots(1, 2, width_ratios=[2, 1])
    force_time, strain_time = _split(beside)
    _plot_loops(main, curves)
    main.set_ylabel(stress_label(run.size), fontsize=12)
    for curve in curves:
        colour = COLOURS[curve.axis]
        force_time.plot(curve.time, curve.force, color=colour, lw=1.2)
        strain_time.plot(curve.time, 100 * curve.strain, color=colour, lw=1.2, ls=DASHES[curve.axis])
    force_time.set(ylabel="force [N]", title="as logged over time")
    strain_time.set(xlabel="time [s]", ylabel="strain [%]")
    force_time.tick_params(labelbottom=False)
    name = run.provenance.get("name")
    heading = f"{name}: effective stress and strain" if name else "Effective stress and strain"
    write_plainly([main.set_title(heading, fontsize=13, loc="left")])
    return finish(figure, (main, force_time, strain_time), path)


def finish(figure: Figure, parts: Sequence[Axes], path: Path) -> Path:
    """Give the parts of a figure the frame and the grid that all plots have, and write it."""
    for axes in parts:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#e6e6e6", lw=0.6)
        axes.set_axisbelow(True)
        legend = axes.get_legend()
        write_plainly([] if legend is None else legend.get_texts())
    with whole_file(path) as temporary, boxes_allowed():
        figure.savefig(temporary, dpi=200, facecolor="white")
    return path


def _split(axes: Axes) -> tuple[Axes, Axes]:
    grid = axes.get_subplotspec()
    figure = axes.figure
    if grid is None:
        raise SpecificationError("axes", axes, "axes of a grid")
    axes.remove()
    parts = grid.subgridspec(2, 1)
    upper = figure.add_subplot(parts[0])
    return upper, figure.add_subplot(parts[1], sharex=upper)


def stress_label(size: SpecimenSize) -> str:
    """Return what stands beside the axis of stress: which thickness it is over."""
    agreed = f"thickness {1e3 * size.extents['P']:g} mm" if size.convention == "unit" else "initial cross-section"
    return f"effective stress [kPa]  ({agreed})"


def _plot_loops(axes: Axes, curves: Sequence[Curve]) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415

    cycles = sorted({int(cycle) for curve in curves for cycle in curve.cycle})
    for curve in curves:
        for cycle, style, rows in curve.branches():
            width, share = _cycle_look(cycles.index(cycle))
            ink = _tint(COLOURS[curve.axis], share)
            axes.plot(100 * curve.strain[rows], 1e-3 * curve.stress[rows], style, color=ink, lw=width)
    axes.set_xlabel("effective strain [%]", fontsize=12)
    handles = [Line2D([], [], color=COLOURS[curve.axis], lw=2.5, label=NAMES[curve.axis]) for curve in curves]
    for index, cycle in enumerate(cycles[:4]):
        width, share = _cycle_look(index)
        more = " and on" if index == 3 and len(cycles) > 4 else ""
        handles.append(Line2D([], [], color=_tint("black", share), lw=width, label=f"cycle {cycle}{more}"))
    handles += [Line2D([], [], color="black", ls=style, lw=1.5, label=way) for _, style, way in WAYS]
    axes.legend(handles=handles, frameon=False, fontsize=11, loc="upper left")


def _cycle_look(index: int) -> tuple[float, float]:
    """Return line width and share of the full colour: later cycles lie thin and light upon the first."""
    return (3.2, 1.0) if index == 0 else (1.1, max(0.45 - 0.1 * (index - 1), 0.2))


def _tint(colour: str, share: float) -> tuple[float, float, float]:
    """Return a colour thinned with white; `share` of it is left [1]."""
    from matplotlib.colors import to_rgb  # noqa: PLC0415

    red, green, blue = (1.0 - share * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue

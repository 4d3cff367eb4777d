"""Plot what the instrument logged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.run_folder import whole_file
from knitlab_core.errors import SpecificationError
from rigs.analysis import branch, stress_strain

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from matplotlib.axes import Axes

    from app.run_reader import RunReader
    from rigs.protocol import Axis
    from rigs.record import FloatArray, IntArray, Phase

#: Okabe and Ito's palette: told apart by colour-blind readers.
COLOURS: dict[Axis, str] = {"C": "#0072B2", "W": "#D55E00"}
NAMES: dict[Axis, str] = {"C": "course", "W": "wale"}
LETTERS: dict[Axis, str] = {"C": "X", "W": "Y"}
WAYS: tuple[tuple[Phase, str, str], ...] = (("Stretch", "-", "loading"), ("Recover", "--", "unloading"))


class Curves:
    """Hold a run's log as the plots want it: by the instrument, or by the equilibria of a run cut off.

    Parameters
    ----------
    run : RunReader
        The run.

    Raises
    ------
    SpecificationError
        If the run has no row.
    """

    def __init__(self, run: RunReader) -> None:
        self.size = run.size
        self.time: FloatArray
        self.cycle: IntArray
        if run.samples is not None:
            self.time, self.cycle, self.phase = run.samples.time, run.samples.cycle, run.samples.phase
            measured = run.samples.measured
            self.travel = {axis: measured[f"{letter}Displacement"] for axis, letter in LETTERS.items()}
            self.force = {axis: measured[f"{letter}Force"] for axis, letter in LETTERS.items()}
            self._offset = np.stack(list(run.samples.offset.values()))
            return
        columns = run.trace.columns
        if not len(run.trace):
            raise SpecificationError("run.equilibria", 0, "at least one row to plot")
        self.time, self.cycle = columns["time"], columns["cycle"].astype(np.int64)
        self.phase = run.trace.phase
        self.travel = {axis: columns[f"displacement_{axis}"] for axis in LETTERS}
        self.force = {axis: columns[f"force_{axis}"] for axis in LETTERS}
        self._offset = np.zeros((1, len(self.time)))

    def stress_strain(self, axis: Axis) -> tuple[FloatArray, FloatArray]:
        """Return effective strain [1] and stress [Pa] of an axis."""
        return stress_strain(self.travel[axis], self.force[axis], axis, self.size)

    def branches(self) -> Iterator[tuple[int, str, IntArray]]:
        """Yield cycle, line style and rows of every loading and unloading, parted where a channel was zeroed."""
        for cycle in np.unique(self.cycle):
            for phase, style, _ in WAYS:
                rows = branch(self.phase, self.cycle, int(cycle), [phase])
                zeroed = np.any(np.diff(self._offset[:, rows]) != 0.0, axis=0)
                for piece in np.split(rows, np.flatnonzero(zeroed) + 1):
                    if len(piece) > 1:
                        yield int(cycle), style, piece


def stress_strain_plot(run: RunReader, path: Path) -> Path:
    """Plot stress over strain and force over time, course and wale, cycles and ways told apart.

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

    curves = Curves(run)
    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    main, beside = figure.subplots(1, 2, width_ratios=[2, 1])
    force_time, strain_time = _split(beside)
    _plot_loops(main, curves)
    for axis, colour in COLOURS.items():
        strain, _ = curves.stress_strain(axis)
        force_time.plot(curves.time, curves.force[axis], color=colour, lw=1.2)
        strain_time.plot(curves.time, 100 * strain, color=colour, lw=1.2, ls="-" if axis == "C" else (0, (4, 3)))
    force_time.set(ylabel="force [N]", title="as logged over time")
    strain_time.set(xlabel="time [s]", ylabel="strain [%]")
    force_time.tick_params(labelbottom=False)
    name = run.provenance.get("name")
    heading = f"{name}: effective stress and strain" if name else "Effective stress and strain"
    main.set_title(heading, fontsize=13, loc="left")
    for axes in (main, force_time, strain_time):
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#e6e6e6", lw=0.6)
        axes.set_axisbelow(True)
    with whole_file(path) as temporary:
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


def _plot_loops(axes: Axes, curves: Curves) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415

    cycles = [int(cycle) for cycle in np.unique(curves.cycle)]
    for axis, colour in COLOURS.items():
        strain, stress = curves.stress_strain(axis)
        for cycle, style, rows in curves.branches():
            width, share = _cycle_look(cycles.index(cycle))
            axes.plot(100 * strain[rows], 1e-3 * stress[rows], style, color=_tint(colour, share), lw=width)
    axes.set_xlabel("effective strain [%]", fontsize=12)
    axes.set_ylabel("effective stress [kPa]  (thickness 1 mm)", fontsize=12)
    handles = [Line2D([], [], color=colour, lw=2.5, label=NAMES[axis]) for axis, colour in COLOURS.items()]
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

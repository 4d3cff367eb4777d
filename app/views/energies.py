"""Plot of the energies of a run over time: the work of the carriages, and where it went."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.records.results import energy_balance_error
from app.views.curves import prefixed
from app.views.plots import finish
from rigs.analysis.run_tables import LOST, STORED

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from app.records.reader import RunReader

WORDS: Final[Mapping[str, str]] = {
    "friction_work": "lost by friction",
    "viscous_work": "lost by relaxation",
    "plastic_work": "lost by yielding",
    "fracture_work": "lost by breaks",
    "snap_work": "lost by snaps",
    "bond_released": "released by fused points",
}
_INKS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#999999")


def energy_plot(run: RunReader, path: Path) -> Path:
    """Draw the external work over time, the stored energy and every loss that is not zero; the balance is the title.

    Parameters
    ----------
    run : RunReader
        A run with two rows or more.
    path : Path
        File of the figure; its suffix chooses the format.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    columns = run.trace.columns
    time, work = columns["time"], columns["external_work"]
    stored = np.sum([columns[name] for name in STORED if name in columns], axis=0)
    lost = {WORDS[name]: columns[name] - columns[name][0] for name in LOST if name in columns}
    drawn = {"stored in the knit": stored} | {name: values for name, values in lost.items() if values.any()}
    factor, letter = prefixed(max(float(np.abs(values).max()) for values in (work, *drawn.values())), least=0.1)
    figure = Figure(figsize=(7.4, 3.8), layout="constrained")
    axes = figure.subplots()
    axes.plot(time, factor * (work - work[0]), color="black", lw=2.4, label="work of the carriages")
    for (name, values), ink in zip(drawn.items(), _INKS, strict=False):
        axes.plot(time, factor * values, color=ink, lw=1.5, label=name)
    axes.set(xlabel="time [s]", ylabel=f"energy [{letter}J]")
    axes.legend(frameon=False, fontsize=10)
    error = energy_balance_error(run.trace)
    if np.isfinite(error):
        axes.set_title(f"open balance: at most {100.0 * error:.2g} % of the largest work", fontsize=11, loc="left")
    return finish(figure, [axes], path)

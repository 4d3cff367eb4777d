"""Loading curves of several runs in one figure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from app.records.reader import read_run
from app.views.curve_styles import COLOURS, NAMES
from app.views.curves import curves_of, stress_unit
from app.views.plots import draw_marks, draw_part, finish, quantity_of, stress_label
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from app.records.reader import RunReader
    from app.views.curves import Curve, Mark
    from rigs.axes import Axis

#: Runs on the same axis are told apart by their dashes, in this order.
DASHES = ("-", "--", "-.", ":")

#: Where one axis alone is drawn its runs are told apart by these, of Okabe and Ito's palette.
INKS = ("#009E73", "#0072B2", "#D55E00", "#CC79A7", "#000000")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Compared:
    """One axis of one run: its legend label, colour and dashes, and the modulus [Pa] to divide by."""

    label: str
    colour: str
    dashes: str
    curve: Curve
    modulus: float | None


def compare_runs(paths: Sequence[Path], out: Path, *, by_modulus: bool = False, axis: Axis | None = None) -> Path:
    """Plot stress over strain of several runs.

    Parameters
    ----------
    paths : sequence of Path
        Run folders, or their ``run.h5``.
    out : Path
        Path of the figure to write; its suffix chooses the format.
    by_modulus : bool
        Divide the stress by Young's modulus of the run's yarn.
    axis : Axis or None
        Draw this axis alone; None for every one that was driven.

    Returns
    -------
    Path
        The figure.

    Raises
    ------
    SpecificationError
        If there is no run, or a run has no row, or none drove the axis.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    runs = [read_run(path) for path in paths]
    if not runs:
        raise SpecificationError("runs", 0, "at least one run to plot")
    lines = compared(runs, by_modulus=by_modulus, axis=axis)
    if not lines:
        raise SpecificationError("axis", axis or "none", "an axis that a run drove")
    figure = Figure(figsize=(7.4, 5.4), layout="constrained")
    axes = figure.subplots()
    factor, unit = stress_unit([part.stress for one in lines for part in one.curve.parts])
    named: set[str] = set()
    for one in lines:
        label: str | None = one.label
        scale = factor if one.modulus is None else 1.0 / one.modulus
        for part in one.curve.parts:
            light = 1.0 if part.cycle == one.curve.parts[0].cycle and part.role != "unloading" else 0.45
            draw_part(axes, part, scale, ls=one.dashes, color=one.colour, alpha=light, lw=1.8, label=label)
            label = None
        draw_marks(axes, [one.curve], partial(_place, scale), named)
    shown = [one.curve.axis for one in lines]
    thickness = {stress_label(run.size, unit, shown) for run in runs}
    words = thickness.pop() if len(thickness) == 1 else f"{quantity_of(shown, 'stress')} [{unit}]"
    axes.set_xlabel(f"{quantity_of(shown, 'strain')} [%]", fontsize=12)
    axes.set_ylabel(
        words.replace(f"stress [{unit}]", "stress / Young's modulus [1]") if by_modulus else words, fontsize=12
    )
    axes.legend(frameon=False, fontsize=11, loc="upper left")
    return finish(figure, [axes], out)


def _place(scale: float, mark: Mark) -> tuple[float, float]:
    """Return the position of a mark: strain [%], and stress times a factor."""
    return 100.0 * mark.strain, scale * mark.stress


def _modulus(run: RunReader, name: str) -> float:
    """Return Young's modulus of the yarn of a run [Pa].

    Raises
    ------
    SpecificationError
        For a yarn by measurement, which has none.
    """
    known = run.provenance.get("material.young_modulus")
    if known is None:
        found = f"{name}, whose yarn is one by measurement and has no Young's modulus"
        raise SpecificationError("--by-modulus", found, "runs of solid yarn, or the stress itself")
    return float(str(known))


def compared(runs: Sequence[RunReader], *, by_modulus: bool, axis: Axis | None = None) -> list[Compared]:
    """Return what is drawn; runs on the same axis differ by dashes, or by colour in a panel of their own."""
    lines: list[Compared] = []
    for run in runs:
        name = str(run.provenance.get("name", run.path.parent.name))
        modulus = _modulus(run, name) if by_modulus else None
        for curve in curves_of(run):
            if axis not in {None, curve.axis}:
                continue
            colour = COLOURS[curve.axis] if axis is None else INKS[len(lines) % len(INKS)]
            same = sum(line.colour == colour for line in lines)
            lines.append(
                Compared(
                    label=f"{NAMES[curve.axis]}, {name}",
                    colour=colour,
                    dashes=DASHES[same % len(DASHES)],
                    curve=curve,
                    modulus=modulus,
                )
            )
    return lines

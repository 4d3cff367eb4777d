"""Plots of a run: stress over strain and force over time, with the noisy log behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.views.curve_styles import (
    BEYOND,
    COLOURS,
    DASHES,
    MARKS,
    MOST_CYCLES,
    NAMES,
    PINNED,
    ROLE_LABELS,
    STYLES,
    TITLE,
)
from app.views.curves import curves_of, force_unit, stress_unit
from app.views.lettering import boxes_allowed, write_plainly
from app.views.pin_curves import pin_curves
from knitlab_core.errors import SpecificationError
from rigs.axes import SHEARS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from app.records.reader import RunReader
    from app.views.curves import Curve, Mark, Part, Role
    from app.views.pin_curves import PinCurve
    from rigs.axes import Axis
    from rigs.record import SpecimenSize


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """Entry of a legend: its text, and how its line or mark looks."""

    label: str
    colour: str | tuple[float, float, float]
    style: str | tuple[float, tuple[float, ...]] = "-"
    width: float = 1.5
    mark: str = ""


def stress_strain_plot(run: RunReader, path: Path) -> Path:
    """Plot stress over strain, and force and strain over time, with axes, cycles and roles distinguished.

    Parameters
    ----------
    run : RunReader
        The run; one that was cut off is plotted as far as it went.
    path : Path
        Path of the PNG to write.

    Returns
    -------
    Path
        The same path.
    """
    return write_figure(stress_strain_figure(run), path)


def stress_strain_figure(run: RunReader) -> Figure:
    """Return the figure that `stress_strain_plot` writes."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    curves = curves_of(run)
    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    main, beside = figure.subplots(1, 2, width_ratios=[2, 1])
    force_time, strain_time = _split(beside)
    pins = pin_curves(run)
    _plot_loops(main, curves, run.size, pins)
    _plot_times(force_time, strain_time, curves)
    for pair in pins:
        strain_time.plot(pair.time, 100 * pair.strain, color=COLOURS[pair.axis], lw=1.4, ls=PINNED)
    name = run.provenance.get("name")
    heading = f"{name}: effective stress and strain" if name else "Effective stress and strain"
    write_plainly([main.set_title(heading, fontsize=13, loc="left", y=TITLE)])
    frame_panels((main, force_time, strain_time))
    return figure


def finish(figure: Figure, parts: Sequence[Axes], path: Path) -> Path:
    """Give the panels of a figure the common frame and grid, and write the file."""
    return write_figure(framed(figure, parts), path)


def write_figure(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of the file's suffix."""
    from app.views.plotting import save  # noqa: PLC0415 (matplotlib: only where a plot is wanted)

    with boxes_allowed():
        return save(figure, path)


def framed(figure: Figure, parts: Sequence[Axes]) -> Figure:
    """Return a figure whose panels have the common frame and grid."""
    frame_panels(parts)
    return figure


def frame_panels(parts: Sequence[Axes]) -> None:
    """Give panels the common frame and grid."""
    for axes in parts:
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#e6e6e6", lw=0.6)
        axes.set_axisbelow(True)
        legend = axes.get_legend()
        write_plainly([] if legend is None else legend.get_texts())


def _split(axes: Axes) -> tuple[Axes, Axes]:
    grid = axes.get_subplotspec()
    figure = axes.figure
    if grid is None:
        raise SpecificationError("axes", axes, "axes of a grid")
    axes.remove()
    parts = grid.subgridspec(2, 1)
    upper = figure.add_subplot(parts[0])
    return upper, figure.add_subplot(parts[1], sharex=upper)


def quantity_of(axes: Iterable[str], quantity: str) -> str:
    """Return what a strain or a stress of some axes is called.

    Examples
    --------
    >>> quantity_of(["C"], "strain"), quantity_of(["WC"], "strain"), quantity_of(["C", "WC"], "stress")
    ('effective strain', 'shear strain', 'effective or shear stress')
    """
    kinds = {"shear" if axis in SHEARS else "effective" for axis in axes} or {"effective"}
    return f"{' or '.join(sorted(kinds))} {quantity}"


def stress_label(size: SpecimenSize, unit: str = "kPa", axes: Iterable[Axis] = ()) -> str:
    """Return the label of the stress axis, with the thickness that stress refers to."""
    agreed = f"thickness {1e3 * size.extents['P']:g} mm" if size.convention == "unit" else "initial cross-section"
    return f"{quantity_of(axes, 'stress')} [{unit}]  ({agreed})"


def draw_part(axes: Axes, part: Part, factor: float, **look: object) -> None:
    """Draw stress, times a factor, over strain of a part; a part of one point is drawn as a dot."""
    strain, stress = 100.0 * part.strain, factor * part.stress
    if part.still:
        strain, stress = strain[-1:], stress[-1:]
        look |= {"ls": "none", "marker": "o", "ms": 7.0, "mfc": "white", "mew": 1.5, "lw": 1.5, "zorder": 4}
    axes.plot(strain, stress, **look)  # type: ignore[arg-type]


def draw_marks(
    axes: Axes, curves: Sequence[Curve], place: Callable[[Mark], tuple[float, float]], named: set[str] | None = None
) -> None:
    """Mark where limits of the material were passed; each limit is `named` once for the legend."""
    for curve in curves:
        for number, mark in enumerate(curve.marks):
            look = {"ls": "none", "ms": 9, "mfc": BEYOND, "mec": "white", "mew": 0.8, "zorder": 6}
            text = f"{mark.crossing.limit.text} passed"
            if named is not None and text not in named:
                look["label"] = text
                named.add(text)
            axes.plot(*place(mark), marker=MARKS[number % len(MARKS)], **look)  # type: ignore[arg-type]


def legend_of(curves: Sequence[Curve]) -> list[Entry]:
    """Return the entries of a legend, for what is on the plot alone."""
    entries = [Entry(label=_axis_label(curve), colour=COLOURS[curve.axis], width=2.5) for curve in curves]
    cycles = sorted({cycle for curve in curves for cycle in curve.cycles})
    for index, cycle in enumerate(cycles[:MOST_CYCLES] if len(cycles) > 1 else ()):
        width, share = _cycle_look(index)
        more = " and on" if index == MOST_CYCLES - 1 and len(cycles) > MOST_CYCLES else ""
        entries.append(Entry(label=f"cycle {cycle}{more}", colour=_tint("black", share), width=width))
    roles = [role for role in STYLES if any(role in curve.roles for curve in curves)]
    if roles != ["loading"]:
        entries += [_role_entry(role, curves) for role in roles]
    if any(curve.log is not None for curve in curves):
        entries.append(Entry(label="as logged, with noise", colour="#888888", width=0.8))
    limits = {mark.crossing.limit.text: number for curve in curves for number, mark in enumerate(curve.marks)}
    for text, number in limits.items():
        entries.append(Entry(label=f"{text} passed", colour=BEYOND, style="none", mark=MARKS[number % len(MARKS)]))
    return entries


def _role_entry(role: Role, curves: Sequence[Curve]) -> Entry:
    """Return the legend entry of a role: a line, or the dot of a part that is one point."""
    if all(part.still for curve in curves for part in curve.parts if part.role == role):
        return Entry(label=ROLE_LABELS[role], colour="black", style="none", mark="o")
    return Entry(label=ROLE_LABELS[role], colour="black", style=STYLES[role])


def _axis_label(curve: Curve) -> str:
    """Return the name of an axis, and that it was not driven if it never was."""
    if {"loading", "unloading"} & set(curve.roles):
        return NAMES[curve.axis]
    beside = [role for role in ("held", "free") if role in curve.roles]
    return ", ".join([NAMES[curve.axis], *beside])


def show_legend(axes: Axes, entries: Sequence[Entry]) -> None:
    """Draw a legend."""
    from matplotlib.lines import Line2D  # noqa: PLC0415

    handles = [
        Line2D(
            [],
            [],
            color=one.colour,
            ls=one.style,
            lw=one.width,
            marker=one.mark,
            mfc="white" if one.mark == "o" else one.colour,
            mec=one.colour if one.mark == "o" else "white",
            ms=7 if one.mark == "o" else 9,
            label=one.label,
        )
        for one in entries
    ]
    axes.legend(handles=handles, frameon=False, fontsize=10, loc="best")


def _pin_entries(pins: Sequence[PinCurve]) -> list[Entry]:
    """Return the entries of a legend for strains that an extensometer reads."""
    return [
        Entry(label=f"{NAMES[pair.axis]}, strain between pins", colour=COLOURS[pair.axis], style=PINNED)
        for pair in pins
    ]


def _plot_loops(axes: Axes, curves: Sequence[Curve], size: SpecimenSize, pins: Sequence[PinCurve]) -> None:
    cycles = sorted({part.cycle for curve in curves for part in curve.parts})
    factor, unit = stress_unit([part.stress for curve in curves for part in curve.parts])
    for curve in curves:
        colour = COLOURS[curve.axis]
        if curve.log is not None:
            log = curve.log
            axes.plot(100 * log.strain, factor * log.stress, color=colour, lw=0.7, alpha=0.45, zorder=1)
        for part in curve.parts:
            width, share = _cycle_look(cycles.index(part.cycle))
            draw_part(axes, part, factor, ls=STYLES[part.role], color=_tint(colour, share), lw=width)
    for pair in pins:
        if pair.stress is not None:
            axes.plot(100 * pair.strain, factor * pair.stress, color=COLOURS[pair.axis], lw=1.4, ls=PINNED)
    draw_marks(axes, curves, lambda mark: (100 * mark.strain, factor * mark.stress))
    shown = [curve.axis for curve in curves]
    axes.set_xlabel(f"{quantity_of(shown, 'strain')} [%]", fontsize=12)
    axes.set_ylabel(stress_label(size, unit, shown), fontsize=12)
    show_legend(axes, [*legend_of(curves), *_pin_entries(pins)])


def _plot_times(force_time: Axes, strain_time: Axes, curves: Sequence[Curve]) -> None:
    factor, unit = force_unit([part.force for curve in curves for part in curve.parts])
    for curve in curves:
        colour, dashes = COLOURS[curve.axis], DASHES[curve.axis]
        if curve.log is not None:
            log = curve.log
            force_time.plot(log.time, factor * log.force, color=colour, lw=0.7, alpha=0.45, zorder=1)
        for part in curve.parts:
            force_time.plot(part.time, factor * part.force, color=colour, lw=1.4)
            strain_time.plot(part.time, 100 * part.strain, color=colour, lw=1.4, ls=dashes)
    draw_marks(force_time, curves, lambda mark: (mark.time, factor * mark.force))
    draw_marks(strain_time, curves, lambda mark: (mark.time, 100 * mark.strain))
    force_time.set_ylabel(f"force [{unit}]")
    force_time.set_title("over time", y=TITLE)
    strain_time.set(xlabel="time [s]", ylabel="strain [%]")
    force_time.tick_params(labelbottom=False)


def _cycle_look(index: int) -> tuple[float, float]:
    """Return line width and opacity of a cycle: later ones are thinner and lighter."""
    return (3.2, 1.0) if index == 0 else (1.1, max(0.45 - 0.1 * (index - 1), 0.2))


def _tint(colour: str, share: float) -> tuple[float, float, float]:
    """Return a colour mixed with white; `share` of it is left [1]."""
    from matplotlib.colors import to_rgb  # noqa: PLC0415

    red, green, blue = (1.0 - share * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue

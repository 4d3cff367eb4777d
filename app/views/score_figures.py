"""Figures of the scoreboard's page, as SVG to be put into HTML."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rigs.axes import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """One curve: x and y (n,) in the units of its panel, its label, none where it is empty, and how it looks."""

    x: FloatArray
    y: FloatArray
    label: str
    colour: str
    style: str = "-"
    width: float = 1.8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """Curves on common axes.

    Attributes
    ----------
    title, x_label, y_label : str
        What it shows, and the axes with their units.
    lines : tuple of Line
        The curves.
    log : bool
        Whether y is logarithmic.
    bars : tuple of (from, to, count)
        A histogram along x behind the curves, with counts on the right.
    """

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    log: bool = False
    bars: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """One figure of the paper, drawn from the lab's own tests: its number, title and panels."""

    name: str
    title: str
    panels: tuple[Panel, ...]


def svg_of(figure: Drawn) -> str:
    """Return a figure as the SVG element that HTML takes; texts are texts, in the reader's own font."""
    import matplotlib as mpl  # noqa: PLC0415 - imported when a figure is wanted
    from matplotlib.figure import Figure  # noqa: PLC0415

    # Ids of clip paths must differ from figure to figure, and be the same in every run.
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": figure.name, "font.family": "sans-serif"}):
        count = len(figure.panels)
        page = Figure(figsize=(5.6, 4.2 if count == 1 else 3.4 * count), layout="constrained")
        for axes, panel in zip(page.subplots(count, 1, squeeze=False)[:, 0], figure.panels, strict=True):
            _draw(axes, panel)
        text = io.StringIO()
        page.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Title": f"Fig. {figure.name}"})
    whole = text.getvalue()
    return whole[whole.index("<svg") :]


def _draw(axes: Axes, panel: Panel) -> None:
    if panel.bars:
        from matplotlib.ticker import MaxNLocator  # noqa: PLC0415

        counts = axes.twinx()
        for low, high, count in panel.bars:
            counts.bar(0.5 * (low + high), count, width=high - low, color="#bbbbbb", zorder=0)
        counts.set_ylabel("fused points broken")
        counts.yaxis.set_major_locator(MaxNLocator(integer=True))
        counts.spines["top"].set_visible(False)
        axes.set_zorder(counts.get_zorder() + 1)
        axes.patch.set_visible(False)
    for line in panel.lines:
        axes.plot(line.x, line.y, color=line.colour, ls=line.style, lw=line.width, label=line.label or None)
    if panel.log:
        axes.set_yscale("log")
        top = max(float(line.y.max()) for line in panel.lines if len(line.y))
        axes.set_ylim(1e-4 * top, 2.0 * top)
    axes.set_title(panel.title, fontsize=10, loc="left")
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    axes.spines["top"].set_visible(False)
    if not panel.bars:
        axes.spines["right"].set_visible(False)
    axes.grid(color="#e6e6e6", lw=0.6)
    axes.set_axisbelow(True)
    axes.legend(frameon=False, fontsize=9, loc="upper left")

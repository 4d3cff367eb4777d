"""Curves of the paper's figures from the lab's own tests, for the page of the scoreboard."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.scoreboard.designs import AT, PLANAR, designs_of
from app.studies.scoreboard.plan import CHANGED, design_names
from app.studies.scoreboard.planar import ALONG, RATE
from app.views.curve_styles import COLOURS, NAMES
from app.views.score_figures import Drawn, Line, Panel
from rigs.analysis.branches import branch
from rigs.analysis.master_curve import paper_factor

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.studies.scoreboard.analysed import Analysed
    from rigs.axes import FloatArray
    from rigs.measurement import Measurement
    from rigs.record import Phase

GREY: Final = "#555555"
SHADES: Final = ("#440154", "#3b528b", "#21918c", "#5ec962", "#d8b500")
"""Dark to light, along a parameter."""

CLAIMS: Final[Mapping[str, tuple[int, ...]]] = {
    "3a": (1, 2, 3, 4, 5, 6, 7),
    "3c": (1, 8, 9, 10, 11, 12),
    "3d": (13, 14, 15, 16, 17),
    "4c": (18, 19, 20),
    "4d": (21,),
    "5b": (22, 23, 24),
}
"""Rows that belong to each figure."""


def figures_of(runs: Mapping[str, Analysed]) -> Iterator[Drawn]:
    """Yield the figures of the paper whose tests were run."""
    for name, title, panels in (
        ("3a", "equibiaxial cycles of the planar knit", _fig3a(runs)),
        ("3c", "designs, materials and cotton, normalised by ξ", _fig3c(runs)),
        ("3d", "course and wale after a pre-strain of the other", _fig3d(runs)),
        ("4c", "a volumetric knit along its three directions", _fig4c(runs)),
        ("4d", "the pile after an equibiaxial pre-strain", _fig4d(runs)),
        ("5b", "micro and macro knit to rupture", _fig5b(runs)),
    ):
        found = [panel for panel in panels if panel.lines]
        if found:
            yield Drawn(name=name, title=title, panels=tuple(found))


def _cycle(test: Measurement, number: int) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """Yield the ways of a cycle with strain [%] and stress [kPa]: full out, dashed back."""
    ways: tuple[tuple[Phase, str], ...] = (("Stretch", "-"), ("Recover", "--"))
    for phase, style in ways:
        rows = branch(test.phase, test.cycle, number, [phase])
        if len(rows) > 1:
            yield style, 100.0 * test.strain[rows], 1e-3 * test.stress[rows]


def _loops(test: Measurement, number: int, label: str, colour: str, width: float = 1.8) -> Iterator[Line]:
    for style, strain, stress in _cycle(test, number):
        yield Line(x=strain, y=stress, label=label if style == "-" else "", colour=colour, style=style, width=width)


def _stress_panel(title: str, lines: list[Line]) -> Panel:
    return Panel(title=title, x_label="effective strain [%]", y_label="effective stress [kPa]", lines=tuple(lines))


def _fig3a(runs: Mapping[str, Analysed]) -> list[Panel]:
    if "fig3a" not in runs:
        return []
    lines: list[Line] = []
    for axis in PLANAR:
        test = runs["fig3a"].curves[axis]
        for number in np.unique(test.cycle):
            first = int(number) == 1
            label = f"{NAMES[axis]}, {'first' if first else 'later'}" if number < 3 else ""
            lines += _loops(test, int(number), label, COLOURS[axis], 2.4 if first else 1.0)
    return [_stress_panel("thick: first cycle; dashed: back", lines)]


def _fig3c(runs: Mapping[str, Analysed]) -> list[Panel]:
    designs = designs_of(runs, design_names())
    spun = designs_of(runs, ["cotton"])
    if not designs:
        return []
    lines, levels = [], []
    named = set()
    for one in (*designs, *spun):
        factor = paper_factor(one.values, one.axis)
        good = one.stress > 0.0
        label = "cotton" if one.name == "cotton" else f"prints, {NAMES[one.axis]}"
        colour = "#CC79A7" if one.name == "cotton" else COLOURS[one.axis]
        width = 2.2 if one.name == "cotton" else 0.9
        scaled = factor * one.stress[good]
        lines.append(
            Line(
                x=100.0 * one.strain[good],
                y=scaled,
                label="" if label in named else label,
                colour=colour,
                style="-" if one.axis == "C" else "--",
                width=width,
            )
        )
        named.add(label)
        if one.name != "cotton":
            levels.append(np.log(factor * float(one.stress_at(AT))))
    at = np.linspace(0.05, 0.4, 36)
    through = np.exp(np.nanmedian(levels) + RATE * (at - AT))
    slope = Line(x=100.0 * at, y=through, label=f"slope of exp({RATE:g} ε)", colour="black", style=":", width=2.0)
    panel = Panel(
        title=f"{1 + sum(map(len, CHANGED.values()))} designs and 2 resins; level of the dotted line free",
        x_label="effective strain [%]",
        y_label="ξ · effective stress [1/(Pa m)]",
        lines=(*lines, slope),
        log=True,
    )
    return [panel]


def _fig3d(runs: Mapping[str, Analysed]) -> list[Panel]:
    panels = []
    for along, axis in ALONG.items():
        names = [name for name in runs if name.startswith(f"fig3d {along} ")]
        lines: list[Line] = []
        for name, colour in zip(names, _shades(len(names)), strict=True):
            label = f"pre-strain {100 * float(name.split()[-1]):.0f} %"
            lines += _loops(runs[name].curves[axis], 1, label, colour)
        panels.append(_stress_panel(f"{along}, first cycle", lines))
    return panels


def _shades(count: int) -> list[str]:
    """Return colours from dark to light."""
    return [SHADES[round(k * (len(SHADES) - 1) / max(count - 1, 1))] for k in range(count)]


def _fig4c(runs: Mapping[str, Analysed]) -> list[Panel]:
    lines: list[Line] = []
    for axis, name in NAMES.items():
        run = runs.get(f"fig4c {axis}")
        if run is not None and axis in run.curves:
            lines += _loops(run.curves[axis], 1, name, COLOURS[axis])
    return [_stress_panel("sides free", lines)]


def _fig4d(runs: Mapping[str, Analysed]) -> list[Panel]:
    names = [name for name in runs if name.startswith("fig4d ") and "P" in runs[name].curves]
    lines: list[Line] = []
    for name, colour in zip(names, _shades(len(names)), strict=True):
        lines += _loops(runs[name].curves["P"], 1, f"pre-strain {100 * float(name.split()[-1]):.0f} %", colour)
    return [_stress_panel("pile, course and wale held", lines)]


def _fig5b(runs: Mapping[str, Analysed]) -> list[Panel]:
    lines = []
    for name, colour in (("micro", "#D55E00"), ("macro", "#0072B2")):
        run = runs.get(f"fig5 {name}")
        if run is not None and "P" in run.curves:
            test = run.curves["P"]
            over = 1e6 * test.stress / run.facts["young_modulus"]
            lines.append(Line(x=test.strain, y=over, label=name, colour=colour))
    breaks = _breaks(runs)
    panel = Panel(
        title="bars: fused points that break",
        x_label="effective strain [1]",
        y_label="σ / E [1e-6]",
        lines=tuple(lines),
        bars=breaks,
    )
    return [panel]


def _breaks(runs: Mapping[str, Analysed]) -> tuple[tuple[float, float, float], ...]:
    """Return the bins in which fused points broke: from and to strain [1], and how many."""
    if "fig5 micro" not in runs:
        return ()
    table = runs["fig5 micro"].tables("bonds").columns
    rows = zip(table["from strain"], table["to strain"], table["broken"], strict=True)
    return tuple((float(low), float(high), float(count)) for low, high, count in rows if float(count) > 0.0)

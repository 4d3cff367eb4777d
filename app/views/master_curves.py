"""The figure of a master curve: curves of all designs as they are and under two scalings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.views.curve_styles import COLOURS, NAMES
from app.views.plots import finish
from rigs.analysis.master_curve import bending_factor, paper_factor

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigs.analysis.master_curve import Design


def master_curve_plot(designs: Sequence[Design], path: Path) -> Path:
    """Draw stress, xi stress and t L l w stress / (E I) of designs over strain in their locking strain.

    Parameters
    ----------
    designs : sequence of Design
        Their strains divided by their locking strains.
    path : Path
        File of the figure.

    Returns
    -------
    Path
        The same path.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    figure = Figure(figsize=(15.0, 5.2), layout="constrained")
    panels = list(figure.subplots(1, 3))
    labels = (
        "effective stress [Pa]",
        "ξ · effective stress (the paper) [1/(Pa m)]",
        "t L l w · effective stress / (E I) [1]",
    )
    factors = [
        [1.0 for _ in designs],
        [paper_factor(one.values, one.axis) for one in designs],
        [bending_factor(one.values, one.axis) for one in designs],
    ]
    for panel, label, scale in zip(panels, labels, factors, strict=True):
        named: set[str] = set()
        top = 0.0
        for one, factor in zip(designs, scale, strict=True):
            good = one.stress > 0.0
            stress = factor * one.stress[good]
            label_of = NAMES[one.axis] if one.axis not in named else None
            named.add(one.axis)
            panel.plot(one.strain[good], stress, color=COLOURS[one.axis], lw=1.0, alpha=0.7, label=label_of)
            top = max(top, float(stress.max(initial=0.0)))
        panel.set(yscale="log", xlim=(0.5, 1.0), ylim=(1e-5 * top, 2.0 * top))
        panel.set_xlabel("effective strain / estimated locking strain [1]", fontsize=12)
        panel.set_ylabel(label, fontsize=12)
        panel.legend(frameon=False, fontsize=10, loc="upper left")
    return finish(figure, panels, path)

"""The figure of a design: how near its tests came, and the last one beside what is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.views.curves import stress_unit
from app.views.plots import finish

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigs.axes import FloatArray

WANTED, REACHED, TESTED = "#404040", "#D55E00", "#0072B2"
LEAST_DISTANCE: Final = 1e-4
"""Distance below which all are drawn alike [1]."""


def design_plot(
    distances: Sequence[float],
    first: int,
    within: float,
    wanted: tuple[FloatArray, FloatArray] | None,
    reached: tuple[FloatArray, FloatArray],
    path: Path,
) -> Path:
    """Draw the distance of every test from what is wanted, and stress over strain of the last one.

    Parameters
    ----------
    distances : sequence of float
        Of the tests in order [1]; inf of one that could not be carried out.
    first : int
        Tests of the first design.
    within : float
        Distance that is near enough [1].
    wanted : (FloatArray, FloatArray) or None
        Strains [1] and stresses [Pa] that are wanted: a secant's ends or a curve; None of a loop area.
    reached : (FloatArray, FloatArray)
        Those of the cycle of the last test.
    path : Path
        File of the figure.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported when a plot is wanted

    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    shown = np.maximum(np.array(distances), LEAST_DISTANCE)
    numbers = np.arange(1, len(shown) + 1)
    left.plot(numbers[:first], shown[:first], "o", color=TESTED, label="design that fills the ranges")
    left.plot(numbers[first:], shown[first:], "D", color=REACHED, label="proposed by the surrogate")
    best = np.minimum.accumulate(shown)
    left.step(numbers, best, where="post", color=WANTED, lw=1.0, label="best so far")
    left.axhline(within, color=WANTED, lw=1.0, ls="--", label="near enough")
    left.set_yscale("log")
    left.set(xlabel="test", ylabel="distance from what is wanted [1]")
    left.legend(frameon=False, fontsize=10)
    factor, unit = stress_unit([reached[1], *([] if wanted is None else [wanted[1]])])
    right.plot(100.0 * reached[0], factor * reached[1], color=REACHED, lw=1.8, label="final test")
    if wanted is not None:
        right.plot(100.0 * wanted[0], factor * wanted[1], "o--", color=WANTED, lw=1.0, ms=5, label="wanted")
    right.set(xlabel="effective strain [%]", ylabel=f"effective stress [{unit}]")
    right.legend(frameon=False, fontsize=10)
    return finish(figure, [left, right], path)

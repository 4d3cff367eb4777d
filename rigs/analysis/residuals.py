"""Differences between a measured test and a model of it, branch by branch: loading, hold, unloading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from rigs.analysis.branches import branch
from rigs.instruments.pchip import Pchip

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.analysis.alignment import Aligned
    from rigs.analysis.comparison import Across, Along
    from rigs.axes import FloatArray
    from rigs.record import Phase

Name = Literal["loading", "hold", "unloading"]

PHASES: Final[Mapping[Name, Phase]] = {"loading": "Stretch", "hold": "Hold", "unloading": "Recover"}

MOST_BINS: Final = 200
"""Groups of consecutive rows of a branch whose mean difference counts; of fewer rows each counts."""

FEWEST_ROWS: Final = 3
"""Rows that a branch needs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Residuals:
    """Differences of one branch.

    Attributes
    ----------
    name : str
        Which branch.
    x, measured, model : FloatArray, shape (m,)
        Means of groups of rows: strain [1], travel [m] or time of the hold [s]; stress [Pa] or force [N].
    scaled : FloatArray, shape (m,)
        (model - measured) / range of the measured cycle [1].
    covered : float
        Share of the rows whose x the model reached [1]; elsewhere its value at the nearer end counts.
    """

    name: Name
    x: FloatArray
    measured: FloatArray
    model: FloatArray
    scaled: FloatArray
    covered: float


def branch_of(one: Aligned, name: Name, across: Across, along: Along) -> tuple[FloatArray, FloatArray]:
    """Return x and y of a branch of an aligned cycle, (n,) each; rows without a number are left out."""
    test = one.test
    rows = branch(test.phase, test.cycle, int(test.cycle[-1]), [PHASES[name]])
    part = test.chosen(rows)
    if not len(part):
        return np.zeros(0), np.zeros(0)
    x = part.time - part.time[0] if name == "hold" else getattr(part, across)
    y = getattr(part, along)
    good = np.isfinite(x) & np.isfinite(y)
    return x[good], y[good]


def residuals(measured: Aligned, model: Aligned, across: Across, along: Along) -> list[Residuals]:
    """Return the differences of a measured cycle and its model over every branch that both have.

    The model is read at each measured row, along the shape-preserving cubic that instruments sample, and differences
    are averaged over groups of consecutive rows: without a bias where the curve bends, and every branch counts
    alike whatever the rate of its log.

    Parameters
    ----------
    measured, model : Aligned
        One cycle of each.
    across, along : str
        What is compared over what.
    """
    curves = {name: branch_of(measured, name, across, along) for name in PHASES}
    every = np.concatenate([y for _, y in curves.values()])
    spread = float(np.ptp(every)) if len(every) else 0.0
    found = []
    for name, (x, y) in curves.items():
        points = _rising(*branch_of(model, name, across, along), falling=name == "unloading")
        if len(x) < FEWEST_ROWS or len(points[0]) < FEWEST_ROWS or spread == 0.0:
            continue
        found.append(_differences(name, (x, y), points, spread))
    return found


def _differences(
    name: Name, measured: tuple[FloatArray, FloatArray], model: tuple[FloatArray, FloatArray], spread: float
) -> Residuals:
    """Return the differences of a branch."""
    x, y = measured
    low, high = float(model[0][0]), float(model[0][-1])
    slack = 0.01 * float(np.ptp(x))
    read = Pchip.through(*model)(np.clip(x, low, high))
    bins = np.array_split(np.arange(len(x)), min(len(x), MOST_BINS))
    means = [np.array([values[rows].mean() for rows in bins]) for values in (x, y, read)]
    return Residuals(
        name=name,
        x=means[0],
        measured=means[1],
        model=means[2],
        scaled=(means[2] - means[1]) / spread,
        covered=float(np.mean((x >= low - slack) & (x <= high + slack))),
    )


def _rising(x: FloatArray, y: FloatArray, *, falling: bool) -> tuple[FloatArray, FloatArray]:
    """Return a branch as points whose x rises: what goes back is left out."""
    if falling:
        x, y = x[::-1], y[::-1]
    if not len(x):
        return x, y
    before = np.concatenate([[-np.inf], np.maximum.accumulate(x)[:-1]])
    kept = x > before + 1e-12 * float(np.ptp(x))
    return x[kept], y[kept]

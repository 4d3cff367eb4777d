"""Main effects of a sweep's parameters, and maps of points that fill a plane without a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from rigs.axes import FloatArray, IntArray

MOST_LEVELS: Final = 8
"""Different values up to which each is a level of its own."""

LEVELS: Final = 5
"""Levels of a parameter with more values: as many points in each."""

POINT, MEAN = "#0072B2", "#D55E00"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Factor:
    """A parameter of a sweep at every point.

    Attributes
    ----------
    label : str
        Its name and unit.
    at : FloatArray, shape (n,)
        Its value at each point, or the number of its word.
    words : sequence of str
        The words by their number; empty of numbers.
    """

    label: str
    at: FloatArray
    words: Sequence[str]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Effect:
    """Means of a figure over the levels of one parameter.

    Attributes
    ----------
    at, mean, error : FloatArray, shape (k,)
        Mean value of the parameter in each level, mean of the figure there, and its standard error (nan of one point).
    share : float
        Share of the figure's variance that lies between the levels [1].
    """

    at: FloatArray
    mean: FloatArray
    error: FloatArray
    share: float


def levels_of(at: FloatArray) -> IntArray:
    """Return the level of every value (n,), from 0: of few values each, else of equal counts."""
    values, number = np.unique(at, return_inverse=True)
    if len(values) <= MOST_LEVELS:
        return number.astype(np.int64)
    rank = np.argsort(np.argsort(at, kind="stable"), kind="stable")
    found: IntArray = (rank * LEVELS) // len(at)
    return found


def effect_of(at: FloatArray, values: FloatArray) -> Effect:
    """Return the main effect of a parameter: what a figure is on average at each level, whatever the others are.

    `share` is the correlation ratio η² = Σ n_k (mean_k - mean)² / Σ (y - mean)² (Pearson, On the general theory of skew
    correlation, 1905): 1 where the level alone tells the figure, (k - 1)/(n - 1) on average where it tells nothing.

    Parameters
    ----------
    at, values : FloatArray, shape (n,)
        The parameter and the figure at every point; points without the figure (nan) are left out.
    """
    known = np.isfinite(values)
    at, values = at[known], values[known]
    level = levels_of(at)
    parts = [level == k for k in np.unique(level)]
    mean = np.array([values[part].mean() for part in parts])
    counts = np.array([int(part.sum()) for part in parts])
    spread = [values[part].std(ddof=1) if part.sum() > 1 else np.nan for part in parts]
    whole = float(((values - values.mean()) ** 2).sum()) if len(values) else 0.0
    between = float((counts * (mean - values.mean()) ** 2).sum()) if len(values) else 0.0
    return Effect(
        at=np.array([at[part].mean() for part in parts]),
        mean=mean,
        error=np.array(spread) / np.sqrt(counts),
        share=between / whole if whole > 0.0 else float("nan"),
    )


def draw_effect(axes: Axes, factor: Factor, values: FloatArray) -> None:
    """Draw a figure (n,) over one parameter: every point, and the means of its levels with their standard errors."""
    effect = effect_of(factor.at, values)
    axes.plot(factor.at, values, "o", ms=4, color=POINT, alpha=0.5, label="points")
    # Between words there is nothing that a line could stand for.
    line = "o" if factor.words else "o-"
    axes.errorbar(effect.at, effect.mean, effect.error, fmt=line, ms=6, color=MEAN, capsize=3, label="mean of a level")
    if np.isfinite(effect.share):
        axes.set_title(f"{100.0 * effect.share:.0f} % of the variance", fontsize=10, loc="left")
    axes.set_xlabel(factor.label, fontsize=12)
    if factor.words:
        axes.set_xticks(range(len(factor.words)), factor.words)


def draw_scattered(axes: Axes, factors: tuple[Factor, Factor], values: FloatArray, label: str) -> None:
    """Draw a figure (n,) as the colour of points in the plane of two parameters; nothing is interpolated."""
    first, second = factors
    known = np.isfinite(values)
    axes.plot(first.at[~known], second.at[~known], "x", color="#808080")
    drawn = axes.scatter(
        first.at[known], second.at[known], c=values[known], s=60, cmap="viridis", edgecolors="black", linewidths=0.5
    )
    axes.set_xlabel(first.label, fontsize=12)
    axes.set_ylabel(second.label, fontsize=12)
    if first.words:
        axes.set_xticks(range(len(first.words)), first.words)
    if second.words:
        axes.set_yticks(range(len(second.words)), second.words)
    axes.figure.colorbar(drawn, ax=axes, label=label)

"""Rank correlation: whether one quantity rises with another, whatever the form of the curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence


def rank_correlation(x: Sequence[float], y: Sequence[float]) -> float:
    """Return Spearman's ρ of two quantities (n,): 1 where y rises with every x, -1 where it falls; ``nan`` if constant.

    The correlation of ranks, those of equal values their mean (C. Spearman, Am. J. Psychol. 15 (1904) 72).
    """
    from scipy.stats import rankdata  # noqa: PLC0415 (scipy.stats takes a third of a second to import)

    a, b = rankdata(x), rankdata(y)
    spread = float(np.std(a) * np.std(b))
    return float(np.mean((a - a.mean()) * (b - b.mean()))) / spread if spread > 0.0 else float("nan")

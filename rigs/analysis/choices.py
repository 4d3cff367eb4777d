"""What is asked of an analysis: windows of strain, and what counts as a break."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from rigs.analysis.maxima import DROP
from rigs.analysis.moduli import FIRST_STRAIN

Window: TypeAlias = tuple[float, float]
"""Two strains [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """What is asked of an analysis.

    Attributes
    ----------
    windows : tuple of (float, float)
        Strains, from where a cycle sets out, between which moduli are worked out [1].
    fit : (float, float) or None
        Window of strain of fits [1]; None for from a fiftieth of the largest stress to that.
    drop : float
        Share of its maximum by which the force has fallen at break [1].
    """

    windows: tuple[Window, ...] = ((0.0, FIRST_STRAIN),)
    fit: Window | None = None
    drop: float = DROP

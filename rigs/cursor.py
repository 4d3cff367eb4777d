"""Say where in its protocol a test stands, in plain numbers.

A cursor is taken at a row. The strokes before it are not gone again: their plan is told where each of them ended.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.record import Equilibrium
    from rigs.steps import Axis

Displacement: TypeAlias = "Mapping[Axis, float]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Say where on a straight way of the axes a march stands.

    Attributes
    ----------
    begin : float
        Share of the way at which the march began: 0, or where a fibre broke last [1].
    at : float
        Share of what was left from there at which it stands [1].
    step : float or None
        Length of its next step, as a share of the same; None is the longest [1].
    """

    begin: float = 0.0
    at: float = 0.0
    step: float | None = None

    @property
    def share(self) -> float:
        """Return the share of the whole way; exact at its end."""
        return 1.0 if self.at == 1.0 else self.begin + self.at * (1.0 - self.begin)


START: Final = Place()
END: Final = Place(at=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cursor:
    """Say where in its protocol a test stands.

    A stroke is gone in one leg or several, each on a straight way. Whatever else a controller keeps from row to row
    goes into `variables`.

    Attributes
    ----------
    stroke : int
        Number of the stroke under way, from 1; 0 before the first.
    reached : Mapping
        Where each stroke before it ended that did not end where it was planned to: displacements [m] by its number.
    begun : float
        Time at which the stroke under way began [s].
    leg : int
        Number of its leg under way, from 0.
    origin : Mapping
        Displacements where that leg began [m].
    place : Place or None
        Where on its way the leg stands; None where it cannot be gone on from.
    variables : Mapping
        What the controller of the stroke keeps, by name.
    last : Equilibrium or None
        The last row.
    """

    stroke: int = 0
    reached: Mapping[int, Displacement] = field(default_factory=dict)
    begun: float = 0.0
    leg: int = 0
    origin: Displacement = field(default_factory=dict)
    place: Place | None = START
    variables: Mapping[str, float] = field(default_factory=dict)
    last: Equilibrium | None = None

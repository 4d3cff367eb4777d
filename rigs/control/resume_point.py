"""Say where in its protocol a test stands, in plain numbers.

A cursor is taken at a row. The strokes before it are not gone again.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.control.controller import Memory
    from rigs.protocol.strokes import Readings
    from rigs.record import Equilibrium

Displacement: TypeAlias = "Mapping[Axis, float]"


@dataclass(frozen=True, slots=True, kw_only=True)
class PathPosition:
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


START: Final = PathPosition()
END: Final = PathPosition(at=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ResumePoint:
    """Say where in its protocol a test stands.

    A stroke is gone in one leg or several, each on a straight way.

    Attributes
    ----------
    memory : Memory
        What the controller remembers.
    leaf : int
        Turn of the step under way, from 0.
    stroke : int
        Number of its stroke under way, from 0.
    sight : Readings or None
        What the controller saw when that stroke began; None before it did.
    begun : float
        When that was [s].
    leg : int
        Number of its leg under way, from 0.
    origin : Mapping
        Displacements where that leg began [m].
    place : PathPosition or None
        Where on its way the leg stands; None where it cannot be gone on from.
    variables : Mapping
        What else the controller needs to go on with the stroke, by name.
    last : Equilibrium or None
        The last row.
    """

    memory: Memory
    leaf: int = 0
    stroke: int = 0
    sight: Readings | None = None
    begun: float = 0.0
    leg: int = 0
    origin: Displacement = field(default_factory=dict)
    place: PathPosition | None = START
    variables: Mapping[str, float] = field(default_factory=dict)
    last: Equilibrium | None = None

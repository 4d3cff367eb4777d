"""Position of a test in its protocol, in plain numbers, from which it can be resumed.

It is taken at a row. The strokes before it are not made again.
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
    """Position of a march on a straight path of the axes.

    Attributes
    ----------
    begin : float
        Share of the path at which the march began: 0, or where a fibre broke last [1].
    at : float
        Share of the rest of the path from there at which it is [1].
    step : float or None
        Length of its next step, as a share of the same; None is the longest [1].
    """

    begin: float = 0.0
    at: float = 0.0
    step: float | None = None

    @property
    def share(self) -> float:
        """Return the share of the whole path; exact at its end."""
        return 1.0 if self.at == 1.0 else self.begin + self.at * (1.0 - self.begin)


START: Final = PathPosition()
END: Final = PathPosition(at=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ResumePoint:
    """Position of a test in its protocol.

    A stroke has one segment or several, each a straight path.

    Attributes
    ----------
    memory : Memory
        What the controller remembers.
    leaf : int
        Index of the step under way, from 0.
    stroke : int
        Index of its stroke under way, from 0.
    readings : Readings or None
        What the controller saw when that stroke began; None before it did.
    begun : float
        When that was [s].
    segment : int
        Index of its segment under way, from 0.
    origin : Mapping
        Displacements where that segment began [m].
    place : PathPosition or None
        Position on the path of the segment; None where the test cannot be resumed.
    variables : Mapping
        What else the controller needs to continue the stroke, by name.
    last : Equilibrium or None
        The last row.
    """

    memory: Memory
    leaf: int = 0
    stroke: int = 0
    readings: Readings | None = None
    begun: float = 0.0
    segment: int = 0
    origin: Displacement = field(default_factory=dict)
    place: PathPosition | None = START
    variables: Mapping[str, float] = field(default_factory=dict)
    last: Equilibrium | None = None

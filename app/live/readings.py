"""Readings of a live rig: what its encoders and load cells show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.control.session import Session


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What a rig shows at its last equilibrium, counted from the last zero.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    displacement : Mapping
        Change of the hook-to-hook length of each axis, as its encoder shows it [m].
    strain : Mapping
        The same over the gauge length [1].
    force : Mapping
        What the load cell of each axis shows, zeroed, as a mean over a second or longer [N].
    """

    time: float
    displacement: Mapping[Axis, float]
    strain: Mapping[Axis, float]
    force: Mapping[Axis, float]


def reading_of(session: Session) -> Reading:
    """Return what the rig of a test shows."""
    history = session.memory.history
    displacement = {axis: at - history.origin[axis] for axis, at in session.crosshead.items()}
    return Reading(
        time=session.time,
        displacement=displacement,
        strain={axis: at / history.gauges[axis] for axis, at in displacement.items()},
        force=dict(session.memory.shown),
    )

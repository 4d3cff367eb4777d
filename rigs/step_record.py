"""Record of how the steps of a run ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigs.record import End


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRecord:
    """How a step of the protocol ended; while it is under way, as if it were aborted.

    Attributes
    ----------
    number : int
        Its turn in the test, from 0; rows name it as their `step`.
    place : str
        Its place in the protocol, ``steps[2].cycle``.
    tag : str or None
        Its label.
    start, time : float
        When it began and ended, on the rig's clock [s].
    end : End
        ``limit`` also where `until` ended it, ``timeout`` where its time did, ``rupture`` where the force dropped
        because something broke, ``slipped`` where it dropped though nothing did.
    message : str
        One line for the user; empty when there is nothing to add.
    """

    number: int
    place: str
    tag: str | None
    start: float
    time: float
    end: End
    message: str = ""

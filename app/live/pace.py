"""Pace of a live rig: how the time of its clock passes on the wall's."""

from __future__ import annotations

import threading
from time import perf_counter
from typing import TYPE_CHECKING, Literal, TypeAlias

from knitlab_core.errors import SpecificationError
from rigs.record import Equilibrium

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.control.experiment import Event

Speed: TypeAlias = float | Literal["real"] | None
"""How many seconds of the rig pass in one; "real" is 1, and None does not wait."""


class Pace:
    """Waiting of a test for its own clock.

    Parameters
    ----------
    speed : float, 'real' or None
        How many seconds of the rig pass in one second; None for no waiting.

    Raises
    ------
    SpecificationError
        If it is none of these.
    """

    def __init__(self, speed: Speed) -> None:
        factor = 1.0 if speed == "real" else speed
        number = isinstance(factor, int | float) and not isinstance(factor, bool)
        if factor is not None and not (number and 0.0 < float(factor) < float("inf")):
            raise SpecificationError(
                "pace", speed, "real, a factor above 0 (2 is twice as fast), or None for no waiting"
            )
        self._speed = None if factor is None else float(factor)
        self._cut = threading.Event()
        self._began = self._since = 0.0

    def begin(self, time: float) -> None:
        """Begin a step now, at a time of the rig's clock [s]."""
        self._began, self._since = time, perf_counter()
        self._cut.clear()

    def cut(self) -> None:
        """Wait no more in the step under way."""
        self._cut.set()

    def keep(self, events: Iterator[Event]) -> Iterator[Event]:
        """Yield the events of a test, each equilibrium not before its time."""
        for event in events:
            if isinstance(event, Equilibrium) and self._speed is not None:
                left = self._since + (event.time - self._began) / self._speed - perf_counter()
                if left > 0.0:
                    self._cut.wait(min(left, threading.TIMEOUT_MAX))
            yield event

"""How much the logs of a test take; needs no file format, so that a check loads none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.logs.catalogue import LOGS, defaults

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.logs.logged import Log

TEXT_SIZE: Final = 8
"""About how much a number of a log takes as text [bytes]."""


def row_size(machines: Sequence[str], pins: int = 0) -> int:
    """Return about how much a row of a test's logs takes at most, in the record and in its default files [bytes].

    Parameters
    ----------
    machines : sequence of str
        The machine of each driven axis.
    pins : int
        Pairs of pins that an extensometer reads.
    """
    shown = sum(_columns(LOGS[dialect], machines) for dialect in defaults(machines))
    own = sum(sample_size(2 * machines.count(machine)) for machine in set(machines))
    return own + (sample_size(pins) - sample_size(0)) + TEXT_SIZE * (shown + pins)


def _columns(log: Log, machines: Sequence[str]) -> int:
    """Return how many columns a log has, without those of pins."""
    # An axis of a machine has as many columns as any other.
    count = sum(machines.count(machine) for machine in log.machines)
    return len(log.of_axes(["C"] * count).columns)


def sample_size(channels: int) -> int:
    """Return how much a sample of an instrument with some channels takes before it is packed [bytes]."""
    return 8 + 8 + 1 + 4 + 3 * 8 * channels

"""Number the strokes of a test as Bluehill 3 does: segment identities and the total cycle count."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.instruments.samples import parts_of
from rigs.instruments.ticks import PART

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.instruments.samples import Table
    from rigs.record import Phase

OUTWARD: Final = 22476
RETURN: Final = 22412
COUNTED_AFTER: Final = 0.01
"""Share of a stroke after a turnaround at which the cycle is counted."""


def segments(phases: Sequence[Phase], before: int = OUTWARD) -> list[int]:
    """Return the segment identity of samples: outward, return, or, at rest, that of the stroke before."""
    found, current = [], before
    for phase in phases:
        current = {"Stretch": OUTWARD, "Recover": RETURN}.get(phase, current)
        found.append(current)
    return found


@dataclass(slots=True, kw_only=True)
class _Outward:
    """An outward stroke that follows a return: its samples, where it set out [m], and the cycles since."""

    first: int
    low: float
    cycles: int


def rises(table: Table, channel: str) -> list[tuple[int, int]]:
    """Return the samples from which on the total cycle count is higher, and by how much.

    It starts at 0 and rises when an outward stroke that follows a return has made 1 % of its way: by one, and by the
    cycles between that were not logged.

    Parameters
    ----------
    table : Table
        What the machine logged.
    channel : str
        Its displacement, of which that without noise counts [m].
    """
    found: list[tuple[int, int]] = []
    under_way: _Outward | None = None
    returned, was, at, cycle, number = False, False, 0.0, 0, 0
    for part in parts_of(table):
        travel = part.clean[channel]
        for k, phase in enumerate(part.phase):
            goes, before, at = phase == "Stretch", at, float(travel[k])
            if phase == "Recover":
                returned, cycle = True, int(part.cycle[k])
            elif goes and not was and returned:
                returned = False
                # It turned between two samples, or at the lower of them.
                cycles = max(1, int(part.cycle[k]) - cycle)
                under_way = _Outward(first=number, low=min(before, at), cycles=cycles)
            if under_way is not None and not goes:
                found.append((_counted(table, channel, under_way, number, before), under_way.cycles))
                under_way = None
            was, number = goes, number + 1
    if under_way is not None:
        found.append((_counted(table, channel, under_way, number, at), under_way.cycles))
    return found


def _counted(table: Table, channel: str, stroke: _Outward, end: int, at: float) -> int:
    """Return the first sample of an outward stroke, before `end`, at which its cycle is counted; it ends at [m]."""
    for first in range(stroke.first, end, PART):
        way = table.part(first, min(first + PART, end)).clean[channel] - stroke.low
        reached = np.flatnonzero(way >= COUNTED_AFTER * (at - stroke.low))
        if reached.size:
            return first + int(reached[0])
    return stroke.first


def counts(found: Sequence[tuple[int, int]], first: int, last: int) -> list[int]:
    """Return the total cycle count of the samples from the first on and before the last, given where it `rises`."""
    total = np.zeros(last - first, dtype=np.int64)
    for at, by in found:
        total[max(at - first, 0) :] += by
    return [int(count) for count in total]

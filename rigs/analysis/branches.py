"""Branches of a test: rows between two turns of the strain, by the phases of a record or from the strain alone."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray
    from rigs.record import Phase

TURN: Final = 0.05
"""Share of a path's range of strain by which strain goes back where a branch ends; what is less is noise."""

STANDING: Final = 2e-3
"""Share of the range of travel within which an axis is at rest."""

LEAST_AT_REST: Final = 5
"""Rows that stand still one after the other from which on they are a hold ..."""

LEAST_SHARE: Final = 0.01
"""... where they are also more than this share of all rows: at a turn some stand near it, however dense they are."""


def branch(phase: Sequence[Phase], cycle: IntArray, number: int, which: Sequence[Phase]) -> IntArray:
    """Return the rows of one cycle in some phases, with the row they set out from.

    Parameters
    ----------
    phase : sequence of Phase, length n
        Phase of every row.
    cycle : IntArray, shape (n,)
        Cycle of every row.
    number : int
        The cycle wanted.
    which : sequence of Phase
        The phases wanted: ``["Stretch"]`` is the loading branch.

    Returns
    -------
    IntArray, shape (m,)
        Row indices, empty if the cycle has no such rows.
    """
    wanted = np.flatnonzero((np.asarray(cycle) == number) & np.isin(np.asarray(phase), which))
    if len(wanted) and wanted[0] > 0:
        wanted = np.concatenate([[wanted[0] - 1], wanted])
    return wanted.astype(np.int64)


def turning_rows(strain: FloatArray) -> list[int]:
    """Return the first row, those where strain turns back by more than noise, and the last row."""
    if len(strain) < 2:
        return []
    back = TURN * float(np.ptp(strain))
    turns, low, high, way = [0], 0, 0, 0
    for row, value in enumerate(strain):
        # Before the first turn it is not yet known whether the path goes up or down.
        if way >= 0 and value > strain[high]:
            high = row
        if way <= 0 and value < strain[low]:
            low = row
        if way >= 0 and strain[high] - value > back:
            turns, low, way = turns + [high] * (high > turns[-1]), row, -1
        elif way <= 0 and value - strain[low] > back:
            turns, high, way = turns + [low] * (low > turns[-1]), row, 1
    return [*turns, len(strain) - 1]


def strokes_of(travel: FloatArray) -> tuple[IntArray, tuple[Phase, ...]]:
    """Return cycle and phase of every row of a log that says neither.

    A cycle begins where the axis sets out from its lower turn. Rows that stand within `STANDING` of a turn are a hold,
    if there are enough of them.

    Parameters
    ----------
    travel : FloatArray, shape (n,)
        Travel of the axis [m], or its strain [1].

    Returns
    -------
    cycle : IntArray, shape (n,)
        Counter from 1.
    phase : tuple of Phase, length n
        ``Stretch`` outward, ``Recover`` back, ``Hold`` at rest. A row belongs to the stroke that led to it.
    """
    count = len(travel)
    cycle, outward = np.ones(count, dtype=np.int64), np.ones(count, dtype=np.bool_)
    still, number = np.zeros(count, dtype=np.bool_), 0
    near = STANDING * float(np.ptp(travel)) if count else 0.0
    for first, last in pairwise(_far_turns(travel)):
        rows = slice(first + 1, last + 1)
        outward[rows] = travel[last] > travel[first]
        # The first branch may be a return: its cycle set out before the log began.
        number += int(outward[last] or number == 0)
        cycle[rows] = number
        way = travel[first : last + 1]
        leaving, coming = (np.flatnonzero(np.abs(way - end) > near) for end in (way[0], way[-1]))
        if len(leaving) and len(coming):
            # The row at a turn belongs to the stroke that led there.
            still[first + (first > 0) : first + int(leaving[0])] = True
            still[first + int(coming[-1]) + 2 : last + 1] = True
    phase: list[Phase] = ["Stretch" if goes else "Recover" for goes in outward.tolist()]
    for rest in _runs(still):
        if rest.stop - rest.start >= max(LEAST_AT_REST, LEAST_SHARE * count):
            phase[rest] = ["Hold"] * (rest.stop - rest.start)
    return cycle, tuple(phase)


def _far_turns(travel: FloatArray) -> list[int]:
    """Return the turning rows without those by which noise begins or ends the first or the last branch."""
    turns, back = turning_rows(travel), TURN * float(np.ptp(travel)) if len(travel) else 0.0
    for inner, outer in ((1, 0), (-2, -1)):
        if len(turns) > 2 and abs(float(travel[turns[inner]] - travel[turns[outer]])) <= back:
            del turns[inner]
    return turns


def _runs(flags: npt.NDArray[np.bool_]) -> list[slice]:
    """Return the runs of rows that are true, (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [slice(first, last) for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)]


def holds(phase: Sequence[Phase]) -> list[slice]:
    """Return the rows of every hold, each with the row that it sets out from."""
    return [slice(max(rest.start - 1, 0), rest.stop) for rest in _runs(np.asarray(phase, dtype=object) == "Hold")]

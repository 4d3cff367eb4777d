"""Where a specimen jumps: a fibre or a fused point breaks, or strands snap, while the axes stand where they are.

A jump takes no time. In a record it lies between two rows: the last one before it and the first one after it. Where
both are at one time they say all; where the first equilibrium that was found after a jump is a little later, the jump
follows at once on the row before it. `parted` makes two rows at one time of every jump; who reads between rows reads
what it returns, up to the former row and from the latter on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.trace import Trace

if TYPE_CHECKING:
    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray

STANDING: Final = ("time", "displacement_", "crosshead_")
"""Columns that a jump does not change: axes move on steadily."""


BREAKS: Final = ("fracture_work", "bonds_broken")
"""Columns that change where a fibre or a fused point breaks."""


def jumped(trace: Trace) -> npt.NDArray[np.bool_]:
    """Return for every row whether the specimen jumped since the row before.

    Fibres and fused points that broke are in the record. A snap is told by its work, if that is more than the
    trapezium rule of the work between the two rows can be wrong by (decision 17).

    Returns
    -------
    array of bool, shape (n,)
        False for the first row.
    """
    columns, found = trace.columns, np.zeros(len(trace), dtype=np.bool_)
    for name in BREAKS:
        if name in columns:
            found[1:] |= np.diff(columns[name]) != 0.0
    if "snap_work" in columns and len(trace) > 1:
        pushed = [np.diff(columns[f"force_{axis}"]) * np.diff(columns[f"displacement_{axis}"]) for axis in trace.axes]
        found[1:] |= np.diff(columns["snap_work"]) > 0.5 * np.abs(np.sum(pushed, axis=0))
    return found


def jump_times(trace: Trace) -> FloatArray:
    """Return the times of the jumps [s], rising, shape (k,)."""
    rows = np.flatnonzero(jumped(trace))
    return np.unique(trace.columns["time"][rows - 1])


def parted(trace: Trace) -> Trace:
    """Return a trace in which every jump is two rows at one time, before and after it.

    A row that is missing right after a jump has the axes of the row before, and all else of the next one.
    """
    times = trace.columns["time"]
    late = np.flatnonzero(jumped(trace))
    late = late[times[late] > times[late - 1]]
    if not late.size:
        return trace
    columns = {}
    for name, values in trace.columns.items():
        missing = values[late - 1 if name.startswith(STANDING) else late]
        columns[name] = np.insert(values, late, missing)
    order = np.insert(np.arange(len(trace)), late, late)
    return Trace(columns=columns, phase=tuple(trace.phase[k] for k in order), tag=tuple(trace.tag[k] for k in order))


def pieces(times: FloatArray, stroke: IntArray) -> list[tuple[int, int]]:
    """Return the first and last rows of the smooth pieces of a trace whose jumps are parted.

    A piece ends where a stroke does, which is where the next begins, and where a row follows at the same time.

    Parameters
    ----------
    times : FloatArray, shape (n,)
        Times of the rows [s], not falling.
    stroke : IntArray, shape (n,)
        Stroke of every row.
    """
    found, first = [], 0
    cuts = np.flatnonzero((np.diff(stroke) != 0) | (np.diff(times) <= 0.0)) + 1
    for cut in (*cuts.tolist(), len(times)):
        # The row before a stroke begins it, unless that begins with a jump.
        begin = first - 1 if first > 0 and times[first] > times[first - 1] else first
        if cut - 1 > begin:
            found.append((begin, cut - 1))
        first = cut
    return found


def joined(at: FloatArray, time: FloatArray, values: FloatArray, jumps: FloatArray) -> FloatArray:
    """Join samples by straight lines, but not across a jump: there the sample on the same side of it counts.

    Parameters
    ----------
    at : FloatArray, shape (m,)
        Times to read at [s]; beyond the samples the nearest one counts.
    time, values : FloatArray, shape (n,)
        The samples; times [s] rise.
    jumps : FloatArray, shape (k,)
        Times of the jumps [s], rising; a sample at a jump's time is before it.

    Returns
    -------
    FloatArray, shape (m,)
        Values, in the unit of the samples.
    """
    read = np.interp(at, time, values)
    if not jumps.size or len(time) < 2:
        return read
    after = np.clip(np.searchsorted(time, at, side="right"), 1, len(time) - 1)
    sides = (np.searchsorted(jumps, moments, side="left") for moments in (time[after - 1], at, time[after]))
    before, here, beyond = sides
    torn = (before != beyond) & (at > time[0]) & (at < time[-1])
    if not torn.any():
        return read
    near = np.where(here == before, values[after - 1], values[after])
    result: FloatArray = np.where(torn, near, read)
    return result

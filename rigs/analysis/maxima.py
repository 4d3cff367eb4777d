"""Largest force of a test and where the specimen broke."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from rigs.axes import FloatArray

DROP: Final = 0.4
"""Share of the largest force by which it has fallen where the specimen is broken [1]."""


def row_of_maximum(force: FloatArray) -> int | None:
    """Return the row of the largest force [N], (n,); None if there is no force above 0."""
    known = np.where(np.isfinite(force), force, -np.inf)
    row = int(np.argmax(known)) if len(force) else 0
    return row if len(force) and known[row] > 0.0 else None


def row_of_break(travel: FloatArray, force: FloatArray, drop: float = DROP) -> int | None:
    """Return the row at break: the last one before the force falls below (1 - drop) of its maximum.

    The maximum must come first, and the specimen must not be unloaded: a fall while travel goes back by more than a
    twentieth of its range is none. What frames call the end of test by "rate of load" or "break sensitivity" is `drop`,
    often 40 %. The row is that before the fall, as ASTM D638 asks for values at break.

    Parameters
    ----------
    travel, force : FloatArray, shape (n,)
        Travel [m] and force [N] in the order of time.
    drop : float
        Share of the maximum [1].

    Returns
    -------
    int or None
        None if the specimen did not break.
    """
    top = row_of_maximum(force)
    if top is None:
        return None
    low = np.flatnonzero(force[top:] < (1.0 - drop) * force[top])
    if not len(low):
        return None
    fallen = top + int(low[0])
    back = float(np.max(travel[top : fallen + 1]) - travel[fallen])
    return None if back > 0.05 * float(np.ptp(travel)) else fallen - 1

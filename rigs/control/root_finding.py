"""Root search for the travel of axes that meets setpoints; a function value is an equilibrium, and may fail.

One unknown: secants kept inside a bracket. Several: Broyden's secants, shortened where they overshoot.

References
----------
C. G. Broyden, Math. Comp. 19 (1965) 577: the rank-one update.
M. Dowell and P. Jarratt, BIT 11 (1971) 168: the Illinois false position.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Callable

FloatArray: TypeAlias = npt.NDArray[np.float64]
Function: TypeAlias = "Callable[[FloatArray], FloatArray | None]"

MOST_TRIALS: Final = 60
MOST_RETREATS: Final = 8
STALLED: Final = 1.0 / 16.0
"""Where secants overshoot even with this share of a step, derivatives are measured by differences."""

NARROW: Final = 1e-9
"""A bracket this share of the box wide holds a jump, not a root."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Root:
    """End of a search.

    Attributes
    ----------
    at : FloatArray, shape (n,)
        The point; it is the one that was tried last.
    slope : FloatArray, shape (n, n)
        Derivatives there, as the search estimates them.
    met : bool
        Whether every value is within 1 of zero, or jumps across it; if not, the box has no such point.
    jumps : bool
        Whether a value jumps across zero there.
    """

    at: FloatArray
    slope: FloatArray
    met: bool
    jumps: bool = False


def find_root(
    function: Function, start: FloatArray, slope: FloatArray, box: FloatArray, *, most: int = MOST_TRIALS
) -> Root | None:
    """Search a box for a point at which every value of a function is within 1 of zero.

    Parameters
    ----------
    function : callable
        Values (n,) at a point (n,), None where there are none. Of one unknown it must not fall.
    start : FloatArray, shape (n,)
        Where to try first.
    slope : FloatArray, shape (n, n)
        A guess of the derivatives.
    box : FloatArray, shape (2, n)
        Lowest and highest point; the function has values in its middle.
    most : int
        Most points that are tried.

    Returns
    -------
    Root or None
        None if the search failed.
    """
    middle = box.mean(axis=0)
    at, value = _nearest(function, np.clip(start, *box), middle)
    if value is None:
        return None
    if len(start) == 1:
        return _in_bracket(function, float(at[0]), float(value[0]), float(slope[0, 0]), box[:, 0], most)
    return _broyden(function, at, value, slope, box, most)


def _nearest(function: Function, wanted: FloatArray, base: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """Return the wanted point and its values, or where they fail a point nearer to `base`."""
    at = wanted
    for _ in range(MOST_RETREATS):
        value = function(at)
        if value is not None:
            return at, value
        at = 0.5 * (at + base)
    return base, function(base)


def _in_bracket(function: Function, at: float, value: float, slope: float, box: FloatArray, most: int) -> Root | None:
    """Search an interval for the root of a function that does not fall."""
    low, high = (float(edge) for edge in box)
    below, above, side = np.nan, np.nan, 0
    for _ in range(most):
        if abs(value) <= 1.0:
            return _root(at, slope, met=True)
        if high - low <= NARROW * (box[1] - box[0]):
            return _root(at, slope, met=True, jumps=True)
        if value < 0.0:
            above = above * 0.5 if side < 0 else above
            low, below, side = at, value, -1
        else:
            below = below * 0.5 if side > 0 else below
            high, above, side = at, value, 1
        if at == (box[1] if value < 0.0 else box[0]):
            return _root(at, slope, met=False)
        if np.isnan(below) or np.isnan(above):
            tried = at - value / slope if slope > 0.0 else (high if value < 0.0 else low)
            tried = min(max(tried, low), high)
        else:
            tried = low + (high - low) * min(max(below / (below - above), 0.05), 0.95)
        (place, found) = _nearest(function, np.array([tried]), np.array([at]))
        if found is None or place[0] == at:
            return None
        rise = (float(found[0]) - value) / (float(place[0]) - at)
        slope = rise if rise > 0.0 else slope
        at, value = float(place[0]), float(found[0])
    return None


def _broyden(
    function: Function, at: FloatArray, value: FloatArray, slope: FloatArray, box: FloatArray, most: int
) -> Root | None:
    """Search a box of several unknowns."""
    reach, share = 0.5 * (box[1] - box[0]), 1.0
    last = at
    for _ in range(most):
        if np.abs(value).max() <= 1.0:
            if not np.array_equal(last, at):
                function(at)
            return Root(at=at, slope=slope, met=True)
        step = np.clip(-np.linalg.lstsq(slope, value, rcond=1e-12)[0], -reach, reach)
        tried = np.clip(at + share * step, *box)
        if np.all(np.abs(tried - at) <= NARROW * reach):
            if not np.array_equal(last, at):
                function(at)
            return Root(at=at, slope=slope, met=False)
        last, found = _nearest(function, tried, at)
        change = last - at
        if found is None or not change.any():
            return None
        slope = slope + np.outer(found - value - slope @ change, change) / float(change @ change)
        if np.linalg.norm(found) < np.linalg.norm(value):
            at, value, share = last, found, min(1.0, 2.0 * share)
        else:
            share *= 0.5
        if share < STALLED:
            slope, share = _measured(function, at, value, 1e-3 * reach, slope), 1.0
            last = np.full_like(at, np.nan)
    return None


def _measured(
    function: Function, at: FloatArray, value: FloatArray, steps: FloatArray, slope: FloatArray
) -> FloatArray:
    """Return the derivatives at a point by finite differences; where there are no values the old ones are kept."""
    measured = slope.copy()
    for number, part in enumerate(steps):
        moved = function(at + part * np.eye(len(at))[number])
        if moved is not None:
            measured[:, number] = (moved - value) / part
    return measured


def _root(at: float, slope: float, *, met: bool, jumps: bool = False) -> Root:
    """Return a root of one unknown."""
    return Root(at=np.array([at]), slope=np.array([[slope]]), met=met, jumps=jumps)

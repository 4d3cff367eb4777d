"""Where along a loading something sets in: the strain of half its rise, and the toe of a curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from rigs.axes import FloatArray

TOE: Final = 0.05
"""Share of the largest stress at which a toe ends [1]."""


def first_reached(x: FloatArray, y: FloatArray, level: float) -> float:
    """Return the x at which y first gets to a level, linearly between rows; ``nan`` where it never does.

    Parameters
    ----------
    x, y : FloatArray, shape (n,)
        A loading branch, in the order of time.
    level : float
        In the unit of y.
    """
    over = np.flatnonzero(y >= level)
    if not len(over):
        return float("nan")
    row = int(over[0])
    if row == 0:
        return float(x[0])
    share = (level - float(y[row - 1])) / float(y[row] - y[row - 1])
    return float(x[row - 1]) + share * float(x[row] - x[row - 1])


def half_rise(x: FloatArray, y: FloatArray) -> float:
    """Return the x at which y has done half of its rise from the first row to the last; ``nan`` if it does not rise.

    Quantities of any units are put in an order by it: what rises early along a loading, and what late. The half of a
    rise is less sensitive to noise and to a slow beginning than a first sign of it (as the half time of a relaxation).

    Parameters
    ----------
    x, y : FloatArray, shape (n,)
        A loading branch, in the order of time.
    """
    if len(y) < 2 or y[-1] <= y[0]:
        return float("nan")
    return first_reached(x, y, 0.5 * float(y[0] + y[-1]))


def toe(strain: FloatArray, stress: FloatArray, stress_at_end: float, share: float = TOE) -> float:
    """Return the strain at which a loading first carries a share of a stress: the length of its slack [1].

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch [1], [Pa].
    stress_at_end : float
        The stress of which it is a share [Pa]; the same for all loadings that are compared.
    share : float
        The share [1].
    """
    return first_reached(strain, stress, share * stress_at_end)

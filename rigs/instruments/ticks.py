"""The ticks of an instrument's clock at which it logs, part by part, so that a long log needs no more memory."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigs.axes import FloatArray

PART: Final = 16_384
"""Samples that are held at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """Stretch of a test that is logged at one rate, from where the stretch before ends.

    Attributes
    ----------
    end : float
        Its last moment on the rig's clock [s]; the first one belongs to the stretch before.
    rate : float
        Rate of the log [Hz]; 0 where nothing is logged.
    """

    end: float
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ticks:
    """A part of the ticks of a clock.

    Attributes
    ----------
    time : FloatArray, shape (n,)
        Times on the rig's clock [s].
    step : float
        Time between two of them [s]; 0 where the stretch has but one.
    """

    time: FloatArray
    step: float


def ticks(start: float, stretches: Sequence[Stretch], *, skew: float = 0.0, most: int = PART) -> Iterator[Ticks]:
    """Yield the ticks of a clock, at most so many at a time.

    Whatever the rate, ticks are counted from the start: those at 100 Hz are also those at 10 Hz.

    Parameters
    ----------
    start : float
        The first tick [s].
    stretches : sequence of Stretch
        The stretches in order; the first has the start.
    skew : float
        How much faster than the rig's clock the clock runs [1].
    most : int
        Ticks at a time.
    """
    first_left = True
    begin = start
    for stretch in stretches:
        if stretch.rate > 0.0:
            rate = stretch.rate * (1.0 + skew)
            first = 0 if first_left else _count(begin - start, rate) + 1
            last = _count(stretch.end - start, rate)
            step = _time(start, first + 1, rate) - _time(start, first, rate) if last > first else 0.0
            for low in range(first, last + 1, most):
                count = min(most, last + 1 - low)
                yield Ticks(time=start + np.arange(low, low + count) / rate, step=step)
        first_left, begin = False, max(begin, stretch.end)


def _count(span: float, rate: float) -> int:
    """Return the number of the last tick in a span [s] of time, the one at its beginning being 0."""
    return floor(span * rate * (1.0 + 1e-15) + 1e-9)


def _time(start: float, number: int, rate: float) -> float:
    return start + number / rate

"""Relaxation of stress at a constant strain, and creep at a constant stress."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.analysis.regression import fit_line, window

if TYPE_CHECKING:
    from rigs.axes import FloatArray

STEADY: Final = 0.5
"""A hold is one of stress, and the specimen creeps, where the share by which stress changes is below this part of the
share by which strain does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """What a value did while the other was held.

    Attributes
    ----------
    start, end : float
        Value as the hold began and ended: stress [Pa] that relaxes, or strain [1] that creeps.
    duration : float
        Time between both [s].
    change : float
        (end - start) / start [1]: minus the share of the stress that relaxed, or creep over the strain at the start.
    per_decade, per_decade_low, per_decade_high : float
        Slope of the value over log₁₀ of the time since the start, by least squares, and its confidence interval
        [unit of the value].
    r2 : float
        R² of that line.
    final_rate : float
        Slope over time in the last half of the hold, by least squares [unit of the value per s].
    half_time : float
        Time by which half of the change had happened [s].
    """

    start: float
    end: float
    duration: float
    change: float
    per_decade: float
    per_decade_low: float
    per_decade_high: float
    r2: float
    final_rate: float
    half_time: float


def hold_figures(time: FloatArray, value: FloatArray) -> Hold:
    """Work out how a value changed during a hold.

    The figures of ASTM E328 (stress relaxation: initial and remaining stress, stress against the logarithm of time) and
    of ISO 899-1 (tensile creep: strain against the logarithm of time).

    Parameters
    ----------
    time, value : FloatArray, shape (n,)
        The hold, two rows or more, with the row it sets out from: time [s], and stress [Pa] or strain [1].
    """
    since = time - time[0]
    later = since > 0.0
    line = fit_line(np.log10(since[later]), value[later])
    start, end = float(value[0]), float(value[-1])
    done = (value - start) / (end - start) if end != start else np.full(len(value), np.nan)
    passed = np.flatnonzero(done >= 0.5)
    return Hold(
        start=start,
        end=end,
        duration=float(since[-1]),
        change=(end - start) / start if start != 0.0 else float("nan"),
        per_decade=line.slope,
        per_decade_low=line.low,
        per_decade_high=line.high,
        r2=line.r2,
        final_rate=fit_line(*window(since, value, 0.5 * float(since[-1]), float(since[-1]))).slope,
        half_time=_crossing(since, done, int(passed[0])) if len(passed) else float("nan"),
    )


def _crossing(since: FloatArray, done: FloatArray, row: int) -> float:
    """Return the time at which a share done first reaches one half, linearly before a row."""
    if row == 0:
        return 0.0
    before, after = float(done[row - 1]), float(done[row])
    return float(since[row - 1] + (0.5 - before) / (after - before) * (since[row] - since[row - 1]))


def creeps(strain: FloatArray, stress: FloatArray) -> bool:
    """Return whether a hold kept the stress, so that the specimen crept, and not the strain."""
    moved, relaxed = (float(np.ptp(values) / max(np.abs(values).max(), 1e-300)) for values in (strain, stress))
    return relaxed < STEADY * moved

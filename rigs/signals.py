"""Do to a signal what a measuring chain does to it, in small functions of arrays.

References
----------
F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300: the shape-preserving cubic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.record import FloatArray, IntArray


def sample_times(start: float, end: float, rate: float) -> FloatArray:
    """Return the ticks of the clock from start to end, both counted when they are ticks.

    Parameters
    ----------
    start, end : float
        First tick and last moment [s].
    rate : float
        Ticks per second [Hz].

    Returns
    -------
    FloatArray, shape (n,)
        Times start + k / rate [s].

    Raises
    ------
    SpecificationError
        If the rate is not above 0.
    """
    if not rate > 0:
        raise SpecificationError("log.rate", rate, "a rate above 0 Hz")
    count = int(np.floor((end - start) * rate + 1e-9)) + 1
    return start + np.arange(count) / rate


def interpolate(time: FloatArray, values: FloatArray, stroke: IntArray, at: FloatArray) -> FloatArray:
    """Pass a shape-preserving cubic through the rows, stroke by stroke.

    The pieces meet at the turning points with a slope of their own on either side, so a peak is
    neither rounded nor overshot.

    Parameters
    ----------
    time, values : FloatArray, shape (n,)
        The rows; times [s] do not fall.
    stroke : IntArray, shape (n,)
        Stroke of every row; a stroke starts at the last row of the one before.
    at : FloatArray, shape (m,)
        Times to read at [s].

    Returns
    -------
    FloatArray, shape (m,)
        Values, in the unit of the rows.
    """
    from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 (11 MB that a test need not carry to its end)

    result = np.full(at.shape, values[0])
    for index in np.unique(stroke):
        rows = np.flatnonzero(stroke == index)
        first, last = max(rows[0] - 1, 0), rows[-1]
        inside = (at > time[first]) & (at <= time[last])
        # Of rows at the same time, a step of no duration, the last one counts.
        keep = np.append(np.diff(time[first : last + 1]) > 0, True)
        t, y = time[first : last + 1][keep], values[first : last + 1][keep]
        if inside.any() and len(t) > 1:
            result[inside] = PchipInterpolator(t, y)(at[inside])
    return result


def stamps(time: FloatArray, offset: float, skew: float) -> FloatArray:
    """Return what a clock shows at some true times: time (1 + skew) + offset [s]."""
    return time * (1.0 + skew) + offset


def true_times(stamped: FloatArray, offset: float, skew: float) -> FloatArray:
    """Return the true times at which a clock showed some stamps [s]; the inverse of `stamps`."""
    return (stamped - offset) / (1.0 + skew)


def lag(values: FloatArray, step: float, time_constant: float) -> FloatArray:
    """Pass a signal through a low-pass of first order, T y' + y = x, settled at the first sample.

    The recursion is the exact solution for an x that is straight between its samples::

        y[k+1] = a y[k] + (b - a) x[k] + (1 - b) x[k+1],  a = exp(-h/T),  b = (T/h) (1 - a)

    Parameters
    ----------
    values : FloatArray, shape (n,)
        Signal x at evenly spaced times [unit of the channel].
    step : float
        Time h between two samples [s].
    time_constant : float
        Time constant T [s]; 0 changes nothing.

    Returns
    -------
    FloatArray, shape (n,)
        Signal y [unit of the channel].
    """
    if not time_constant > 0.0:
        return values
    from scipy.signal import lfilter  # noqa: PLC0415 (as above)

    ratio = step / time_constant
    decay = np.exp(-ratio)
    share = -np.expm1(-ratio) / ratio
    # A settled past: at rest the filter's memory holds the first sample.
    memory = np.array([values[0] * share])
    filtered, _ = lfilter([1.0 - share, share - decay], [1.0, -decay], values, zi=memory)
    result: FloatArray = filtered
    return result


def drift(values: FloatArray, time: FloatArray, rate: float) -> FloatArray:
    """Add a zero that creeps away from the first sample on at a rate [unit of the channel / s]."""
    crept: FloatArray = values + rate * (time - time[0])
    return crept


def add_noise(values: FloatArray, deviation: float, *, seed: int, name: str) -> FloatArray:
    """Add white noise from the stream that belongs to this seed and this channel's name.

    Parameters
    ----------
    values : FloatArray, shape (n,)
        Signal [unit of the channel].
    deviation : float
        Standard deviation [unit of the channel].
    seed : int
        Seed of the run.
    name : str
        Name of the channel. Another channel more or less changes no stream.

    Returns
    -------
    FloatArray, shape (n,)
        Noisy signal [unit of the channel].
    """
    key = np.random.SeedSequence(entropy=seed, spawn_key=tuple(name.encode()))
    return values + deviation * np.random.default_rng(key).standard_normal(values.shape)


def quantise(values: FloatArray, resolution: float) -> FloatArray:
    """Round to whole steps of the resolution; a resolution of 0 changes nothing."""
    return np.round(values / resolution) * resolution if resolution > 0 else values


def saturate(values: FloatArray, limit: float) -> FloatArray:
    """Hold the values within plus and minus the limit."""
    return np.clip(values, -limit, limit)


def zero_offset(time: FloatArray, values: FloatArray, zeroed: Sequence[float]) -> FloatArray:
    """Return what zeroing takes off every reading: the one at the last zeroing before it.

    Parameters
    ----------
    time, values : FloatArray, shape (n,)
        Readings of one channel; times [s] do not fall.
    zeroed : sequence of float
        Times at which the channel was zeroed, rising [s].

    Returns
    -------
    FloatArray, shape (n,)
        Offsets [unit of the channel], 0 before the first zeroing.
    """
    offset = np.zeros_like(values)
    for moment in zeroed:
        # Of rows at that moment the last one counts: those before it still belong to the stroke that led there.
        at_or_after, beyond = np.searchsorted(time, [moment - 1e-9, moment + 1e-9])
        first = max(int(at_or_after), int(beyond) - 1)
        if first < len(time):
            offset[first:] = values[first]
    return offset

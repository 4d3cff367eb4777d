"""Do to a signal what a measuring chain does to it, in small functions of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigs.instruments.pchip import Pchip
from rigs.jumps import pieces

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray, IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """Shape-preserving cubics through rows, one for each stroke and from jump to jump.

    The pieces meet at the turning points with a slope of their own on either side, so a peak is neither rounded nor
    overshot. Rows at one time are a jump: the curve goes up to the first of them and on from the last. Beyond the last
    row all stays as it was left.

    Attributes
    ----------
    first, last : float
        Values of the first and the last row [unit of the rows].
    end : float
        Time of the last row [s].
    torn : bool
        Whether the last row comes right after a jump.
    ends : FloatArray, shape (k,)
        Times at which the pieces end [s]; a piece has its end, not its beginning.
    begins : FloatArray, shape (k,)
        Times at which they begin [s].
    cubics : tuple of Pchip
        The pieces.
    """

    first: float
    last: float
    end: float
    torn: bool
    begins: FloatArray
    ends: FloatArray
    cubics: tuple[Pchip, ...]

    @classmethod
    def through(cls, time: FloatArray, values: FloatArray, stroke: IntArray) -> Curve:
        """Return the curve through rows.

        Parameters
        ----------
        time, values : FloatArray, shape (n,)
            The rows; times [s] do not fall.
        stroke : IntArray, shape (n,)
            Stroke of every row; a stroke starts at the last row of the one before.
        """
        rows = pieces(time, stroke)
        return cls(
            first=float(values[0]),
            last=float(values[-1]),
            end=float(time[-1]),
            torn=len(time) > 1 and bool(time[-1] <= time[-2]),
            begins=np.array([time[begin] for begin, _ in rows], dtype=np.float64),
            ends=np.array([time[end] for _, end in rows], dtype=np.float64),
            cubics=tuple(Pchip.through(time[b : e + 1], values[b : e + 1]) for b, e in rows),
        )

    def __call__(self, at: FloatArray) -> FloatArray:
        """Return the values, (m,), at some times [s], (m,)."""
        result = np.full(at.shape, self.first)
        if not self.cubics:
            return result
        piece = np.minimum(np.searchsorted(self.ends, at, side="left"), len(self.cubics) - 1)
        within = np.minimum(at, self.end)
        for number in np.unique(piece):
            inside = (piece == number) & (within > self.begins[number])
            if inside.any():
                result[inside] = self.cubics[number](within[inside])
        if self.torn:
            result[at > self.end] = self.last
        return result


def stamps(time: FloatArray, offset: float, skew: float) -> FloatArray:
    """Return what a clock shows at some true times: time (1 + skew) + offset [s]."""
    return time * (1.0 + skew) + offset


def true_times(stamped: FloatArray, offset: float, skew: float) -> FloatArray:
    """Return the true times at which a clock showed some stamps [s]; the inverse of `stamps`."""
    return (stamped - offset) / (1.0 + skew)


@dataclass(slots=True, kw_only=True)
class Lag:
    """Low-pass of first order, T y' + y = x, settled at the first sample, that goes on from part to part of a signal.

    The recursion is the exact solution for an x that is straight between its samples::

        y[k+1] = a y[k] + (b - a) x[k] + (1 - b) x[k+1],  a = exp(-h/T),  b = (T/h) (1 - a)

    Attributes
    ----------
    time_constant : float
        Time constant T [s]; 0 changes nothing.
    """

    time_constant: float
    _step: float | None = None
    _memory: float = 0.0
    _last: tuple[float, float] | None = None

    def __call__(self, values: FloatArray, step: float, gap: float) -> FloatArray:
        """Return the signal y, (n,), of the next part of the signal x.

        Parameters
        ----------
        values : FloatArray, shape (n,)
            Signal x at evenly spaced times [unit of the channel].
        step : float
            Time h between two samples [s].
        gap : float
            Time between the last sample of the part before and the first of this one [s].
        """
        if not self.time_constant > 0.0 or not step > 0.0:
            return values
        decay, share = _decay(step, self.time_constant)
        if self._last is None:
            # A settled past: at rest the filter's memory holds the first sample.
            memory = float(values[0]) * share
        elif step == self._step:
            memory = self._memory
        else:
            before, shown = self._last
            slower, less = _decay(gap, self.time_constant)
            first = slower * shown + (less - slower) * before + (1.0 - less) * float(values[0])
            memory = first - (1.0 - share) * float(values[0])
        filtered, self._memory = _recursion(values, 1.0 - share, share - decay, decay, memory)
        self._step, self._last = step, (float(values[-1]), float(filtered[-1]))
        return filtered


def _recursion(x: FloatArray, direct: float, carried: float, decay: float, memory: float) -> tuple[FloatArray, float]:
    """Return y[k] = direct x[k] + memory, where memory is carried x[k-1] + decay y[k-1], and the memory at the end."""
    y = []
    # Plain floats: the loop takes 0.1 µs a sample, and nothing has to be loaded for it.
    for now, later in zip((direct * x).tolist(), (carried * x).tolist(), strict=True):
        shown = now + memory
        memory = later + decay * shown
        y.append(shown)
    return np.array(y, dtype=np.float64), memory


def _decay(step: float, time_constant: float) -> tuple[float, float]:
    """Return a and b of the recursion of `Lag` [1]."""
    ratio = step / time_constant
    return float(np.exp(-ratio)), float(-np.expm1(-ratio) / ratio)


def drift(values: FloatArray, time: FloatArray, rate: float, since: float) -> FloatArray:
    """Add a zero that creeps away from a time [s] on at a rate [unit of the channel / s]."""
    crept: FloatArray = values + rate * (time - since)
    return crept


def noise_stream(*, seed: int, name: str) -> np.random.Generator:
    """Return the stream of noise that belongs to this seed and this channel's name.

    Another channel more or less changes no stream, and it gives the same numbers however many are drawn at a time.
    """
    return np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=tuple(name.encode())))


def add_noise(values: FloatArray, deviation: float, stream: np.random.Generator) -> FloatArray:
    """Add white noise of a standard deviation [unit of the channel] from a stream."""
    return values + deviation * stream.standard_normal(values.shape)


def quantise(values: FloatArray, resolution: float) -> FloatArray:
    """Round to whole steps of the resolution; a resolution of 0 changes nothing."""
    return np.round(values / resolution) * resolution if resolution > 0 else values


def saturate(values: FloatArray, limit: float) -> FloatArray:
    """Clip the values at plus and minus the limit."""
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
        first = first_zeroed(time, moment)
        if first < len(time):
            offset[first:] = values[first]
    return offset


def first_zeroed(time: FloatArray, moment: float) -> int:
    """Return the first of some readings, at times (n,) that do not fall [s], that a zero at a moment [s] counts for.

    Of readings at that moment the last one counts: those before it still belong to the stroke that led there.
    """
    at_or_after, beyond = np.searchsorted(time, [moment - 1e-9, moment + 1e-9])
    return max(int(at_or_after), int(beyond) - 1)


@dataclass(slots=True, kw_only=True)
class Offset:
    """What zeroing takes off the samples of a channel, part by part; see `zero_offset`.

    Attributes
    ----------
    zeroed : tuple of float
        Times at which the channel will be zeroed, rising [s].
    now : float
        What the last zeroing took off [unit of the channel].
    """

    zeroed: tuple[float, ...]
    now: float = 0.0

    def next(self, time: FloatArray, values: FloatArray) -> FloatArray:
        """Return the offsets of the next samples, (n,), at their times [s], (n,)."""
        offset = np.full_like(values, self.now)
        while self.zeroed and time.size and self.zeroed[0] <= time[-1] + 1e-9:
            first = int(np.searchsorted(time, self.zeroed[0] - 1e-9))
            self.now, self.zeroed = float(values[first]), self.zeroed[1:]
            offset[first:] = self.now
        return offset

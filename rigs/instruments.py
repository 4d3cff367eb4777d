"""Read the equilibria as instruments do: at their own clock, with noise, in steps, up to a limit.

The chain of one channel is made of the functions of `rigs.signals`::

    interpolate -> lag -> drift -> add_noise -> quantise -> saturate -> zero

It is sampled at the ticks of its instrument's own clock, which may be set late and run fast.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.signals import (
    add_noise,
    drift,
    interpolate,
    lag,
    quantise,
    sample_times,
    saturate,
    stamps,
    true_times,
    zero_offset,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.record import Equilibrium, FloatArray, IntArray, Phase, Trace
    from rigs.steps import Channel as Kind


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """Describe a channel apart from its values.

    Attributes
    ----------
    name : str
        Name in the log, ``XForce``; it also keys the channel's stream of noise.
    reads : str
        Column of the equilibria that the sensor feels, ``force_C``.
    kind : Kind
        What ``zero`` calls it in a protocol.
    unit : str
        SI unit of its values.
    limit : float
        Largest magnitude it can show [unit].
    noise : float
        Standard deviation of its white noise [unit].
    resolution : float
        Step of its smallest digit [unit]; 0 for none.
    lag : float
        Time constant of its low-pass of first order [s].
    drift : float
        Rate at which its zero creeps [unit/s].
    delay : float
        How long after a tick of the instrument's clock it is read [s].
    """

    name: str
    reads: str
    kind: Kind
    unit: str
    limit: float
    noise: float
    resolution: float
    lag: float = 0.0
    drift: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Instrument:
    """Hold the channels that share one clock.

    Attributes
    ----------
    name : str
        Name of the machine that it is part of.
    channels : tuple of Channel
        The channels, in the order of the log.
    rate : float
        Samples per second of its clock [Hz].
    offset : float
        What its clock shows when the rig's clock starts [s].
    skew : float
        How much faster than the rig's clock it runs [1].
    lead : float
        How long it logs the knit at rest before the test starts [s].
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float
    offset: float = 0.0
    skew: float = 0.0
    lead: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Zeroing:
    """Say when the channels of some kinds were set to zero.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    kinds : frozenset of Kind
        Kinds of the channels that were zeroed.
    """

    time: float
    kinds: frozenset[Kind]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """Hold what an instrument logged, and what it would have logged without flaw.

    Attributes
    ----------
    instrument : str
        Name of the instrument.
    time : FloatArray, shape (n,)
        Stamps of the instrument's own clock [s].
    measured, clean : dict of str to FloatArray, shape (n,)
        Values by the channel's name, in its SI unit.
    offset : dict of str to FloatArray, shape (n,)
        What zeroing took off ``measured``.
    units : dict of str to str
        The units of both.
    reads : dict of str to str
        Column of the equilibria that each channel reads.
    cycle : IntArray, shape (n,)
        Counter of the set at every sample.
    phase : tuple of Phase
        Phase at every sample.
    tag : tuple of (str or None)
        Label at every sample.
    overloads : tuple of str
        Names of the channels that were saturated at least once.
    clock_offset, clock_skew : float
        What the instrument's clock shows at the start of the rig's [s], and how much faster it runs [1].
    delay : dict of str to float
        How long after the stamp the channels were read that are read late [s].
    """

    instrument: str
    time: FloatArray
    measured: dict[str, FloatArray]
    clean: dict[str, FloatArray]
    offset: dict[str, FloatArray]
    units: dict[str, str]
    reads: dict[str, str]
    cycle: IntArray
    phase: tuple[Phase, ...]
    tag: tuple[str | None, ...]
    overloads: tuple[str, ...]
    clock_offset: float = 0.0
    clock_skew: float = 0.0
    delay: dict[str, float] = field(default_factory=dict)

    @property
    def true_time(self) -> FloatArray:
        """Return the stamps as times on the rig's clock [s], shape (n,)."""
        return true_times(self.time, self.clock_offset, self.clock_skew)


def overloaded(instrument: Instrument, row: Equilibrium) -> Channel | None:
    """Return the first channel whose sensor feels more than it can show, or None."""
    felt = row.numbers()
    for channel in instrument.channels:
        if abs(felt[channel.reads]) > channel.limit:
            return channel
    return None


def _shown(channel: Channel, felt: FloatArray, at: FloatArray, seed: int) -> FloatArray:
    """Return what a channel without a limit would show: late, creeping, noisy, in whole digits."""
    step = float(at[1] - at[0]) if len(at) > 1 else 0.0
    late = lag(felt, step, channel.lag) if step else felt
    noisy = add_noise(drift(late, at, channel.drift), channel.noise, seed=seed, name=channel.name)
    return quantise(noisy, channel.resolution)


def measure(
    instrument: Instrument, trace: Trace, *, seed: int, noise: bool = True, zeroings: Sequence[Zeroing] = ()
) -> Samples:
    """Log a run of equilibria with an instrument.

    Parameters
    ----------
    instrument : Instrument
        Its channels and clock.
    trace : Trace
        The equilibria, at least one row.
    seed : int
        Seed of the noise.
    noise : bool
        Whether ``measured`` passes through lag, drift, noise and quantisation; if not it equals ``clean``.
    zeroings : sequence of Zeroing
        When the channels were set to zero.

    Returns
    -------
    Samples
        One sample per tick of the instrument's clock from the first row, or its lead before it, to the last.

    Raises
    ------
    SpecificationError
        If there is no row to read.
    """
    if not len(trace):
        raise SpecificationError("equilibria", 0, "at least one row to sample")
    times, stroke = trace.columns["time"], trace.strokes()
    ticks = sample_times(times[0] - instrument.lead, times[-1], instrument.rate * (1.0 + instrument.skew))
    clean, measured, offset, overloads = {}, {}, {}, []
    for channel in instrument.channels:
        # Beyond the last row the knit rests as it was left there.
        at = np.minimum(ticks + channel.delay, times[-1])
        felt = interpolate(times, trace.columns[channel.reads], stroke, at)
        read = _shown(channel, felt, ticks, seed) if noise else felt
        held = saturate(read, channel.limit)
        if np.any(held != read):
            overloads.append(channel.name)
        # What is zeroed takes effect at the tick, however late the channel is read.
        zeroed = [zeroing.time for zeroing in zeroings if channel.kind in zeroing.kinds]
        clean[channel.name] = felt - zero_offset(ticks, felt, zeroed)
        offset[channel.name] = zero_offset(ticks, held, zeroed)
        measured[channel.name] = held - offset[channel.name]
    # The row that ends the interval of a sample names its stroke.
    row = np.minimum(np.searchsorted(times, ticks - 1e-9), len(trace) - 1)
    return Samples(
        instrument=instrument.name,
        time=stamps(ticks, instrument.offset, instrument.skew),
        measured=measured,
        clean=clean,
        offset=offset,
        units={channel.name: channel.unit for channel in instrument.channels},
        reads={channel.name: channel.reads for channel in instrument.channels},
        cycle=trace.columns["cycle"][row].astype(np.int64),
        phase=tuple(trace.phase[i] for i in row),
        tag=tuple(trace.tag[i] for i in row),
        overloads=tuple(overloads),
        clock_offset=instrument.offset,
        clock_skew=instrument.skew,
        delay={channel.name: channel.delay for channel in instrument.channels if channel.delay > 0.0},
    )

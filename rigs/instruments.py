"""Read the equilibria as instruments do: at their own clock, with noise, in steps, up to a limit.

The chain of one channel is made of the functions of `rigs.signals`::

    interpolate -> add_noise -> quantise -> saturate -> zero
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.signals import add_noise, interpolate, quantise, sample_times, saturate, zero_offset

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
    """

    name: str
    reads: str
    kind: Kind
    unit: str
    limit: float
    noise: float
    resolution: float


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
        Samples per second of the clock [Hz].
    """

    name: str
    channels: tuple[Channel, ...]
    rate: float


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
        Sample times [s].
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


def overloaded(instrument: Instrument, row: Equilibrium) -> Channel | None:
    """Return the first channel whose sensor feels more than it can show, or None."""
    felt = row.numbers()
    for channel in instrument.channels:
        if abs(felt[channel.reads]) > channel.limit:
            return channel
    return None


def _shown(channel: Channel, felt: FloatArray, seed: int) -> FloatArray:
    """Return what a channel without a limit would show: noise, and whole digits."""
    return quantise(add_noise(felt, channel.noise, seed=seed, name=channel.name), channel.resolution)


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
        Whether ``measured`` passes through noise and quantisation; if not it equals ``clean``.
    zeroings : sequence of Zeroing
        When the channels were set to zero.

    Returns
    -------
    Samples
        One sample per tick from the first row to the last.

    Raises
    ------
    SpecificationError
        If there is no row to read.
    """
    if not len(trace):
        raise SpecificationError("equilibria", 0, "at least one row to sample")
    times, stroke = trace.columns["time"], trace.strokes()
    at = sample_times(times[0], times[-1], instrument.rate)
    clean, measured, offset, overloads = {}, {}, {}, []
    for channel in instrument.channels:
        felt = interpolate(times, trace.columns[channel.reads], stroke, at)
        read = _shown(channel, felt, seed) if noise else felt
        held = saturate(read, channel.limit)
        if np.any(held != read):
            overloads.append(channel.name)
        zeroed = [zeroing.time for zeroing in zeroings if channel.kind in zeroing.kinds]
        clean[channel.name] = felt - zero_offset(at, felt, zeroed)
        offset[channel.name] = zero_offset(at, held, zeroed)
        measured[channel.name] = held - offset[channel.name]
    # The row that ends the interval of a sample names its stroke.
    row = np.minimum(np.searchsorted(times, at - 1e-9), len(trace) - 1)
    return Samples(
        instrument=instrument.name,
        time=at,
        measured=measured,
        clean=clean,
        offset=offset,
        units={channel.name: channel.unit for channel in instrument.channels},
        reads={channel.name: channel.reads for channel in instrument.channels},
        cycle=trace.columns["cycle"][row].astype(np.int64),
        phase=tuple(trace.phase[i] for i in row),
        tag=tuple(trace.tag[i] for i in row),
        overloads=tuple(overloads),
    )

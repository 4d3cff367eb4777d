"""Read the equilibria as instruments do: at their own clock, with noise, in steps, up to a limit.

The chain of one channel is made of the functions of `rigs.instruments.signals`::

    interpolate -> lag -> drift -> add_noise -> quantise -> saturate -> zero

It is sampled at the ticks of its instrument's own clock, which may be set late and run fast.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.instruments.samples import Samples, merged
from rigs.instruments.signals import (
    Curve,
    Lag,
    Offset,
    add_noise,
    drift,
    noise_stream,
    quantise,
    saturate,
    stamps,
)
from rigs.instruments.ticks import PART, Stretch, ticks
from rigs.jumps import jump_times, jumped, parted

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigs.axes import FloatArray
    from rigs.instruments.ticks import Ticks
    from rigs.instruments.zeros import Zeroing
    from rigs.protocol.targets import Channel as Kind
    from rigs.record import Equilibrium
    from rigs.trace import Trace


EXTENSOMETER: Final = "Extensometer"
"""What the names of the channels begin with that read the distance of pins; the axis follows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """Channel apart from its values.

    Attributes
    ----------
    name : str
        Name in the log, ``XForce``; it also keys the channel's stream of noise.
    reads : str
        Column of the equilibria that the sensor feels, ``force_C``.
    kind : Kind or 'pins'
        What ``zero`` calls it in a protocol; the distance of pins is never zeroed.
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
    kind: Kind | Literal["pins"]
    unit: str
    limit: float
    noise: float
    resolution: float
    lag: float = 0.0
    drift: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Instrument:
    """An instrument: channels that share one clock.

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


def overloaded(instrument: Instrument, row: Equilibrium) -> Channel | None:
    """Return the first channel whose sensor feels more than it can show, or None."""
    felt = row.numbers()
    for channel in instrument.channels:
        if abs(felt[channel.reads]) > channel.limit:
            return channel
    return None


@dataclass(slots=True, kw_only=True)
class _Chain:
    """Do to a channel what its measuring chain does, part by part: late, creeping, noisy, in whole digits, zeroed.

    Attributes
    ----------
    channel : Channel
        The channel.
    curve : Curve
        What its sensor feels.
    since : float
        The first tick, from which on its zero creeps [s].
    stream : Generator or None
        Its noise; None for a chain without flaw.
    zeroed : tuple of float
        When it was zeroed [s].
    """

    channel: Channel
    curve: Curve
    since: float
    stream: np.random.Generator | None
    zeroed: tuple[float, ...]
    _lag: Lag = field(init=False)
    _offsets: tuple[Offset, Offset] = field(init=False)

    def __post_init__(self) -> None:
        self._lag = Lag(time_constant=self.channel.lag)
        self._offsets = Offset(zeroed=self.zeroed), Offset(zeroed=self.zeroed)

    def part(self, now: Ticks, gap: float) -> _Part:
        """Return what the channel shows at some ticks, so long after the last one [s]."""
        channel = self.channel
        felt = read = self.curve(now.time + channel.delay)
        if self.stream is not None:
            late = self._lag(felt, now.step or gap, gap)
            noisy = add_noise(drift(late, now.time, channel.drift, self.since), channel.noise, self.stream)
            read = quantise(noisy, channel.resolution)
        held = saturate(read, channel.limit)
        # What is zeroed takes effect at the tick, however late the channel is read.
        clean, shown = self._offsets
        offset = shown.next(now.time, held)
        return _Part(
            clean=felt - clean.next(now.time, felt),
            measured=held - offset,
            offset=offset,
            saturated=bool(np.any(held != read)),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Part:
    """A part of the values of a channel."""

    clean: FloatArray
    measured: FloatArray
    offset: FloatArray
    saturated: bool


def measure(
    instrument: Instrument,
    trace: Trace,
    *,
    seed: int,
    noise: bool = True,
    zeroings: Sequence[Zeroing] = (),
    stretches: Sequence[Stretch] | None = None,
) -> Samples:
    """Log a run of equilibria with an instrument; see `measured_parts`."""
    return merged(
        list(measured_parts(instrument, trace, seed=seed, noise=noise, zeroings=zeroings, stretches=stretches))
    )


def measured_parts(
    instrument: Instrument,
    trace: Trace,
    *,
    seed: int,
    noise: bool = True,
    zeroings: Sequence[Zeroing] = (),
    stretches: Sequence[Stretch] | None = None,
    most: int = PART,
) -> Iterator[Samples]:
    """Log a run of equilibria with an instrument, part by part; the parts are the same to the bit however long.

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
    stretches : sequence of Stretch or None
        At what rate which part of the test is logged; None for all of it at the instrument's.
    most : int
        Samples at a time.

    Yields
    ------
    Samples
        One sample per tick of the instrument's clock from the first row, or its lead before it, to the last; one more
        where the test ends with a jump.

    Raises
    ------
    SpecificationError
        If there is no row to read.
    """
    if not len(trace):
        raise SpecificationError("equilibria", 0, "at least one row to sample")
    jumps, whole = jump_times(trace), parted(trace)
    times, strokes = whole.columns["time"], whole.strokes()
    start = float(times[0]) - instrument.lead
    chains = {
        channel.name: _Chain(
            channel=channel,
            curve=Curve.through(times, whole.columns[channel.reads], strokes),
            since=start,
            stream=noise_stream(seed=seed, name=channel.name) if noise else None,
            zeroed=tuple(zeroing.time for zeroing in zeroings if channel.kind in zeroing.kinds),
        )
        for channel in instrument.channels
    }
    before = start
    wanted = [Stretch(end=float(times[-1]), rate=instrument.rate)] if stretches is None else list(stretches)
    if wanted[-1].rate > 0.0 and jumped(trace)[-1]:
        # An instrument whose test ends with a jump still sees it.
        wanted[-1] = replace(wanted[-1], end=wanted[-1].end + 1.0 / (wanted[-1].rate * (1.0 + instrument.skew)))
    for now in ticks(start, wanted, skew=instrument.skew, most=most):
        parts = {name: chain.part(now, float(now.time[0]) - before) for name, chain in chains.items()}
        before = float(now.time[-1])
        yield _samples(instrument, trace, now.time, parts, jumps)


def _samples(
    instrument: Instrument, trace: Trace, at: FloatArray, parts: Mapping[str, _Part], jumps: FloatArray
) -> Samples:
    """Return the samples of all channels at some ticks."""
    # The row that ends the interval of a sample names its stroke.
    row = np.minimum(np.searchsorted(trace.columns["time"], at - 1e-9), len(trace) - 1)
    return Samples(
        instrument=instrument.name,
        time=stamps(at, instrument.offset, instrument.skew),
        measured={name: part.measured for name, part in parts.items()},
        clean={name: part.clean for name, part in parts.items()},
        offset={name: part.offset for name, part in parts.items()},
        units={channel.name: channel.unit for channel in instrument.channels},
        reads={channel.name: channel.reads for channel in instrument.channels},
        cycle=trace.columns["cycle"][row].astype(np.int64),
        phase=tuple(trace.phase[i] for i in row),
        tag=tuple(trace.tag[i] for i in row),
        overloads=tuple(name for name, part in parts.items() if part.saturated),
        clock_offset=instrument.offset,
        clock_skew=instrument.skew,
        delay={channel.name: channel.delay for channel in instrument.channels if channel.delay > 0.0},
        jumps=jumps,
    )

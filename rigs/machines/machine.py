"""Data of a machine, each number with its source, and the instruments that read it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from rigs.instruments.channels import EXTENSOMETER, Channel, Instrument
from rigs.machines.catalogue import machine_named

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigs.axes import Axis
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.protocol import LogSpec, Protocol
    from rigs.protocol.targets import Channel as Kind

REFERENCE: Final[MachineName] = "uniaxial-frame"
"""The machine whose clock is the rig's where there are two."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Datum:
    """A number with its source, or marked as assumed.

    Attributes
    ----------
    value : float
        The number [unit].
    unit : str
        SI unit.
    source : str
        Where it comes from.
    assumed : bool
        Whether it is a guess.
    """

    value: float
    unit: str
    source: str
    assumed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """Drive of a pair of carriages: default and largest speed [m/s], travel [m], compliance [m/N].

    The smallest speed [m/s] and the force it can bear [N] are None where nothing is known of such a limit; the gap [m]
    that a gripper crosses before it takes hold of its specimen is None where none is left.
    """

    speed: Datum
    max_speed: Datum
    travel: Datum
    compliance: Datum
    min_speed: Datum | None = None
    capacity: Datum | None = None
    gap: Datum | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Pole:
    """Pole along which hooks slide: friction coefficient [1]."""

    friction: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """Load cell or encoder: limit, noise (standard deviation), resolution [N or m].

    Time constant of its low-pass [s], creep of its zero [N/s or m/s] and delay after the clock's tick [s] are None
    where it has none. Its accuracy, a share of the reading [1] or a length [m], is None where none is known; it is
    not simulated.
    """

    limit: Datum
    noise: Datum
    resolution: Datum
    lag: Datum | None = None
    drift: Datum | None = None
    delay: Datum | None = None
    accuracy: Datum | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Clock of a machine: default and largest rate of the log [Hz], offset and skew against another machine's.

    Offset [s] and skew [1] count where the machine stands beside one that keeps the time (`REFERENCE`). The lead is
    how long the log begins before the test [s]. Each is None where there is none.
    """

    rate: Datum
    max_rate: Datum
    offset: Datum | None = None
    skew: Datum | None = None
    lead: Datum | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Convention:
    """Conventions, not measurements: thickness [m] and room temperature [°C]."""

    thickness: Datum
    temperature: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineData:
    """All data of a machine.

    Attributes
    ----------
    rig : str
        Name of the machine.
    carriage, load_cell, encoder, clock, convention : dataclass
        The parts.
    pole : Pole or None
        None of a machine without hooks.
    other_cells : tuple of Sensor
        Load cells that can be fitted in the place of ``load_cell``.
    extensometer : Sensor or None
        Reads the distance of pins in the fabric [m]; None of a machine that has none.
    """

    rig: str
    carriage: Carriage
    load_cell: Sensor
    encoder: Sensor
    clock: Clock
    convention: Convention
    pole: Pole | None = None
    other_cells: tuple[Sensor, ...] = ()
    extensometer: Sensor | None = None

    @property
    def cells(self) -> tuple[Sensor, ...]:
        """Return every load cell that can be fitted, first the one it comes with."""
        return (self.load_cell, *self.other_cells)

    def fitted(self, capacity: float) -> MachineData | None:
        """Return the machine with the load cell of a capacity [N] and no other at hand; None if it has no such cell."""
        for cell in self.cells:
            if cell.limit.value == capacity:
                return replace(self, load_cell=cell, other_cells=())
        return None


def instruments_on(protocol: Protocol, data: Mapping[MachineName, MachineData]) -> tuple[Instrument, ...]:
    """Return the instruments of the machines of a protocol's rig."""
    driven = {name: [axis for axis, drive in protocol.drives.items() if drive.machine == name] for name in data}
    made = instruments_of(driven, data, protocol.log)
    return tuple(replace(one, channels=(*one.channels, *_pin_channels(one, protocol, data))) for one in made)


def pinned(protocol: Protocol) -> dict[MachineName, list[Axis]]:
    """Return which pairs of pins each machine of a protocol's rig reads.

    Those along the axes that it drives; the first one also those along axes that nothing drives.
    """
    drives = protocol.drives
    first = next(iter(drives.values())).machine
    found: dict[MachineName, list[Axis]] = {drive.machine: [] for drive in drives.values()}
    for axis in protocol.extensometer.pairs if protocol.extensometer is not None else ():
        found[drives[axis].machine if axis in drives else first].append(axis)
    return found


def _pin_channels(
    instrument: Instrument, protocol: Protocol, data: Mapping[MachineName, MachineData]
) -> Iterator[Channel]:
    """Yield the extensometer's channels of an instrument: the distances of pins, which no zero changes."""
    sensor = data[instrument.name].extensometer
    if sensor is None:
        return
    for axis in pinned(protocol)[instrument.name]:
        yield Channel(
            name=f"{EXTENSOMETER}{axis}",
            reads=f"pin_distance_{axis}",
            kind="pins",
            unit="m",
            limit=sensor.limit.value,
            noise=sensor.noise.value,
            resolution=sensor.resolution.value,
            lag=_value(sensor.lag),
            drift=_value(sensor.drift),
            delay=_value(sensor.delay),
        )


def instruments_of(
    driven: Mapping[MachineName, Sequence[Axis]], data: Mapping[MachineName, MachineData], log: LogSpec
) -> tuple[Instrument, ...]:
    """Return the instruments of a rig: the channels of each machine on its clock.

    Parameters
    ----------
    driven : Mapping
        The axes that each machine drives.
    data : Mapping
        Their numbers.
    log : LogSpec
        The rate, and what the protocol says of clocks in place of the numbers.

    Returns
    -------
    tuple of Instrument
        One for each machine.
    """
    made = []
    for machine, axes in driven.items():
        own = instrument_of(machine, data[machine], axes, log.rate)
        if len(driven) > 1 and machine != REFERENCE:
            clock = data[machine].clock
            own = replace(
                own,
                offset=_value(clock.offset) if log.clock_offset is None else log.clock_offset,
                skew=_value(clock.skew) if log.clock_skew is None else log.clock_skew,
            )
        made.append(own)
    return tuple(made)


def instrument_of(machine: MachineName, data: MachineData, axes: Sequence[Axis], rate: float) -> Instrument:
    """Return the channels of a machine on a clock without offset or skew.

    Parameters
    ----------
    machine : MachineName
        The machine.
    data : MachineData
        Its numbers.
    axes : sequence of Axis
        The axes that it drives.
    rate : float
        Rate of its log [Hz].

    Returns
    -------
    Instrument
        Displacements, then forces.
    """
    parts: tuple[tuple[Kind, Sensor, str], ...] = (
        ("displacement", data.encoder, "m"),
        ("force", data.load_cell, "N"),
    )
    prefixes = machine_named(machine).channels
    channels = tuple(
        Channel(
            name=f"{prefixes[axis]}{kind.capitalize()}",
            # An encoder sees the crosshead, not the specimen's fixture.
            reads=f"{'crosshead' if kind == 'displacement' else kind}_{axis}",
            kind=kind,
            unit=unit,
            limit=_limit(data, sensor),
            noise=sensor.noise.value,
            resolution=sensor.resolution.value,
            lag=_value(sensor.lag),
            drift=_value(sensor.drift),
            delay=_value(sensor.delay),
        )
        for kind, sensor, unit in parts
        for axis in axes
    )
    return Instrument(name=machine, channels=channels, rate=rate, lead=_value(data.clock.lead))


def _value(datum: Datum | None) -> float:
    return 0.0 if datum is None else datum.value


def _limit(data: MachineData, sensor: Sensor) -> float:
    """Return the largest reading of a sensor: a load cell's frame may bear less than the cell."""
    bears = data.carriage.capacity
    if sensor is data.load_cell and bears is not None:
        return min(sensor.limit.value, bears.value)
    return sensor.limit.value

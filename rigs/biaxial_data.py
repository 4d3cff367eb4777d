"""Hold the numbers of the biaxial stage, each with its source."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigs.instruments import Channel, Instrument

if TYPE_CHECKING:
    from rigs.protocol import Channel as Kind


@dataclass(frozen=True, slots=True, kw_only=True)
class Datum:
    """Hold a number that was looked up or guessed, and say which.

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
    """Hold the drive of a pair: default and largest speed [m/s], travel [m], compliance [m/N]."""

    speed: Datum
    max_speed: Datum
    travel: Datum
    compliance: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class Pole:
    """Hold the pole the hooks slide along: friction coefficient [1]."""

    friction: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """Hold a load cell or an encoder: limit, noise (standard deviation), resolution [N or m]."""

    limit: Datum
    noise: Datum
    resolution: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Hold the default and the largest rate of the log [Hz]."""

    rate: Datum
    max_rate: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class Convention:
    """Hold what is agreed, not measured: thickness [m] and room temperature [°C]."""

    thickness: Datum
    temperature: Datum


@dataclass(frozen=True, slots=True, kw_only=True)
class BiaxialData:
    """Hold every number of the stage.

    Attributes
    ----------
    rig : str
        Name in protocols.
    carriage, pole, load_cell, encoder, clock, convention : dataclass
        The parts.
    """

    rig: str
    carriage: Carriage
    pole: Pole
    load_cell: Sensor
    encoder: Sensor
    clock: Clock
    convention: Convention


def stage_instrument(data: BiaxialData, rate: float | None = None) -> Instrument:
    """Put the stage's four channels on its clock: x is the course, y the wale.

    Parameters
    ----------
    data : BiaxialData
        The stage's numbers.
    rate : float or None
        Rate the protocol asks for [Hz]; None for the stage's own.

    Returns
    -------
    Instrument
        Displacements, then forces.
    """
    parts: tuple[tuple[Kind, Sensor, str], ...] = (
        ("displacement", data.encoder, "m"),
        ("force", data.load_cell, "N"),
    )
    channels = tuple(
        Channel(
            name=f"{letter}{kind.capitalize()}",
            reads=f"{kind}_{axis}",
            kind=kind,
            unit=unit,
            limit=sensor.limit.value,
            noise=sensor.noise.value,
            resolution=sensor.resolution.value,
        )
        for kind, sensor, unit in parts
        for letter, axis in (("X", "C"), ("Y", "W"))
    )
    return Instrument(channels=channels, rate=data.clock.rate.value if rate is None else rate)

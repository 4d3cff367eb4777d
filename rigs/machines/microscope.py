"""Data of a scanning electron microscope, each number with its source."""

from __future__ import annotations

from dataclasses import dataclass

from rigs.machines.machine import Datum  # noqa: TC001 (what reads the file asks for the types of the fields)


@dataclass(frozen=True, slots=True, kw_only=True)
class Microscope:
    """Data of a microscope: resolution, beam, detector, and the tags of its images.

    Attributes
    ----------
    microscope, serial, signal : str
        Its name, its serial number, and the detector that its image comes from.
    voltage : Datum
        Acceleration voltage [V].
    working_distance : Datum
        From the pole piece to the specimen [m].
    print_width : Datum
        Width of the print that magnifications are told for [m].
    grazing : Datum
        What bounds the yield of surfaces that the beam grazes [1].
    collector_pull, collector_azimuth : Datum
        How much more electrons count that leave towards the detector [1], and where in the image it stands [deg].
    stray : Datum
        Share of electrons that are collected from the ground of a gap [1].
    silicon_yield : Datum
        Yield of the fixtures over that of the specimen [1].
    dose : Datum
        Electrons counted a pixel [1].
    spot : Datum
        Standard deviation of the beam's spread [pixel].
    charging, charging_length : Datum
        Darkening of a line after bright yarn [1], and how far it reaches [pixel].
    line_noise : Datum
        Standard deviation of a line's level over full scale [1].
    """

    microscope: str
    serial: str
    signal: str
    voltage: Datum
    working_distance: Datum
    print_width: Datum
    grazing: Datum
    collector_pull: Datum
    collector_azimuth: Datum
    stray: Datum
    silicon_yield: Datum
    dose: Datum
    spot: Datum
    charging: Datum
    charging_length: Datum
    line_noise: Datum

"""Controller: its readings of the load cells, and what it keeps of them for the steps to come.

True forces are not available to the controller: its load cells are tared, noisy and saturated. It takes the
mean of the samples that the log's clock gave since the row before, or in the last second, whichever is longer, from
its own streams of noise; the scatter of this mean is the dead band, within which a force counts as met.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import copysign, sqrt
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.instruments.channels import Channel
    from rigs.machines.rig import Rig
    from rigs.protocol.strokes import History
    from rigs.record import Equilibrium

PEAK_OVER_NOISE: Final = 5.0
"""A peak counts only above so many times the noise, or the smallest digit, of its load cell."""


FILTER: Final = 1.0
"""Time over which the controller averages a load cell, at least [s]."""

DEAD_BAND: Final = 3.0
"""Standard deviations of that mean within which the controller takes a force for the one that was asked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """What the controller remembers, in plain numbers.

    Attributes
    ----------
    history : History
        What of the test so far matters to strokes to come.
    readings : int
        Readings of the load cells so far; the next has a draw of noise of its own.
    read_at : float
        Time of the last [s].
    tare : Mapping
        What the load cells showed when they were last zeroed [N].
    shown : Mapping
        What they show now, zeroed [N].
    since : float
        Time at which the step under way began [s].
    first, peak : Mapping
        What they showed then, and the most that they showed since [N].
    broken : int
        Fibres and fused points that are broken.
    broken_at_peak : Mapping
        How many were at that peak.
    every : float or None
        Time between pictures [s]; None where none fall due.
    image_since : float
        Time from which they are counted [s].
    image_tag : str or None
        The pictures' label.
    """

    history: History
    tare: Mapping[Axis, float]
    shown: Mapping[Axis, float]
    readings: int = 0
    read_at: float = 0.0
    since: float = 0.0
    first: Mapping[Axis, float]
    peak: Mapping[Axis, float]
    broken: int = 0
    broken_at_peak: Mapping[Axis, int] = field(default_factory=dict)
    every: float | None = None
    image_since: float = 0.0
    image_tag: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Load cell of the controller: its channel and the sampling rate of its clock [Hz]."""

    channel: Channel
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """Controller of a rig, which reads its load cells.

    Attributes
    ----------
    cells : Mapping
        The load cell of each axis.
    seed : int
        Seed of the noise.
    noise : bool
        Whether there is any.
    """

    cells: Mapping[Axis, Cell]
    seed: int
    noise: bool

    def begin(self, history: History) -> Memory:
        """Return the memory of a test that begins."""
        zeros = dict.fromkeys(self.cells, 0.0)
        return Memory(history=history, tare=zeros, shown=zeros, first=zeros, peak=zeros)

    def errors(self, memory: Memory, time: float) -> dict[Axis, float]:
        """Return what noise adds to the next reading, taken at a time [s], of each load cell [N]."""
        if not self.noise:
            return dict.fromkeys(self.cells, 0.0)
        found = {}
        for axis, cell in self.cells.items():
            key = (*f"controller {cell.channel.name}".encode(), memory.readings)
            draw = np.random.default_rng(np.random.SeedSequence(entropy=self.seed, spawn_key=key)).standard_normal()
            found[axis] = self._scatter(cell, memory, time) * float(draw)
        return found

    def dead_band(self, memory: Memory, time: float) -> dict[Axis, float]:
        """Return how far [N] the next reading, taken at a time [s], may be off before the controller acts on it."""
        return {
            axis: DEAD_BAND * self._scatter(cell, memory, time) if self.noise else 0.0
            for axis, cell in self.cells.items()
        }

    def acted_on(self, memory: Memory, time: float) -> dict[Axis, float]:
        """Return the part of the next reading's noise that is beyond the dead band, and moves the axis [N]."""
        band = self.dead_band(memory, time)
        errors = self.errors(memory, time)
        return {axis: copysign(max(abs(error) - band[axis], 0.0), error) for axis, error in errors.items()}

    def steady(self, force: Mapping[Axis, float], memory: Memory) -> dict[Axis, float]:
        """Return what the load cells show on average, zeroed, of true forces [N].

        A stroke starts from it: a controller that takes over moves nothing at once.
        """
        return {axis: force[axis] - tare for axis, tare in memory.tare.items()}

    def _scatter(self, cell: Cell, memory: Memory, time: float) -> float:
        """Return the standard deviation [N] of the mean that the controller takes at a time [s]."""
        samples = max(1.0, cell.rate * max(time - memory.read_at, FILTER))
        return cell.channel.noise / sqrt(samples)

    def shows(self, force: Mapping[Axis, float], memory: Memory, time: float) -> dict[Axis, float]:
        """Return what the load cells would show at a time [s], zeroed, of true forces [N]."""
        errors = self.errors(memory, time)
        return {
            axis: min(max(force[axis] + errors[axis], -cell.channel.limit), cell.channel.limit) - memory.tare[axis]
            for axis, cell in self.cells.items()
        }

    def read(self, memory: Memory, row: Equilibrium, broken: int) -> Memory:
        """Return the memory after a row was read at which so many fibres and fused points are broken."""
        shown = self.shows(row.force, memory, row.time)
        rose = {axis: force > memory.peak[axis] for axis, force in shown.items()}
        return replace(
            memory,
            shown=shown,
            peak={axis: shown[axis] if up else memory.peak[axis] for axis, up in rose.items()},
            broken=broken,
            broken_at_peak={axis: broken if up else memory.broken_at_peak.get(axis, 0) for axis, up in rose.items()},
            readings=memory.readings + 1,
            read_at=row.time,
        )

    def zero(self, memory: Memory) -> Memory:
        """Return the memory after the load cells were tared."""
        tare = {axis: memory.tare[axis] + shown for axis, shown in memory.shown.items()}
        return replace(memory, tare=tare, shown=dict.fromkeys(tare, 0.0))

    def start_step(self, memory: Memory, time: float) -> Memory:
        """Return the memory of a step that begins."""
        before = dict.fromkeys(memory.shown, memory.broken)
        return replace(memory, since=time, first=memory.shown, peak=memory.shown, broken_at_peak=before)

    def counts(self, axis: Axis, peak: float) -> bool:
        """Return whether a peak is above the noise of its load cell."""
        channel = self.cells[axis].channel
        return peak > PEAK_OVER_NOISE * max(channel.noise, channel.resolution)


def controller_of(rig: Rig, *, seed: int, noise: bool) -> Controller:
    """Return the controller of a rig."""
    cells = {
        axis: Cell(channel=channel, rate=instrument.rate)
        for instrument in rig.instruments
        for channel in instrument.channels
        for axis in rig.grips
        if channel.reads == f"force_{axis}"
    }
    return Controller(cells=cells, seed=seed, noise=noise)

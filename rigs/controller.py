"""See what the load cells show, and remember what steps need to know.

The controller knows true forces no more than a user does: its load cells are tared, noisy and saturated. From row to
row it takes the mean of the samples that the log's clock gives meanwhile, from streams of noise of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.instruments import Channel
    from rigs.motion import Course
    from rigs.record import Equilibrium
    from rigs.rig import Rig
    from rigs.targets import Axis

PEAK_OVER_NOISE: Final = 5.0
"""A peak counts only above so many times the noise, or the smallest digit, of its load cell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """Hold what the controller remembers, in plain numbers.

    Attributes
    ----------
    course : Course
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
    every : float or None
        Time between pictures [s]; None where none fall due.
    image_since : float
        Time from which they are counted [s].
    image_tag : str or None
        The pictures' label.
    """

    course: Course
    tare: Mapping[Axis, float]
    shown: Mapping[Axis, float]
    readings: int = 0
    read_at: float = 0.0
    since: float = 0.0
    first: Mapping[Axis, float]
    peak: Mapping[Axis, float]
    every: float | None = None
    image_since: float = 0.0
    image_tag: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Hold a load cell as the controller has it: its channel and the samples a second of its clock [Hz]."""

    channel: Channel
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """Read the load cells of a rig.

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

    def begin(self, course: Course) -> Memory:
        """Return the memory of a test that begins."""
        nought = dict.fromkeys(self.cells, 0.0)
        return Memory(course=course, tare=nought, shown=nought, first=nought, peak=nought)

    def errors(self, memory: Memory, time: float) -> dict[Axis, float]:
        """Return what noise adds to the next reading, taken at a time [s], of each load cell [N]."""
        if not self.noise:
            return dict.fromkeys(self.cells, 0.0)
        found = {}
        for axis, cell in self.cells.items():
            samples = max(1.0, cell.rate * (time - memory.read_at))
            key = (*f"controller {cell.channel.name}".encode(), memory.readings)
            draw = np.random.default_rng(np.random.SeedSequence(entropy=self.seed, spawn_key=key)).standard_normal()
            found[axis] = cell.channel.noise / sqrt(samples) * float(draw)
        return found

    def shows(self, force: Mapping[Axis, float], memory: Memory, time: float) -> dict[Axis, float]:
        """Return what the load cells would show at a time [s], zeroed, of true forces [N]."""
        errors = self.errors(memory, time)
        return {
            axis: min(max(force[axis] + errors[axis], -cell.channel.limit), cell.channel.limit) - memory.tare[axis]
            for axis, cell in self.cells.items()
        }

    def read(self, memory: Memory, row: Equilibrium) -> Memory:
        """Return the memory after a row was read."""
        shown = self.shows(row.force, memory, row.time)
        peak = {axis: max(memory.peak[axis], force) for axis, force in shown.items()}
        return replace(memory, shown=shown, peak=peak, readings=memory.readings + 1, read_at=row.time)

    def zero(self, memory: Memory) -> Memory:
        """Return the memory after the load cells were tared."""
        tare = {axis: memory.tare[axis] + shown for axis, shown in memory.shown.items()}
        return replace(memory, tare=tare, shown=dict.fromkeys(tare, 0.0))

    def start_step(self, memory: Memory, time: float) -> Memory:
        """Return the memory of a step that begins."""
        return replace(memory, since=time, first=memory.shown, peak=memory.shown)

    def counts(self, axis: Axis, peak: float) -> bool:
        """Tell whether a peak stands out of the noise of its load cell."""
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

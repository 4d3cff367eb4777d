"""Hold a stroke that is being steered: what is asked of each axis at a share of it, and what was learnt so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.endings import TOLERANCE
from rigs.rig import read
from rigs.servo import Order, Search, Settled, crosshead
from rigs.way import between

if TYPE_CHECKING:
    from rigs.bench import Bench
    from rigs.endings import Watch
    from rigs.motion import Stroke
    from rigs.record import FloatArray
    from rigs.targets import Axis
    from rigs.way import Step

FIRST_PACE: Final = 1.0 / 32.0
"""First share of a stroke whose way is not known beforehand."""


@dataclass(slots=True, kw_only=True, eq=False)
class Helm:
    """Hold a stroke that is being steered.

    Attributes
    ----------
    bench, stroke, watch
        The bench, the stroke, and what may end its step.
    share : float
        How far it is [1].
    late : float
        Time by which axes lag behind what is asked of them at the stroke's end [s].
    pace : float
        Share of it to the next row [1].
    stopped : dict
        Where axes stand that met the force of a preload [m].
    trend : dict
        Travel of each axis per share, of late [m].
    slope : FloatArray or None
        What the last search knew of the derivatives.
    """

    bench: Bench
    stroke: Stroke
    watch: Watch
    share: float = 0.0
    late: float = 0.0
    pace: float
    stopped: dict[Axis, float] = field(default_factory=dict)
    trend: dict[Axis, float] = field(default_factory=dict)
    slope: FloatArray | None = None

    @property
    def open_ended(self) -> bool:
        """Return whether the way of the named axes is not known beforehand."""
        return bool(self.stroke.force)

    def time(self, share: float) -> float:
        """Return the time at a share [s]."""
        return self.bench.cursor.begun + share * self.stroke.duration + self.late

    def orders(self, share: float) -> dict[Axis, Order]:
        """Return what is asked of each axis at a share."""
        stroke, memory, controller = self.stroke, self.bench.memory, self.bench.controller
        errors = controller.errors(memory, self.time(share))
        places = between(stroke.start, stroke.end, share)
        orders: dict[Axis, Order] = {}
        for axis in self.bench.rig.grips:
            if axis in self.stopped:
                orders[axis] = Order(place=self.stopped[axis])
            elif axis in stroke.force:
                first, last = stroke.force[axis]
                shown = last if share >= 1.0 else first + share * (last - first)
                orders[axis] = Order(force=shown + memory.tare[axis] - errors[axis])
            elif axis in stroke.free:
                orders[axis] = Order(force=0.0)
            elif stroke.follow is not None and axis not in stroke.named:
                lead = stroke.start[stroke.follow]
                orders[axis] = Order(place=stroke.start[axis], leader=stroke.follow, lead=lead)
            else:
                orders[axis] = Order(place=places[axis])
        return orders

    def settle(self, share: float) -> Settled:
        """Return the equilibrium at a share."""
        bench, way = self.bench, share - self.share
        start = {axis: at + way * self.trend.get(axis, 0.0) for axis, at in bench.displacement.items()}
        search = Search(
            bench=bench,
            orders=self.orders(share),
            increment=bench.increment,
            duration=way * self.stroke.duration,
        )
        return search.settle(start, self.slope)

    def crosshead(self, step: Step, share: float) -> dict[Axis, float]:
        """Return where the crossheads stand [m] at an equilibrium on the way to a share."""
        bench = self.bench
        force = read(step.rig, step.state).force
        return crosshead(bench.rig.trains, self.orders(share), step.displacement, force)

    def excess(self, settled: Settled, share: float) -> float:
        """Return by what share [1] a force that stops an axis, or what ends the step, is passed."""
        stroke, bench, step = self.stroke, self.bench, settled.step
        shown = bench.controller.shows(read(step.rig, step.state).force, bench.memory, self.time(share))
        passed = self.watch.excess(bench.memory, shown, settled.crosshead)
        if stroke.stop_force is None:
            return passed
        going = [axis for axis in stroke.named if axis not in self.stopped]
        return max([passed, *(shown[axis] / stroke.stop_force - 1.0 for axis in going)])

    def stop(self) -> bool:
        """Let every axis stand that met the force of a preload; tell whether all have."""
        force, bench = self.stroke.stop_force, self.bench
        if force is None:
            return False
        for axis in self.stroke.named:
            if axis not in self.stopped and bench.memory.shown[axis] >= (1.0 - TOLERANCE) * force:
                self.stopped[axis] = bench.crosshead[axis]
        return all(axis in self.stopped for axis in self.stroke.named)

    def note(self) -> None:
        """Keep what is needed to go on after the next row."""
        slope = np.zeros((0, 0)) if self.slope is None else self.slope
        self.bench.note(
            share=self.share,
            late=self.late,
            pace=self.pace,
            **{f"stop_{axis}": at for axis, at in self.stopped.items()},
            **{f"trend_{axis}": way for axis, way in self.trend.items()},
            **{f"slope_{row}_{column}": float(one) for (row, column), one in np.ndenumerate(slope)},
        )


def helm_of(bench: Bench, stroke: Stroke, watch: Watch) -> Helm:
    """Return the helm of a stroke that begins, or as far as it was noted."""
    kept, axes = bench.cursor.variables, tuple(bench.rig.grips)
    named = max(abs(stroke.end[axis] - stroke.start[axis]) / bench.rig.gauges[axis] for axis in stroke.named)
    pace = min(1.0, bench.increment / named) if named > 0.0 else 1.0 if stroke.phase == "Hold" else FIRST_PACE
    size = sum(name.startswith("slope_") and name.endswith("_0") for name in kept)
    slope = np.array([[kept[f"slope_{row}_{column}"] for column in range(size)] for row in range(size)])
    return Helm(
        bench=bench,
        stroke=stroke,
        watch=watch,
        share=kept.get("share", 0.0),
        late=kept.get("late", 0.0),
        pace=kept.get("pace", pace),
        stopped={axis: kept[f"stop_{axis}"] for axis in axes if f"stop_{axis}" in kept},
        trend={axis: kept[f"trend_{axis}"] for axis in axes if f"trend_{axis}" in kept},
        slope=slope if size else None,
    )

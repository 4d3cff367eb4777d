"""Steer the axes row by row where their places must be searched for, or a force says where they stop.

It serves preloads, forces that are controlled, axes that give way, machines that do, and steps that end at a force.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.endings import TOLERANCE, Ending
from rigs.motion import PRELOAD_REACH
from rigs.rig import read
from rigs.servo import Order, Search, Settled
from rigs.way import between

if TYPE_CHECKING:
    from collections.abc import Generator

    from rigs.bench import Bench
    from rigs.endings import Watch
    from rigs.motion import Stroke
    from rigs.record import Equilibrium, FloatArray, Frame
    from rigs.targets import Axis

MOST_REFINEMENTS: Final = 40

FIRST_PACE: Final = 1.0 / 32.0
"""First share of a stroke whose way is not known beforehand."""

SLOWEST_PACE: Final = 1e-3
"""Shortest share of such a stroke from row to row."""


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


def steer(
    bench: Bench, stroke: Stroke, watch: Watch, marks: list[float], images: list[float]
) -> Generator[Equilibrium | Frame, None, Ending | None]:
    """Go through a stroke row by row.

    An axis of a preload that has met its force stays where it is while the others go on, as with a stop switch: what
    it carries in the end is no longer controlled.

    Parameters
    ----------
    bench, stroke, watch
        The test under way, the stroke, and what may end its step.
    marks, images : list of float
        Shares of the stroke at which there must be a row, and at which a picture is taken of it, each rising.

    Yields
    ------
    Equilibrium or Frame
        Every row on the way; none lies beyond a stop.

    Returns
    -------
    Ending or None
        A limit, if the reach of a preload or an instrument's range is used up before; what ended the step otherwise.
    """
    helm = helm_of(bench, stroke, watch)
    last, ending = watch.cut(bench.memory, bench.cursor.begun)
    caught_up = True
    if helm.share > 0.0 and any(abs(image - helm.share) <= 1e-9 for image in images):
        # A test that goes on from this row took its picture after it.
        yield bench.pictured(bench.memory.image_tag)
    while not helm.stop():
        if helm.share >= last and caught_up:
            return _short(helm) if stroke.stop_force is not None and ending is None else ending
        ahead = [mark for mark in (*marks, *images, last) if mark > helm.share + 1e-9] or [last]
        aim = min(helm.share + helm.pace, *ahead)
        settled, share = _approach(helm, next((mark for mark in ahead if abs(mark - aim) <= 1e-6), aim))
        caught_up = settled.met
        share = share if caught_up else _lag(helm, settled, share)
        _learn(helm, settled, share)
        helm.share = share
        bench.time = helm.time(share)
        helm.note()
        before = bench.displacement
        row = bench.accept(settled.step, stroke, settled.crosshead)
        pictured = any(abs(image - share) <= 1e-9 for image in images)
        if not pictured and bench.passes_frame(before):
            yield bench.frame()
        yield row
        over = bench.over() or watch.met(bench.controller, bench.memory, bench.crosshead)
        if pictured:
            yield bench.pictured(bench.memory.image_tag)
        if over is not None:
            return over
    return None


def _approach(helm: Helm, share: float) -> tuple[Settled, float]:
    """Return the equilibrium at a share, or before it where a force ends the way or the knit strains too much.

    A fibre that ends the test by breaking ends it there.
    """
    begin, bench = helm.share, helm.bench
    found = helm.settle(share)
    while helm.open_ended and found.met and share - begin > 2.0 * SLOWEST_PACE:
        if bench.strain(bench.crosshead, found.crosshead) <= 1.5 * bench.increment:
            break
        share = begin + 0.5 * (share - begin)
        helm.pace = share - begin
        found = _with_cost(helm.settle(share), found)
    over = helm.excess(found, share)
    if over <= TOLERANCE or not found.met:
        return found, share
    low, high, under = begin, share, _before(helm)
    for _ in range(MOST_REFINEMENTS):
        # Regula falsi, kept from either end: the force is nought while the knit is slack.
        share = low + (high - low) * min(max(under / (under - over), 0.1), 0.9)
        found = _with_cost(helm.settle(share), found)
        value = helm.excess(found, share)
        if abs(value) <= TOLERANCE or (found.step.final and value < 0.0):
            break
        if value > 0.0:
            high, over = share, value
        else:
            low, under = share, value
    return found, share


def _before(helm: Helm) -> float:
    """Return by what share something is short of ending the way where the bench stands."""
    bench, stroke = helm.bench, helm.stroke
    passed = helm.watch.excess(bench.memory, bench.memory.shown, bench.crosshead)
    going = [axis for axis in stroke.named if axis not in helm.stopped]
    short = [] if stroke.stop_force is None else [bench.memory.shown[axis] / stroke.stop_force - 1.0 for axis in going]
    value = max([passed, *short])
    return min(value, -TOLERANCE) if value > -inf else -1.0


def _with_cost(found: Settled, before: Settled) -> Settled:
    """Return an equilibrium with the cost of the trial before added to its own."""
    step, spent = found.step, before.step
    step = replace(
        step,
        iterations=step.iterations + spent.iterations,
        factorisations=step.factorisations + spent.factorisations,
        seconds=step.seconds + spent.seconds,
    )
    return replace(found, step=step)


def _lag(helm: Helm, settled: Settled, share: float) -> float:
    """Return the share at which axes that went as far as they may arrive there at their highest speed."""
    bench, duration = helm.bench, helm.stroke.duration
    time = max(
        abs(at - bench.crosshead[axis]) / bench.rig.trains[axis].fastest for axis, at in settled.crosshead.items()
    )
    room = share - helm.share
    if room <= 0.0 or time > room * duration:
        helm.late += time - room * duration
        return share
    return helm.share + time / duration


def _learn(helm: Helm, settled: Settled, share: float) -> None:
    """Keep what helps the search at the next row, and its pace."""
    bench, way = helm.bench, share - helm.share
    travel = settled.step.displacement
    if settled.met and way > 0.0:
        helm.trend = {axis: (travel[axis] - at) / way for axis, at in bench.displacement.items()}
    else:
        helm.trend = {}
    helm.slope = settled.slope if settled.slope.size else None
    if helm.open_ended and bench.strain(bench.crosshead, settled.crosshead) < 0.5 * bench.increment:
        helm.pace = min(2.0 * helm.pace, 0.25)


def _short(helm: Helm) -> Ending:
    """Return the ending of a test whose preload was not met."""
    force, shown = helm.stroke.stop_force or 0.0, helm.bench.memory.shown
    short = ", ".join(
        f"axis {axis} carries {shown[axis]:.3g} N" for axis in helm.stroke.named if axis not in helm.stopped
    )
    reach = f"preload of {force:g} N not met within a strain of {PRELOAD_REACH:g}"
    return Ending(end="limit", message=f"{reach}: {short}", test=True)

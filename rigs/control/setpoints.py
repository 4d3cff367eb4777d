"""Setpoints of a stroke under control: what is asked of each axis at a share of it, and the state of the search.

Before its beginning, at shares from -1 to 0, axes that give way from now on are let go: the force that they still carry
falls to zero while all others stay.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.control.path import between
from rigs.control.root_finding import MOST_TRIALS
from rigs.control.setpoint_search import REACH, ControlledPoint, Search, Setpoint, crosshead, force_bar, unbalanced
from rigs.control.stop_criteria import TOLERANCE
from rigs.machines.rig import read

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis, FloatArray
    from rigs.control.path import PathPoint
    from rigs.control.session import Session
    from rigs.control.stop_criteria import StopCriteria
    from rigs.protocol.strokes import Stroke
    from rigs.record import Equilibrium

FIRST_PACE: Final = 1.0 / 32.0
"""First share of a stroke whose travel is not known beforehand."""

SLOWEST_PACE: Final = 1e-3
"""Shortest share of a stroke from row to row, ..."""

FINEST_PACE: Final = 1.0 / 64.0
"""... and as a share of the longest where displacements are asked for."""

LONGEST_PACE: Final = 0.25
"""Longest share of a stroke from row to row where its travel is not known beforehand."""

SLOWER: Final = 4
"""Times that a row is searched again with more time, because a crosshead is not so fast."""


@dataclass(slots=True, kw_only=True, eq=False)
class Setpoints:
    """Stroke under control.

    Attributes
    ----------
    session, stroke, criteria
        The session, the stroke, and what may end its step.
    share : float
        How far it is [1]; below 0 while axes are let go.
    late : float
        Time that the stroke has taken beyond its plan, because crossheads went at their highest speed [s].
    pace, longest : float
        Share of it to the next row, and at most [1].
    stopped : dict
        Displacements of axes that met the force of a preload [m].
    carried : dict
        What free axes carried when the stroke before ended [N].
    trend : dict
        Travel of each axis per share, of late [m].
    shortened : bool
        Whether the share to the next row was shortened; the one after is then not longer.
    slope : FloatArray or None
        Derivatives that the last search found.
    """

    session: Session
    stroke: Stroke
    criteria: StopCriteria
    share: float = 0.0
    late: float = 0.0
    pace: float
    longest: float
    stopped: dict[Axis, float] = field(default_factory=dict)
    carried: dict[Axis, float] = field(default_factory=dict)
    trend: dict[Axis, float] = field(default_factory=dict)
    shortened: bool = False
    slope: FloatArray | None = None

    @property
    def open_ended(self) -> bool:
        """Return whether the travel of the named axes is not known beforehand."""
        return bool(self.stroke.force)

    def time(self, share: float) -> float:
        """Return the time at a share [s]."""
        return self.session.cursor.begun + max(share, 0.0) * self.stroke.duration + self.late

    def span(self, share: float) -> float:
        """Return the time planned for the travel to a share [s]."""
        return (max(share, 0.0) - max(self.share, 0.0)) * self.stroke.duration

    def orders(self, share: float) -> dict[Axis, Setpoint]:
        """Return what is asked of each axis at a share."""
        stroke, memory, controller = self.stroke, self.session.memory, self.session.controller
        errors, bands = (of(memory, self.time(share)) for of in (controller.acted_on, controller.dead_band))
        left, share = max(-share, 0.0), max(share, 0.0)
        places = between(stroke.start, stroke.end, share)
        orders: dict[Axis, Setpoint] = {}
        for axis in self.session.rig.grips:
            if axis in self.stopped:
                orders[axis] = Setpoint(place=self.stopped[axis])
            elif axis in stroke.force:
                first, last = stroke.force[axis]
                shown = last if share >= 1.0 else first + share * (last - first)
                orders[axis] = Setpoint(force=shown + memory.tare[axis] - errors[axis], dead_band=bands[axis])
            elif axis in stroke.free:
                orders[axis] = Setpoint(force=left * self.carried.get(axis, 0.0))
            elif stroke.follow is not None and axis not in stroke.named:
                lead = stroke.start[stroke.follow]
                orders[axis] = Setpoint(place=stroke.start[axis], leader=stroke.follow, lead=lead)
            else:
                orders[axis] = Setpoint(place=places[axis])
        return orders

    def settle(
        self, share: float, reach: float = REACH, *, unbroken: bool = False, most: int = MOST_TRIALS
    ) -> ControlledPoint:
        """Return the equilibrium at a share, reached no faster than the machine goes; see `Search`."""
        session, ahead = self.session, share - self.share
        start = {axis: at + ahead * self.trend.get(axis, 0.0) for axis, at in session.displacement.items()}
        orders, duration = self.orders(share), self.span(share)
        relaxes = session.rig.work.model.relaxation is not None
        for _ in range(SLOWER):
            search = Search(
                session=session,
                orders=orders,
                increment=session.increment,
                duration=duration,
                reach=reach,
                unbroken=unbroken,
                most=most,
            )
            found, needed = search.settle(start, self.slope), 0.0
            if found.met:
                needed = max(
                    abs(at - session.crosshead[axis]) / session.rig.trains[axis].fastest
                    for axis, at in found.crosshead.items()
                )
            late = needed > (1.0 + 1e-6) * duration
            duration = needed if late else duration
            if not (late and relaxes):
                break
        return found if relaxes else replace(found, duration=duration)

    def finest(self) -> float:
        """Return the shortest share of the stroke to the next row [1]."""
        stroke, rig = self.stroke, self.session.rig
        rises = {axis: last - first for axis, (first, last) in stroke.force.items() if first != last}
        if not rises or self.share < 0.0:
            return (
                SLOWEST_PACE
                if self.open_ended or self.share < 0.0 or stroke.phase == "Hold"
                else FINEST_PACE * self.longest
            )
        force = {axis: stroke.force[axis][0] + self.share * rise for axis, rise in rises.items()}
        return min(
            SLOWEST_PACE,
            *(2.0 * force_bar(force[axis], 0.0, rig.trains[axis]) / abs(rise) for axis, rise in rises.items()),
        )

    def crosshead(self, step: PathPoint, share: float) -> dict[Axis, float]:
        """Return the displacements of the crossheads [m] at an equilibrium before a share."""
        session = self.session
        force = read(step.rig, step.state).force
        return crosshead(session.rig.trains, self.orders(share), step.displacement, force)

    def excess(self, settled: ControlledPoint, share: float) -> float:
        """Return by what share [1] a force that stops an axis, or what ends the step, is passed."""
        stroke, session, step = self.stroke, self.session, settled.step
        shown = session.controller.shows(read(step.rig, step.state).force, session.memory, self.time(share))
        passed = self.criteria.excess(session.memory, shown, settled.crosshead)
        if stroke.stop_force is None:
            return passed
        going = [axis for axis in stroke.named if axis not in self.stopped]
        return max([passed, *(shown[axis] / stroke.stop_force - 1.0 for axis in going)])

    def accept(self, settled: ControlledPoint, share: float, before: Mapping[Axis, float]) -> Equilibrium:
        """Go to an equilibrium at a share, keep what is needed to resume after it, and return its row.

        The axes were at displacements `before` [m] at the row from which it was searched.
        """
        session, ahead = self.session, share - self.share
        travel = settled.step.displacement
        if ahead > 0.0:
            self.trend = {axis: (travel[axis] - at) / ahead for axis, at in before.items()}
        self.slope = settled.slope if settled.slope.size else None
        most = LONGEST_PACE if self.open_ended or share < 0.0 else self.longest
        short = session.strain(before, travel) < 0.5 * session.increment or not self.open_ended
        if short and not self.shortened:
            self.pace = min(2.0 * self.pace, most)
        if self.share < 0.0 <= share:
            self.pace, self.trend = self.longest, {}
        self.shortened = False
        self.late += settled.duration - self.span(share)
        self.share = share
        session.time = self.time(share)
        self.note()
        return session.accept(settled.step, self.stroke, settled.crosshead)

    def stop(self) -> bool:
        """Stop every axis that met the force of a preload; return whether all have."""
        force, session = self.stroke.stop_force, self.session
        if force is None:
            return False
        for axis in self.stroke.named:
            if axis not in self.stopped and session.memory.shown[axis] >= (1.0 - TOLERANCE) * force:
                self.stopped[axis] = session.crosshead[axis]
        return all(axis in self.stopped for axis in self.stroke.named)

    def note(self) -> None:
        """Keep what is needed to resume after the next row."""
        slope = np.zeros((0, 0)) if self.slope is None else self.slope
        self.session.note(
            share=self.share,
            late=self.late,
            pace=self.pace,
            **{f"stop_{axis}": at for axis, at in self.stopped.items()},
            **{f"carried_{axis}": force for axis, force in self.carried.items()},
            **{f"trend_{axis}": travel for axis, travel in self.trend.items()},
            **{f"slope_{row}_{column}": float(one) for (row, column), one in np.ndenumerate(slope)},
        )


def setpoints_of(session: Session, stroke: Stroke, criteria: StopCriteria) -> Setpoints:
    """Return the setpoints of a stroke that begins, or as far as it was noted."""
    kept, axes = session.cursor.variables, tuple(session.rig.grips)
    named = max(abs(stroke.end[axis] - stroke.start[axis]) / session.rig.gauges[axis] for axis in stroke.named)
    pace = min(1.0, session.increment / named) if named > 0.0 else 1.0 if stroke.phase == "Hold" else FIRST_PACE
    size = sum(name.startswith("slope_") and name.endswith("_0") for name in kept)
    slope = np.array([[kept[f"slope_{row}_{column}"] for column in range(size)] for row in range(size)])
    largest = 0.0 if session.last is None else max(abs(force) for force in session.last.force.values())
    carried = {} if session.last is None else {axis: session.last.force[axis] for axis in stroke.free}
    if "share" in kept:
        carried = {axis: kept[f"carried_{axis}"] for axis in axes if f"carried_{axis}" in kept}
    lets_go = any(
        abs(force) > unbalanced(session.rig) + force_bar(0.0, largest, session.rig.trains[axis])
        for axis, force in carried.items()
    )
    return Setpoints(
        session=session,
        stroke=stroke,
        criteria=criteria,
        share=kept.get("share", -1.0 if lets_go else 0.0),
        late=kept.get("late", 0.0),
        pace=kept.get("pace", pace),
        longest=pace,
        stopped={axis: kept[f"stop_{axis}"] for axis in axes if f"stop_{axis}" in kept},
        carried=carried,
        trend={axis: kept[f"trend_{axis}"] for axis in axes if f"trend_{axis}" in kept},
        slope=slope if size else None,
    )

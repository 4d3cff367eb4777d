"""Search for the travel of the fixtures of all axes that meets the setpoints of the controller.

Between the crosshead that the machine moves and the fixture that holds the specimen is the machine itself: it yields
by its compliance, and a gripper closes a gap before it takes hold. So the travel u of a fixture is not known but
found, from the last accepted equilibrium on, where

    u + C F(u) (+ gap) = d      for a crosshead at d,
    F(u) = f                    for a force f, which may be zero.

Every trial begins at that equilibrium, so that the history of friction has one path alone. A force is met to
`FORCE_TOLERANCE` of itself, a place to `PLACE_TOLERANCE` of what the machine gives. Where no travel does, a force is
also met within the dead band of its controller and what the solver leaves unbalanced.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.equilibrium.newton import Options
from knitlab_core.errors import ConvergenceError
from rigs.control.root_finding import MOST_TRIALS, find_root
from rigs.machines.rig import read

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis, FloatArray
    from rigs.control.path import PathPoint
    from rigs.control.root_finding import Function
    from rigs.control.session import Session
    from rigs.machines.load_train import LoadTrain
    from rigs.machines.rig import Rig

FORCE_TOLERANCE: Final = 5e-4
"""A force is met within this share of itself; a force of zero within as much of the largest on the rig."""

PLACE_TOLERANCE: Final = 1e-3
"""A crosshead is met within this share of the deflection of the machine ..."""

PLACE_FINEST: Final = 1e-6
"""... and no more finely than this strain: half a digit of an encoder on a specimen of 5 cm."""

FINEST_DIGIT: Final = 1e-2
"""No force is met more finely than this share of the smallest digit of its load cell."""

REACH: Final = 2.0
"""Longest travel of an axis from row to row to meet a setpoint, in largest strain increments."""

PROBE: Final = 0.05
"""First guess of a slope: from a travel of this share of that reach."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setpoint:
    """Setpoint of an axis: a displacement of its crosshead [m], a force [N], or the strain of another axis.

    Attributes
    ----------
    place, force : float or None
        What is asked for; a force is the true one.
    leader : Axis or None
        The axis whose strain it follows.
    lead : float
        Displacement of the leader where its strain counts as none [m]; `place` is that of the axis itself.
    dead_band : float
        How far off a force may be before the controller acts [N].
    """

    place: float | None = None
    force: float | None = None
    leader: Axis | None = None
    lead: float = 0.0
    dead_band: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ControlledPoint:
    """Equilibrium at which every setpoint is met, or the one that came nearest to it.

    Attributes
    ----------
    step : PathPoint
        The equilibrium.
    crosshead : Mapping
        Displacements of the crossheads [m].
    met : bool
        Whether the setpoints are met; if not, no travel within the reach of one row was found that meets them.
    slope : FloatArray, shape (n, n)
        Derivatives that the search found, for the next one.
    duration : float
        Time of the travel there [s].
    """

    step: PathPoint
    crosshead: Mapping[Axis, float]
    met: bool
    slope: FloatArray
    duration: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """Equilibrium that was tried, and by how much it misses the setpoints, in the widest tolerance."""

    step: PathPoint
    missed: float


def needs_search(orders: Mapping[Axis, Setpoint], trains: Mapping[Axis, LoadTrain]) -> tuple[Axis, ...]:
    """Return the axes whose travel is not the place that was ordered."""
    return tuple(
        axis for axis, order in orders.items() if order.place is None or order.leader or not trains[axis].rigid
    )


@dataclass(slots=True, kw_only=True, eq=False)
class Search:
    """Search for the travels that meet setpoints, from the current state of a session.

    Attributes
    ----------
    session : Session
        The session.
    orders : Mapping
        What is asked of each axis.
    increment : float
        Largest strain between two equilibria of a trial [1].
    duration : float
        Time of the travel [s].
    reach : float
        How far an axis may travel, in increments.
    unbroken : bool
        Whether the search ends at the first trial in which a fibre breaks.
    most : int
        Trials, at most.
    tried, nearest : Trial or None
        The last trial, and the one that missed least.
    failure : ConvergenceError or None
        The last trial that failed.
    """

    session: Session
    orders: Mapping[Axis, Setpoint]
    increment: float
    duration: float
    reach: float = REACH
    unbroken: bool = False
    most: int = MOST_TRIALS
    tried: Trial | None = None
    nearest: Trial | None = None
    failure: ConvergenceError | None = None

    def settle(self, start: Mapping[Axis, float], slope: FloatArray | None) -> ControlledPoint:
        """Return the equilibrium at which every setpoint is met, or the nearest to it that was found.

        Parameters
        ----------
        start : Mapping
            Travel of each axis to try first [m].
        slope : FloatArray or None, shape (n, n)
            Derivatives that an earlier search found.

        Raises
        ------
        ConvergenceError
            If there is no equilibrium at any travel that was tried.
        """
        session, rig = self.session, self.session.rig
        unknown = needs_search(self.orders, rig.trains)
        if not unknown:
            step = self._go({axis: order.place or 0.0 for axis, order in self.orders.items()})
            return self._settled(step, np.zeros((0, 0)), met=True)
        here = np.array([session.displacement[axis] for axis in unknown])
        reach = np.array([self.reach * self.increment * rig.gauges[axis] for axis in unknown])
        first = np.array([start[axis] for axis in unknown])

        def values(travel: FloatArray) -> FloatArray | None:
            if self.unbroken and self.tried is not None and breaks(session, self.tried.step):
                return None
            known = {axis: order.place or 0.0 for axis, order in self.orders.items() if axis not in unknown}
            try:
                step = self._go({**known, **dict(zip(unknown, travel.tolist(), strict=True))})
            except ConvergenceError as error:
                self.failure = error
                return None
            # A break that ends the test ends the search.
            missed, widest = (np.zeros(len(unknown)),) * 2 if step.final else self._misses(step, unknown)
            self.tried = Trial(step=step, missed=float(np.abs(widest).max()))
            if self.nearest is None or self.tried.missed < self.nearest.missed:
                self.nearest = self.tried
            return missed

        guess = _probed(values, here, PROBE * REACH / self.reach * reach) if slope is None else slope
        root = (
            None
            if guess is None
            else find_root(values, first, guess, np.stack([here - reach, here + reach]), most=self.most)
        )
        if self.tried is None or self.nearest is None:
            raise self.failure or ConvergenceError("no travel of the axes meets what is asked of them")
        sudden = root is not None and root.jumps and any(self.orders[axis].force is not None for axis in unknown)
        if root is not None and root.met and not sudden:
            return self._settled(self.tried.step, root.slope, met=True)
        # The solver carries on from the trial that was done last.
        step = self._go(self.nearest.step.displacement) if self.nearest is not self.tried else self.tried.step
        return self._settled(step, np.zeros((0, 0)) if root is None else root.slope, met=self.nearest.missed <= 1.0)

    def crosshead(self, step: PathPoint) -> dict[Axis, float]:
        """Return the displacements of the crossheads at an equilibrium [m]."""
        return crosshead(self.session.rig.trains, self.orders, step.displacement, read(step.rig, step.state).force)

    def _settled(self, step: PathPoint, slope: FloatArray, *, met: bool) -> ControlledPoint:
        return ControlledPoint(step=step, crosshead=self.crosshead(step), met=met, slope=slope, duration=self.duration)

    def _go(self, travel: Mapping[Axis, float]) -> PathPoint:
        """Return the equilibrium at some travels."""
        return self.session.reach(travel, duration=self.duration, increment=self.increment)

    def _misses(self, step: PathPoint, unknown: Sequence[Axis]) -> tuple[FloatArray, FloatArray]:
        """Return by how much each setpoint is missed (n,), in its tolerance and in the widest."""
        rig, force = self.session.rig, read(step.rig, step.state).force
        crossheads = self.crosshead(step)
        largest = max(abs(one) for one in force.values())
        missed = []
        for axis in unknown:
            order, train = self.orders[axis], rig.trains[axis]
            finest = FINEST_DIGIT * train.digit
            if order.force is not None:
                bar = force_bar(order.force, largest, train)
                by = force[axis] - order.force
                missed.append((by / bar, by / (bar + order.dead_band + unbalanced(rig))))
                continue
            if order.leader is not None:
                gauges = self.session.memory.history.gauges
                strain = (crossheads[order.leader] - order.lead) / gauges[order.leader]
                by = ((crossheads[axis] - (order.place or 0.0)) / gauges[axis] - strain) / 1e-6
            else:
                bar = train.compliance * (PLACE_TOLERANCE * abs(force[axis]) + finest) + PLACE_FINEST * rig.gauges[axis]
                by = (train.beyond(step.displacement[axis], force[axis]) - (order.place or 0.0)) / bar
                open_ = force[axis] / (FORCE_TOLERANCE * largest + finest)
                by = min(by, open_) if train.gap > 0.0 else by
            missed.append((by, by))
        fine, widest = np.array(missed).T
        return fine, widest


def breaks(session: Session, step: PathPoint) -> bool:
    """Return whether a fibre breaks on the path to an equilibrium, and the test goes on."""
    return len(step.rig.severed) > len(session.rig.severed)


def force_bar(asked: float, largest: float, train: LoadTrain) -> float:
    """Return within what of a force an axis must come [N], the largest on the rig being given [N]."""
    return FORCE_TOLERANCE * (abs(asked) or largest) + FINEST_DIGIT * train.digit


def unbalanced(rig: Rig) -> float:
    """Return the force that the solver may leave unbalanced on a specimen that carries hardly any [N]."""
    model = rig.work.model
    return Options().tolerance * model.force_floor * model.scales.force


def crosshead(
    trains: Mapping[Axis, LoadTrain],
    orders: Mapping[Axis, Setpoint],
    travel: Mapping[Axis, float],
    force: Mapping[Axis, float],
) -> dict[Axis, float]:
    """Return the displacements of the crossheads [m] with the fixtures at some travels [m] under some forces [N]."""
    crossheads = {}
    for axis, order in orders.items():
        train = trains[axis]
        holds = train.beyond(travel[axis], force[axis])
        # A gripper that has not closed its gap is where it was sent.
        waits = train.gap > 0.0 and force[axis] <= FINEST_DIGIT * train.digit and order.leader is None
        crossheads[axis] = order.place if waits and order.place is not None else holds
    return crossheads


def _probed(values: Function, here: FloatArray, steps: FloatArray) -> FloatArray | None:
    """Return the derivatives (n, n) by finite differences from the current travels; None where there are no values."""
    base = values(here)
    slope = np.zeros((len(here), len(here)))
    for number, part in enumerate(steps):
        moved = None if base is None else values(here + part * np.eye(len(here))[number])
        if base is None or moved is None:
            return None
        slope[:, number] = (moved - base) / part
        # Nothing pulls yet: a small slope, but a positive one.
        slope[number, number] = max(slope[number, number], 1e-3 / part)
    return slope

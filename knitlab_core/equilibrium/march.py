"""Follow a path of the fixtures from equilibrium to equilibrium: cut the step on failure, grow it again."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.breaking import break_due, reach
from knitlab_core.equilibrium.inelastic_step import after_step, rods_of_step
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_location import PassedSnap, snaps, trial_options, with_snap_counted
from knitlab_core.equilibrium.snap_through import BRISK, THICK, come_to_rest, counted
from knitlab_core.equilibrium.step_control import Motion, Pace, StepControl
from knitlab_core.equilibrium.transient import come_down
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError

MOST_MOVES = 150
"""Moves in which a snap must come to rest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """Where a march ended that found no equilibrium.

    Parameters
    ----------
    progress : float
        Parameter of the last equilibrium on the path.
    report : Report
        The last search.
    position : tuple of 3 floats
        Of the node with the largest unbalanced force [m].
    way : str
        What it is a march of.
    """

    progress: float
    report: Report
    position: tuple[float, float, float]
    way: str = "the stroke"

    @classmethod
    def of(cls, work: Workspace, state: State, report: Report, progress: float, way: str = "the stroke") -> "Failure":
        """Return where a search from a state failed."""
        x, y, z = state.q[report.node, :3] * work.model.scales.length
        return cls(progress=progress, report=report, position=(float(x), float(y), float(z)), way=way)

    def __str__(self) -> str:
        """Return in one line the force that remains unbalanced, and where."""
        x, y, z = (1e3 * c for c in self.position)
        if np.isinf(self.report.residual):
            return (
                f"no equilibrium beyond {self.progress:.4g} of {self.way}: the fixtures would drive strands through "
                f"each other near node {self.report.node} (x {x:.2f}, y {y:.2f}, z {z:.2f} mm)"
            )
        return (
            f"no equilibrium beyond {self.progress:.4g} of {self.way}: "
            f"{self.report.residual:.1e} of the mean fixture force is left at node "
            f"{self.report.node} (x {x:.2f}, y {y:.2f}, z {z:.2f} mm) "
            f"after {self.report.iterations} iterations at the shortest step"
        )


def settle_after_break(work: Workspace, state: State, options: Options | None = None) -> tuple[State | None, Report]:
    """Find the equilibrium after a break, with the fixtures where they are; it takes no time.

    Parameters
    ----------
    work : Workspace
        Buffers of the model of what is whole.
    state : State
        The equilibrium before, but for what broke: `bonds.hold` is that of what is whole.
    options : Options, optional
        How hard to try.

    Returns
    -------
    State or None, Report
        The equilibrium, None where none was found, and the last search with the iterations of all. What was set free
        is in none of its works.
    """
    options = options or Options()
    rods = rods_of_step(work.model, state, 0.0)
    near, report = come_down(work, state, rods, options)
    if near is None:
        return None, report
    found, again = advance(work, near, near.q, options, rods=rods)
    report = replace(again, iterations=report.iterations + again.iterations)
    if found is None:
        return None, report
    return after_step(work.model, state, replace(found, increment=found.q - state.q), 0.0), report


def march(
    work: Workspace,
    state: State,
    path: Callable[[float], FloatArray],
    *,
    longest: float,
    options: Options | None = None,
    duration: float = 0.0,
    pace: Pace | None = None,
) -> Iterator[tuple[float, State, Report]]:
    """Follow a path of the fixed unknowns from parameter 0 to 1, yielding every equilibrium.

    Steps are as long as friction's path allows (`step_control`). Where a short step finds none, strands snap: they
    come to rest with the fixtures at its end. A longer one that passes a snap is gone again in shorter ones, so that
    the equilibrium before the snap is near it (`snap_location`). Fused points break on the way; the equilibria before
    and after a break are yielded too, both at its own parameter.

    Parameters
    ----------
    work : Workspace
        Buffers of the model.
    state : State
        Equilibrium at parameter 0, or where the pace is.
    path : callable
        Target (N, 4) at a parameter.
    longest : float
        Longest step of the parameter.
    options : Options, optional
        How hard to try.
    duration : float
        Time the whole path takes, at an even pace [s]; it matters only to rods that relax.
    pace : Pace, optional
        Where to go on from; up to date whenever an equilibrium is yielded.

    Raises
    ------
    ConvergenceError
        If the shortest step still finds no equilibrium, and what snaps comes to no rest.
    """
    pace = Pace() if pace is None else pace
    fixed = work.model.fixed
    outset = Motion.of(state, path(min(1.0, pace.at + longest)) - state.q, fixed)
    control = StepControl.of(longest, pace, turns=outset.turns and state.memory.key.size > 0)
    at, ahead = pace.at, None
    passed: PassedSnap | None = None

    def search(origin: State, begin: float, end: float) -> tuple[State | None, Report]:
        span = duration * (end - begin)
        guess = ahead if origin is state else None
        if passed is not None and origin is state and end > begin:
            return locate(passed, begin, end)
        found, report = advance(work, origin, path(end), options, duration=span, ahead=guess)
        if found is None and np.isfinite(report.residual) and control.tries_snap():
            return _snap(work, origin, path(end), options, span)
        return None if found is None else with_snap_counted(origin, found, report), report

    def locate(snap: PassedSnap, begin: float, end: float) -> tuple[State | None, Report]:
        span = duration * (end - begin)
        if not snap.crossed:
            found, report = advance(work, state, path(end), trial_options(options), duration=span, ahead=ahead)
            if found is not None and not snaps(state, found):
                return found, report
            if control.is_long(end - begin):
                return None, report
        guess = np.where(fixed, path(end), snap.beyond.q) - state.q
        found, report = advance(work, state, path(end), options, duration=span, ahead=guess)
        return None if found is None else counted(state, found), report

    def settle(torn: State) -> tuple[State | None, Report]:
        return settle_after_break(work, torn, options)

    while at < 1.0:
        to = goal = control.goal(at)
        bonds = work.model.bonds
        broken = None if bonds is None else break_due(settle, state, bonds.locate)
        if broken is not None:
            to, (found, report) = at, broken
        elif bonds is None:
            found, report = search(state, at, to)
        else:
            to, found, report = reach(search, settle, state, bonds.locate, at, to)
        if found is None and passed is not None and (passed.crossed or not control.is_long(to - at)):
            to, found, report = passed.to, passed.beyond, passed.report
        if found is None:
            ahead = None
            if not control.cut():
                raise ConvergenceError(Failure.of(work, state, report, at))
            continue
        snapped = broken is None and found.snap_work > state.snap_work and snaps(state, found)
        if snapped and passed is None and control.is_long(to - at):
            passed, ahead = PassedSnap(beyond=found, report=report, to=to, step=control.step), None
            control.cut()
            continue
        # A step that stopped at a break is not gone again.
        if to == goal and found.bonds.hold is state.bonds.hold and control.rejects(found.slip_change):
            ahead = found.increment
            continue
        crossed = passed is not None and (snapped or broken is not None or to >= passed.to)
        if crossed and snapped:
            # The slip of a snap does not go on: the next step is as the first one of a march.
            found = replace(found, increment=np.zeros_like(found.increment))
        at, state, ahead = to, found, None
        if broken is None:
            control.accept(at, found.slip_change)
        if passed is not None and crossed:
            control.step = passed.step
            passed = None if broken is not None or at >= passed.to else replace(passed, crossed=True)
        pace.at, pace.step, pace.resumable = at, control.step, passed is None
        yield at, state, report


def _snap(
    work: Workspace, state: State, target: FloatArray, options: Options | None, duration: float
) -> tuple[State | None, Report]:
    """Go to a target that has no equilibrium near the last one; time passes on the first move alone."""
    wanted = options or Options()
    brisk = replace(wanted, max_iterations=min(wanted.max_iterations, BRISK.max_iterations))

    def move(begun: State, drag: float) -> tuple[State | None, Report]:
        return advance(work, begun, target, brisk, duration=duration if begun is state else 0.0, drag=drag)

    return come_to_rest(move, state, drag=THICK, most=MOST_MOVES)

"""From equilibrium to equilibrium: guess, search, cut the step on failure, grow it again."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.breaking import break_due, reach
from knitlab_core.equilibrium.continuation import continue_to_rest
from knitlab_core.equilibrium.coupling import coupled_step
from knitlab_core.equilibrium.inelastic_step import after_step, rods_of_step
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import COUPLED, Options, Report, blocked, equilibrate
from knitlab_core.equilibrium.snap_location import PassedSnap, snaps, trial_options, with_snap_counted
from knitlab_core.equilibrium.snap_through import BRISK, THICK, come_to_rest, counted
from knitlab_core.equilibrium.step_control import Motion, Pace, StepControl, lead_of, path_error
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.transient import come_down
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.sums import inner, length

MOST_MOVES = 150
"""Moves in which a snap must come to rest."""

SAFE = 0.95
"""Share of the way to a neighbour's core that a guess may use."""

MOST_PARTS = 12
"""Parts in which fixtures may be brought to their places."""


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


def _guess(work: Workspace, state: State, motion: FloatArray, way: Motion, ahead: FloatArray | None) -> FloatArray:
    """Return a first guess (N, 4) of the motion, given that of the fixed unknowns.

    `ahead` is the motion found in a longer step, from the same state or across the same snap. Extrapolating the
    response with the curvature of the path cost 3 to 10 % more iterations than the response alone.
    """
    fixed = work.model.fixed
    if not motion.any():
        return motion if ahead is None else np.where(fixed, motion, ahead)
    if ahead is not None:
        return np.where(fixed, motion, length(motion) / length(ahead * fixed) * ahead)
    if way.goes_on and state.contacts == 0:
        return np.where(fixed, motion, way.ratio * state.increment)
    if way.goes_on and state.response is not None:
        return np.where(fixed, motion, way.ratio * state.response)
    work.assemble()
    work.stiffness.pull(motion)
    response = work.stiffness.response(motion) if work.stiffness.factor() else None
    return motion if response is None else response


def _approach(work: Workspace, state: State, motion: FloatArray, guess: FloatArray) -> tuple[FloatArray, Frames] | None:
    """Place the fixtures; return configuration and frames, None if strands would cross.

    Where a guess would drive strands through each other only the safe part of it is gone, and the yarn answers to the
    rest of the fixtures' motion from there: so fixtures carry along the yarn beside them.
    """
    has_edge, fixed = work.model.rods.has_edge, work.model.fixed
    q, frames, left = state.q, state.frames, motion
    for _ in range(MOST_PARTS):
        room = work.contacts.collision_free_fraction(q, guess, SAFE)
        q = q + room * guess if room < 1.0 else np.where(fixed, state.q + motion, q + guess)
        frames, before = frames.copy(), frames
        follow(q, has_edge, before, frames)
        work.contacts.keep_listed(q)
        if room >= 1.0:
            return q, frames
        left = (1.0 - room) * left
        work.clock.iterations += 1
        work.move_to(q, frames)
        forces = np.where(fixed, 0.0, work.gradient())
        work.assemble(exact=0.0)
        pull = work.stiffness.pull(left)
        if not work.stiffness.factor():
            return None
        guess = left - work.stiffness.solve(pull + forces)
    return None


def advance(
    work: Workspace,
    state: State,
    target: FloatArray,
    options: Options | None = None,
    *,
    duration: float = 0.0,
    ahead: FloatArray | None = None,
    rods: RodTerm | None = None,
    drag: float = 0.0,
) -> tuple[State | None, Report]:
    """Find the equilibrium with fixed unknowns at `target`, from the one before; no bond breaks on the way.

    Parameters
    ----------
    work : Workspace
        Buffers of the model.
    state : State
        The last equilibrium.
    target : (N, 4) array
        Where the fixed unknowns shall be; other entries are ignored.
    options : Options, optional
        How hard to try.
    duration : float
        Time the step takes [s]; it matters only to rods that relax.
    ahead : (N, 4) array, optional
        Motion found in a longer step from the same state, as a guess.
    rods : RodTerm, optional
        Rods of the step, in place of the model's.
    drag : float
        Resistance of every node to its motion [E r], zero but while strands snap.

    Returns
    -------
    State or None, Report
        The new equilibrium, None where the search failed, and how it went.
    """
    with work.clock("search"):
        step = rods_of_step(work.model, state, duration) if rods is None else rods
        found, report = _search(work, state, target, options or Options(), ahead, step, drag)
    if found is None or rods is not None:
        return found, report
    return after_step(work.model, state, found, duration), report


def _search(
    work: Workspace,
    state: State,
    target: FloatArray,
    options: Options,
    ahead: FloatArray | None,
    rods: RodTerm,
    drag: float,
) -> tuple[State | None, Report]:
    """Find the equilibrium of the rods of a step."""
    model = work.model
    motion = np.where(model.fixed, target - state.q, 0.0)
    way = Motion.of(state, motion, model.fixed)
    lead = lead_of(state, way)
    work.start_step(state.q, state.frames, state.memory, state.bonds.hold, state.poles, lead, rods=rods, drag=drag)
    begun = _approach(work, state, motion, _guess(work, state, motion, way, ahead))
    if begun is None:
        return None, blocked(int(np.argmax(np.abs(motion))) // 4, state.contacts)
    q, frames, gradient, report = equilibrate(work, *begun, options, motion)
    if not report.converged and options.rescue and not drag and np.isfinite(report.residual):
        spent = report.iterations
        q, frames, gradient, report = continue_to_rest(work, q, frames, options, motion)
        report = replace(report, iterations=spent + report.iterations)
    if not report.converged:
        return None, report
    response = _response(work, motion, report)
    memory, poles, slip_work = work.settle()
    change, largest = path_error(state, memory, way, model)
    increment = q - state.q
    # What drags on the fixtures is no force of the strands.
    gradient[:, :3] -= drag * increment[:, :3]
    reaction = np.where(model.fixed, gradient, 0.0)
    pushed = 0.5 * inner(state.reaction + reaction, increment) + inner(work.dead.loads, increment)
    return (
        replace(
            state,
            q=q,
            frames=frames.copy(),
            memory=memory,
            poles=poles,
            reaction=reaction,
            increment=increment,
            response=response,
            slip_change=change,
            largest_load=largest,
            contacts=report.contacts,
            energies=np.array([*work.rods.parts(), work.contacts.normal_energy()]),
            external_work=state.external_work + float(pushed),
            friction_work=state.friction_work + slip_work,
            bonds=state.bonds if work.bonds is None else work.bonds.state(state.bonds),
        ),
        report,
    )


def _response(work: Workspace, motion: FloatArray, report: Report) -> FloatArray | None:
    """Return the linear response to the motion of the fixtures, friction's loads included, from the factor at hand."""
    if report.iterations == 0 or work.drag is not None or not motion.any():
        return None
    response = work.stiffness.response(motion)
    if response is None or report.contacts == 0:
        return response
    return motion + coupled_step(work, response - motion, COUPLED)


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
    locate_snaps: bool = True,
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
    locate_snaps : bool
        Whether steps that pass a snap are gone again in shorter ones.

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
        if snapped and passed is None and locate_snaps and control.is_long(to - at):
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

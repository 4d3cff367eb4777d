"""From equilibrium to equilibrium: guess, search, cut the step on failure, grow it again."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.breaking import reach
from knitlab_core.equilibrium.creep import relaxed, relaxing
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options, Report, blocked, equilibrate
from knitlab_core.equilibrium.snapping import BRISK, THICK, come_to_rest, counted
from knitlab_core.equilibrium.sums import inner
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError
from knitlab_core.rods.frames import follow

SMALLEST_STEP = 1.0 / 256.0
"""Shortest step tried before giving up, relative to the longest."""

MOST_MOVES = 150
"""Moves in which a snap must come to rest."""

EASY = 20
"""Iterations up to which the next step may grow again."""


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

    def __str__(self) -> str:
        """Say in one line what remains out of balance, and where."""
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


@dataclass(slots=True, kw_only=True)
class Pace:
    """Where a march stands; it keeps this up to date, so that another can go on from there.

    Attributes
    ----------
    at : float
        Parameter of the last equilibrium.
    step : float or None
        Length of the next step; None is the longest.
    """

    at: float = 0.0
    step: float | None = None


def _guess(work: Workspace, state: State, motion: FloatArray) -> FloatArray:
    """Return a first guess (N, 4) of the motion, given that of the fixed unknowns."""
    fixed = work.model.fixed
    before = state.increment * fixed
    size = inner(before, before)
    if state.contacts == 0 and size > 0.0:
        ratio = inner(before, motion) / size
        if 0.0 < ratio <= 1.5 and np.allclose(ratio * before, motion, atol=1e-6 * np.sqrt(size)):
            return np.where(fixed, motion, ratio * state.increment)
    if not motion.any():
        return motion
    work.assemble(state.q, state.frames)
    pull = work.stiffness_times(motion)
    pull[fixed] = 0.0
    if not work.factor():
        return motion
    return motion - work.solve(pull)


def advance(
    work: Workspace, state: State, target: FloatArray, options: Options | None = None, *, duration: float = 0.0
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

    Returns
    -------
    State or None, Report
        The new equilibrium, None where the search failed, and how it went.
    """
    with relaxing(work, state, duration):
        found, report = _search(work, state, target, options or Options())
    return None if found is None else relaxed(work.model, state, found, duration), report


def _search(work: Workspace, state: State, target: FloatArray, options: Options) -> tuple[State | None, Report]:
    """Find the equilibrium of elastic rods."""
    model = work.model
    motion = np.where(model.fixed, target - state.q, 0.0)
    work.start_step(state.q, state.frames, state.memory, state.bonds.hold, state.poles)
    guess = _guess(work, state, motion)
    room = work.room(state.q, guess, 0.95)
    if room < 1.0:
        # Fixtures go where they must; the rest of the guess only as far as is safe.
        guess = np.where(model.fixed, motion, room * guess)
        if work.room(state.q, guess, 0.95) < 1.0:
            return None, blocked(int(np.argmax(np.abs(motion))) // 4, state.contacts)
    q = state.q + guess
    frames = state.frames.copy()
    follow(q, model.rods.has_edge, state.frames, frames)
    work.keep_listed(q)
    q, frames, gradient, report = equilibrate(work, q, frames, options)
    if not report.converged:
        return None, report
    memory, poles, slip_work = work.settle()
    increment = q - state.q
    # What drags on the fixtures is no force of the strands.
    gradient[:, :3] -= work.drag * increment[:, :3]
    reaction = np.where(model.fixed, gradient, 0.0)
    pushed = 0.5 * inner(state.reaction + reaction, increment) + inner(work.loads, increment)
    return (
        replace(
            state,
            q=q,
            frames=frames.copy(),
            memory=memory,
            poles=poles,
            reaction=reaction,
            increment=increment,
            contacts=report.contacts,
            energies=work.parts(q, frames),
            external_work=state.external_work + float(pushed),
            friction_work=state.friction_work + slip_work,
            bonds=state.bonds if work.fused is None else work.fused.state(state.bonds),
        ),
        report,
    )


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

    Where the shortest step finds none, strands snap: they come to rest with the fixtures at its end. Fused points
    break on the way; the equilibrium before a break is yielded too, at its own parameter.

    Parameters
    ----------
    work : Workspace
        Buffers of the model.
    state : State
        Equilibrium at parameter 0, or where the pace says.
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
        If a step cut to `SMALLEST_STEP` of the longest still finds no equilibrium, and what snaps comes to no rest.
    """
    count = max(1, int(np.ceil(1.0 / longest - 1e-9)))
    whole = 1.0 / count
    pace = Pace() if pace is None else pace
    at, step = pace.at, whole if pace.step is None else pace.step

    def search(origin: State, begin: float, end: float) -> tuple[State | None, Report]:
        span = duration * (end - begin)
        found, report = advance(work, origin, path(end), options, duration=span)
        if found is None and step < 2.0 * SMALLEST_STEP * whole and np.isfinite(report.residual):
            return _snap(work, origin, path(end), options, span)
        if found is not None and report.iterations > EASY:
            found = counted(origin, found)
        return found, report

    while at < 1.0:
        to = _next(at, step)
        to = 1.0 if to > 1.0 - 1e-9 else to
        if work.model.bonds is None:
            found, report = search(state, at, to)
        else:
            to, found, report = reach(search, state, work.model.bonds.locate, at, to)
        if found is None:
            step *= 0.5
            if step < SMALLEST_STEP * whole:
                x, y, z = state.q[report.node, :3] * work.model.scales.length
                place = (float(x), float(y), float(z))
                raise ConvergenceError(Failure(progress=at, report=report, position=place))
            continue
        at, state = to, found
        doubled = at / (2.0 * step)
        # A step grows only where the longer one stays on its own grid, so that whole steps are met again.
        if step < whole and report.iterations <= EASY and abs(doubled - round(doubled)) < 1e-6:
            step = min(2.0 * step, whole)
        pace.at, pace.step = at, step
        yield at, state, report


def _snap(
    work: Workspace, state: State, target: FloatArray, options: Options | None, duration: float
) -> tuple[State | None, Report]:
    """Go to a target that has no equilibrium near the last one; time passes on the first move alone."""
    wanted = options or Options()
    brisk = replace(wanted, max_iterations=min(wanted.max_iterations, BRISK.max_iterations))

    def move(begun: State) -> tuple[State | None, Report]:
        return advance(work, begun, target, brisk, duration=duration if begun is state else 0.0)

    return come_to_rest(work, move, state, drag=THICK, most=MOST_MOVES)


def _next(at: float, step: float) -> float:
    """Return the next multiple of a step; a march that stopped at a break goes back to it."""
    steps = at / step
    return at + step if abs(steps - round(steps)) < 1e-6 else step * float(np.ceil(steps))

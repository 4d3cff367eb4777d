"""One step from an equilibrium to the next: guess, bring fixtures to their places, search."""

from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.continuation import continue_to_rest
from knitlab_core.equilibrium.coupling import coupled_step
from knitlab_core.equilibrium.inelastic_step import after_step, rods_of_step
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import COUPLED, Options, Report, blocked, equilibrate
from knitlab_core.equilibrium.step_control import Motion, lead_of, path_error
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.ties import gather, spread
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.sums import inner, length

SAFE = 0.95
"""Share of the way to a neighbour's core that a guess may use."""

MOST_PARTS = 12
"""Parts in which fixtures may be brought to their places."""


def _guess(work: Workspace, state: State, motion: FloatArray, way: Motion, ahead: FloatArray | None) -> FloatArray:
    """Return a first guess (N, 4) of the motion, given that of the fixed unknowns.

    `ahead` is the motion found in a longer step, from the same state or across the same snap. Extrapolating the
    response with the curvature of the path cost 3 to 10 % more iterations than the response alone.
    """
    fixed = work.model.fixed
    if not motion.any():
        return motion if ahead is None else np.where(fixed, motion, ahead)
    if ahead is not None:
        return np.where(fixed, motion, length(motion * fixed) / length(ahead * fixed) * ahead)
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
        if work.model.ties is not None:
            spread(work.model.ties, q)
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
    motion = model.moved(state.q, target)
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
    gradient[:, :3] -= _dragged(work, drag, increment)
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


def _dragged(work: Workspace, drag: float, increment: FloatArray) -> FloatArray:
    """Return what drags on the fixtures (N, 3) [E r^2], which is no force of the strands.

    Images of a periodic cell are dragged too, and pull on the vectors that they follow.
    """
    forces = drag * increment
    if drag and work.model.ties is not None:
        gather(work.model.ties, forces)
    return forces[:, :3]


def _response(work: Workspace, motion: FloatArray, report: Report) -> FloatArray | None:
    """Return the linear response to the motion of the fixtures, friction's loads included, from the factor at hand."""
    if report.iterations == 0 or work.drag is not None or not motion.any():
        return None
    response = work.stiffness.response(motion)
    if response is None or report.contacts == 0:
        return response
    return motion + coupled_step(work, response - motion, COUPLED)

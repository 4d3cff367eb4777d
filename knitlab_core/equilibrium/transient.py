"""From where a fibre or a fused point broke to rest: overdamped motion, the fixtures where they are.

What broke carries nothing from the first step on. Nodes then move as through a viscous fluid, c dx/dt = -forces, in
linearly implicit Euler steps of time 1/c: (K + C + c I) d = -g, with the change C of friction's loads. The drag c
follows the error of the linear step, as in `continuation.py`; a step that is too wrong is taken again with more drag.
Friction remembers the way: its memory is brought up to date after every `REBASED` of motion. Brought up to date after
every step it sticks at each step's start, and steps come out no longer than the elastic slip. Only forces in balance
without drag are rest (docs/decisions/0035).
"""

from dataclasses import dataclass, replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.friction import Memory
from knitlab_core.equilibrium.coupling import coupled_step
from knitlab_core.equilibrium.hook_friction import PoleMemory
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import COUPLED, FAR, Options, Report, force_scale
from knitlab_core.equilibrium.snap_through import farthest
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.sums import inner, length

FIRST_DRAG = 1e-4
"""Drag of the first step [E r]; a hundred times as much takes a tenth more steps."""

LEAST_DRAG, MOST_DRAG = 1e-9, 1.0
"""Drag below which there is none, and from which on a step is taken whatever its error [E r]."""

WANTED, MOST_WRONG = 0.6, 4.0
"""Error of the linear step, relative to it, that the drag is chosen for, and from which the step is taken again."""

THINNER, THICKER = 0.1, 8.0
"""Least and largest factor of the drag from one step to the next."""

REBASED = 2.0
"""Motion of a node after which friction's memory is brought up to date [r]."""

LINGERS = 25
"""Steps after which it is brought up to date in any case: a strand whose slip turns back may swing without end."""

MOST_ITERATIONS = 1500
"""Steps, those taken again included, in which it must come to rest."""


@dataclass(slots=True)
class _Place:
    """Where the motion is: configuration, its frames, and what friction remembers, with its work so far [E r^3].

    `base` (N, 4) is the configuration of that memory.
    """

    q: FloatArray
    frames: Frames
    memory: Memory
    poles: PoleMemory
    base: FloatArray
    friction_work: float


@dataclass(frozen=True, slots=True)
class _Step:
    """A trial step: where it leads, the part of it that is free of collisions, and its error relative to it [1]."""

    q: FloatArray
    frames: Frames
    fraction: float
    error: float


def come_down(work: Workspace, state: State, rods: RodTerm, options: Options) -> tuple[State | None, Report]:
    """Go to where the forces balance that a break has put out of balance.

    Parameters
    ----------
    work : Workspace
        Buffers of the model of what is whole.
    state : State
        Where the motion begins; `bonds.hold` is that of what is whole.
    rods : RodTerm
        Rods of the motion; it takes no time.
    options : Options
        Tolerance of the balance.

    Returns
    -------
    State or None, Report
        The state to search the equilibrium from: its configuration, friction's memory, and the works of friction and
        of loads on the way, not what the drag used up. None where no balance was found. Then the report of the last
        step, with the number of all.
    """
    free = ~work.model.fixed
    place = _Place(state.q, state.frames, state.memory, state.poles, state.q, state.friction_work)
    drag, spent, since = FIRST_DRAG, 0, 0
    _start(work, state, place, rods)
    while True:
        contacts = work.lag()
        gradient = work.gradient()
        residual = gradient * free
        worst = int(np.argmax(np.abs(residual)))
        relative = float(np.abs(residual.flat[worst])) / force_scale(work, gradient)
        report = Report(
            converged=relative < options.tolerance,
            iterations=spent,
            residual=relative,
            node=worst // 4,
            contacts=contacts,
            continued=True,
        )
        if report.converged:
            _settle(work, place)
            return _reached(work, state, place), report
        if spent >= MOST_ITERATIONS or not np.isfinite(relative):
            return None, report
        work.assemble(exact=1.0 if relative < FAR else 0.0)
        while True:
            spent += 1
            work.clock.iterations += 1
            if not work.stiffness.factor(drag):
                return None, report
            drag = work.stiffness.shift
            step = _try(work, place, residual, drag, contacts=contacts, room=options.room)
            if step.error <= MOST_WRONG or drag >= MOST_DRAG:
                break
            drag = _next_drag(drag, step)
            work.move_to(place.q, place.frames)
            work.lag()
        drag = _next_drag(drag, step)
        place.q, place.frames = step.q, step.frames
        work.contacts.keep_listed(place.q)
        since += 1
        if since >= LINGERS or farthest(place.q - place.base) > REBASED:
            _settle(work, place)
            _start(work, state, place, rods)
            since = 0


def _try(work: Workspace, place: _Place, residual: FloatArray, drag: float, *, contacts: int, room: float) -> _Step:
    """Make a step with the factor at hand; its samples are left placed where it leads."""
    d = work.stiffness.solve(-residual)
    if contacts > 0:
        d = coupled_step(work, d, COUPLED)
    fraction = work.contacts.collision_free_fraction(place.q, d, room)
    q, frames = place.q + fraction * d, place.frames.copy()
    follow(q, work.model.rods.has_edge, place.frames, frames)
    work.move_to(q, frames)
    work.lag()
    # A linear answer would leave (1 - f) g - f c d.
    wrong = work.gradient() * ~work.model.fixed - (1.0 - fraction) * residual + fraction * drag * d
    size = fraction * length(d)
    return _Step(q, frames, fraction, length(work.stiffness.solve(wrong)) / size if size > 0.0 else np.inf)


def _next_drag(drag: float, step: _Step) -> float:
    """Return the drag [E r] with which a step as long as this one would have the error wanted."""
    factor = min(max(step.error / WANTED, THINNER), THICKER)
    if factor > 1.0:
        return factor * max(drag, LEAST_DRAG)
    # Strands in the way, not the drag, made the step short.
    drag *= factor if step.fraction > 0.5 else 1.0
    return drag if drag >= LEAST_DRAG else 0.0


def _start(work: Workspace, state: State, place: _Place, rods: RodTerm) -> None:
    """Count motion and slip from here on."""
    work.start_step(place.q, place.frames, place.memory, state.bonds.hold, place.poles, rods=rods)
    place.base = place.q


def _settle(work: Workspace, place: _Place) -> None:
    """Bring friction's memory up to date; the samples have been placed here."""
    place.memory, place.poles, rubbed = work.settle()
    place.friction_work += rubbed


def _reached(work: Workspace, state: State, place: _Place) -> State:
    """Return the state here; energies and reactions are still those of its start."""
    return replace(
        state,
        q=place.q,
        frames=place.frames,
        memory=place.memory,
        poles=place.poles,
        friction_work=place.friction_work,
        external_work=state.external_work + inner(work.dead.loads, place.q - state.q),
    )

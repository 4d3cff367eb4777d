"""Pseudo-transient continuation: the rescue of a Newton search that makes no progress.

Each iteration is one linearly implicit Euler step of dx/dt = -forces from where the last one ended (Kelley and Keyes
1998, doi:10.1137/S0036142996304796): (K + C + c I) d = -g, with the change C of friction's loads, the drag
c = 1 / time step, and no line search. The drag follows the error of the linear step as the factor at hand weighs it: a
residual would count the stiff contact that closes and not the soft loop that moves. Only a state whose forces balance
without drag is accepted.
"""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.coupling import coupled_step
from knitlab_core.equilibrium.newton import COUPLED, FAR, Options, Report, force_scale
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.sums import length

FIRST_DRAG = 1e-5
"""Drag of the first step [E r]: some ten times what a loop resists its bending with."""

LEAST_DRAG = 1e-9
"""Drag below which there is none [E r]."""

MOST_ITERATIONS = 2
"""Iterations in which it must come to rest, relative to those of a search."""

LINEAR, CURVED = 0.25, 0.75
"""Errors of a linear step, relative to it, up to which the drag falls by 10, and from which it grows by 4."""


def continue_to_rest(
    work: Workspace, q: FloatArray, frames: Frames, options: Options, motion: FloatArray | None = None
) -> tuple[FloatArray, Frames, FloatArray, Report]:
    """Go down the forces to an equilibrium, with fixed unknowns held where they are.

    Parameters and results are those of `newton.equilibrate`; the way to the result may pass a snap.
    """
    model, stiffness = work.model, work.stiffness
    free = ~model.fixed
    other = frames.copy()
    drag, iteration = FIRST_DRAG, 0
    work.move_to(q, frames)
    contacts = work.lag()
    gradient = work.gradient()
    while True:
        residual = gradient * free
        worst = int(np.argmax(np.abs(residual)))
        relative = float(np.abs(residual.flat[worst])) / force_scale(work, gradient)
        report = Report(
            converged=relative < options.tolerance,
            iterations=iteration,
            residual=relative,
            node=worst // 4,
            contacts=contacts,
            continued=True,
        )
        if report.converged or iteration >= MOST_ITERATIONS * options.max_iterations or not np.isfinite(relative):
            return q, frames, gradient, report
        iteration += 1
        work.clock.iterations += 1
        work.assemble(exact=1.0 if relative < FAR else 0.0)
        if motion is not None:
            stiffness.pull(motion)
        if not stiffness.factor(drag):
            return q, frames, gradient, report
        drag = stiffness.shift
        step = stiffness.solve(-residual)
        if contacts > 0:
            step = coupled_step(work, step, COUPLED)
        fraction = work.contacts.collision_free_fraction(q, step, options.room)
        q = q + fraction * step
        follow(q, model.rods.has_edge, frames, other)
        frames, other = other, frames
        work.move_to(q, frames)
        contacts = work.lag()
        gradient = work.gradient()
        # A linear answer would leave (1 - f) g - f c d.
        wrong = gradient * free - (1.0 - fraction) * residual + fraction * drag * step
        size = fraction * length(step)
        drag = _next_drag(drag, length(stiffness.solve(wrong)), size, fraction)
        work.contacts.keep_listed(q)


def _next_drag(drag: float, error: float, size: float, fraction: float) -> float:
    """Return the drag [E r] after a step of a size whose linear answer was wrong by an error [r]."""
    if error < LINEAR * size and fraction > 0.5:
        return 0.1 * drag if 0.1 * drag >= LEAST_DRAG else 0.0
    return 4.0 * max(drag, LEAST_DRAG) if error > CURVED * size else drag

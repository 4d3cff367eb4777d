"""One equilibrium: Newton on the exact stiffness, with friction's loads brought along.

Two stages. First friction keeps the loads of the last equilibrium, so that the
search minimises an energy. Near the end the loads follow the configuration in
every iteration and the search solves the balance of forces itself, so that no
lag is left in the answer; that system is not symmetric, and progress is judged
by the natural monotonicity test (Deuflhard 2004, section 3.3). Where strands snap
there is no balance near by to be found: the search goes back to the energy, with
the loads of the current place, and comes nearer to its minimum before they follow again.
A search that makes no progress is handed to pseudo-transient continuation (`continuation.py`).
"""

from dataclasses import dataclass

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.coupling import coupled_step
from knitlab_core.equilibrium.strands import SMALLEST_FLOOR
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.sums import inner, length

COUPLED = 0.02
"""Accuracy of a step where friction's loads are brought along."""

PATIENCE = 8
"""Iterations in which the residual must be halved; a search that does not is handed to continuation."""

FAR = 10.0
"""Residual above which contacts enter without their geometric stiffness: deep ones make it negative."""

SHORT = 0.07
"""Fraction of a step so short that the balance of forces is not near: a little more than the shortest tried."""

MOST_SHORT = 4
"""So many short steps in a row are a snap."""

FOLLOW_AGAIN = 0.03
"""Largest residual at which loads follow again after a snap; a tenth of it after the next."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How hard to try.

    Parameters
    ----------
    tolerance : float
        Largest free force at an equilibrium, relative to the mean fixture force.
    follow_below : float
        Residual below which friction's loads follow the configuration.
    max_iterations : int
        Give up after so many, whatever the progress.
    room : float
        Share of the way to a neighbour's core that one iteration may use.
    rescue : bool
        Whether a search that makes no progress is handed to continuation, which may pass a snap.
    """

    tolerance: float = 1e-4
    follow_below: float = 1.0
    max_iterations: int = 60
    room: float = 0.8
    rescue: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """How a search ended.

    Parameters
    ----------
    converged : bool
        Whether it is an equilibrium.
    iterations : int
        Newton iterations.
    residual : float
        Largest free force over the mean fixture force.
    node : int
        Where that force acts.
    contacts : int
        Sample pairs that press on each other.
    continued : bool
        Whether pseudo-transient continuation took part, which may pass a snap.
    """

    converged: bool
    iterations: int
    residual: float
    node: int
    contacts: int
    continued: bool = False


@dataclass(slots=True)
class _Loads:
    """Whether friction's loads follow the configuration, the residual from which they do, and the snaps so far."""

    following: bool
    follow_below: float
    short: int = 0
    snapped: bool = False

    def snap(self, fraction: float) -> bool:
        """Count short steps on the balance of forces; return whether they are a snap, and hold the loads if so."""
        self.short = self.short + 1 if fraction <= SHORT else 0
        if self.short < MOST_SHORT:
            return False
        self.following, self.short, self.snapped = False, 0, True
        self.follow_below = min(0.1 * self.follow_below, FOLLOW_AGAIN)
        return True


def blocked(node: int, contacts: int) -> Report:
    """Report a step that was not tried, because its fixtures would drive strands through each other."""
    return Report(converged=False, iterations=0, residual=np.inf, node=node, contacts=contacts)


def force_scale(work: Workspace, gradient: FloatArray) -> float:
    """Return the mean force on fixtures or of loads, at least the floor."""
    held = work.model.fixed[:, :3]
    forces = np.abs(gradient[:, :3][held]) if work.hooks is None else work.hooks.fixture_forces(gradient, held)
    loads = np.abs(work.dead.loads[work.dead.loads != 0.0])
    means = [float(f.mean()) for f in (forces, loads) if f.size]
    # Under drag a slow fall must not be taken for rest.
    return max([SMALLEST_FLOOR if work.drag is not None else work.model.force_floor, *means])


def _search_energy(
    work: Workspace,
    q: FloatArray,
    frames: Frames,
    step: FloatArray,
    residual: FloatArray,
    fraction: float,
) -> float:
    """Shorten a step until the energy falls; return the fraction, 0 if it never does."""
    start = work.energy(q, frames)
    slope = min(inner(residual, step), 0.0)
    size = length(residual)
    free = ~work.model.fixed
    trial_frames = frames.copy()
    for _ in range(20):
        trial = q + fraction * step
        energy = work.energy(trial, frames)
        if energy <= start + 1e-4 * fraction * slope + 1e-13 * abs(start):
            return fraction
        if abs(energy - start) < 1e-9 * abs(start):
            # Too small a change for the energy to tell: let the forces decide.
            follow(trial, work.model.rods.has_edge, frames, trial_frames)
            if length(work.gradient() * free) < size:
                return fraction
        fraction *= 0.5
    return 0.0


def _search_balance(
    work: Workspace,
    q: FloatArray,
    frames: Frames,
    step: FloatArray,
    size: float,
    fraction: float,
    trial_frames: Frames,
) -> tuple[float, FloatArray, int]:
    """Shorten a step until the simplified Newton correction shrinks, at most to a sixteenth.

    Returns the fraction, and gradient and contacts there; the trial's frames are filled, its samples placed.
    """
    free = ~work.model.fixed
    shortest = fraction / 16.0
    while True:
        trial = q + fraction * step
        follow(trial, work.model.rods.has_edge, frames, trial_frames)
        work.move_to(trial, trial_frames)
        contacts = work.lag()
        gradient = work.gradient()
        rest = length(work.stiffness.solve(gradient * free))
        # Friction may have to get worse before it gets better: the shortest step is taken as it is.
        if rest <= (1.0 - 0.25 * fraction) * size or fraction <= shortest:
            return fraction, gradient, contacts
        fraction *= 0.5


def equilibrate(
    work: Workspace, q: FloatArray, frames: Frames, options: Options, motion: FloatArray | None = None
) -> tuple[FloatArray, Frames, FloatArray, Report]:
    """Find the equilibrium near a guess, with fixed unknowns held where they are.

    Parameters
    ----------
    work : Workspace
        Started at the last equilibrium.
    q : (N, 4) array
        Guess.
    frames : Frames
        Frames of the guess; overwritten.
    options : Options
        How hard to try.
    motion : (N, 4) array, optional
        Motion of the fixtures, whose pull shall be kept for the next guess.

    Returns
    -------
    q, frames, gradient, Report
        Configuration, its frames, the gradient there (reactions at fixed
        unknowns), and how it went; an equilibrium only if the report has it converged.
    """
    model, stiffness = work.model, work.stiffness
    free = ~model.fixed
    other = frames.copy()
    hooks_rub = work.hooks is not None and work.hooks.hooks.rubs
    loads = _Loads(following=model.law.friction == 0.0 and not hooks_rub, follow_below=options.follow_below)
    iteration, contacts = 0, 0
    before: list[float] = []
    gradient: FloatArray | None = None
    work.move_to(q, frames)
    while True:
        if gradient is None:
            if loads.following or loads.snapped:
                contacts = work.lag()
            gradient = work.gradient()
        residual = gradient * free
        worst = int(np.argmax(np.abs(residual)))
        relative = float(np.abs(residual.flat[worst])) / force_scale(work, gradient)
        if not loads.following and relative < loads.follow_below:
            loads.following, gradient = True, None
            continue
        report = Report(
            converged=loads.following and relative < options.tolerance,
            iterations=iteration,
            residual=relative,
            node=worst // 4,
            contacts=contacts,
        )
        stalled = options.rescue and iteration > PATIENCE and relative > 0.5 * min(before[:-PATIENCE])
        if report.converged or stalled or iteration >= options.max_iterations or not np.isfinite(relative):
            return q, frames, gradient, report
        before.append(relative)
        work.clock.iterations += 1
        work.assemble(exact=1.0 if loads.following or relative < FAR else 0.0)
        if motion is not None:
            stiffness.pull(motion)
        if not stiffness.factor():
            return q, frames, gradient, report
        step = stiffness.solve(-residual)
        if loads.following and (hooks_rub or (model.law.friction > 0.0 and contacts > 0)):
            size = length(step)
            step = coupled_step(work, step, COUPLED)
            fraction = work.contacts.collision_free_fraction(q, step, options.room)
            fraction, gradient, contacts = _search_balance(work, q, frames, step, size, fraction, other)
            if loads.snap(fraction):
                gradient = None
        else:
            fraction = work.contacts.collision_free_fraction(q, step, options.room)
            fraction = _search_energy(work, q, frames, step, residual, fraction)
            if fraction == 0.0:
                return q, frames, gradient, report
            follow(q + fraction * step, model.rods.has_edge, frames, other)
            gradient = None
        q = q + fraction * step
        frames, other = other, frames
        work.contacts.keep_listed(q)
        iteration += 1

"""Lay a thick yarn into the loops of a periodic cell, and let the cell take the size at which nothing pulls on it.

Real yarn is thicker than the room in its loops: as laid in, its strands overlap. They relax with a contact law of a
smaller size whose force is many times as large, so that strands are pushed apart and not into each other; then the law
grows to its own size and softens to its own force. The lengths of the cell are free meanwhile but in the first part, in
which the yarn is bent into the knit (`dry_relaxation`). What comes out is the fabric at rest.
"""

from dataclasses import dataclass, replace

from knitlab_core.arrays import BoolArray
from knitlab_core.contact.law import scaled_law
from knitlab_core.contact.neighbours import least_distance
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.dry_relaxation import idle, knit_in
from knitlab_core.equilibrium.march import Failure
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_through import THICK, come_to_rest
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError

LAID, CLEAR = 0.6, 0.8
"""Largest size of the contact law as laid in, in its own, and of cores in the least distance of two strands there."""

STIFF = 30.0
"""Force of the contact law until it has its own size, in its own force."""

GROWTH, SHARE = 1.12, 0.6
"""Largest growth of the law in a stage, and share of the room between strands and cores that it may use."""

NEAREST = 1.1
"""Least distance of strands, in twice the core, from which on their law has its own size and force at once."""

SOFTER = 4.0
"""Factor by which the force falls in a stage."""

MOST_STAGES, MOST_MOVES = 60, 600

PATIENT = Options(max_iterations=40, rescue=False)


@dataclass(slots=True)
class _Stage:
    """A stage: the state, the size and the force of the law in its own, and the iterations so far."""

    state: State
    size: float
    force: float
    iterations: int


def relax_cell(model: Model, state: State, *, options: Options = PATIENT) -> tuple[State, int]:
    """Relax a yarn into the loops of a periodic cell, and the cell to the size at which no force acts on it.

    Parameters
    ----------
    model : Model
        The cell, its yarn straight at rest.
    state : State
        The cell as laid in.
    options : Options
        How hard to try.

    Returns
    -------
    State, int
        The equilibrium from which a test begins, and the Newton iterations it took.

    Raises
    ------
    ConvergenceError
        If the yarn comes to no rest.
    """
    # Whichever lengths a test drives, the fabric at rest is the same.
    held = replace(model, fixed=_with_lengths(model, prescribed=True))
    core = model.law.distance - model.law.overlap_limit
    size = min(LAID, CLEAR * least_distance(state.q, model.samples, model.law) / core)
    work = Workspace(_with_law(held, size, STIFF))
    *_, (_, state, _) = knit_in(work, state)
    loose = replace(model, fixed=_with_lengths(model, prescribed=False))
    return _grown(loose, _Stage(state, size, STIFF, work.clock.iterations), options)


def relax_loops(model: Model, state: State, *, options: Options = PATIENT) -> tuple[State, int]:
    """Relax a specimen that was made of the loops of a relaxed cell; its edges are not at rest yet.

    Parameters
    ----------
    model : Model
        The specimen, its yarn straight at rest, its fixtures prescribed.
    state : State
        The specimen as made.
    options : Options
        How hard to try.

    Returns
    -------
    State, int
        The equilibrium from which a test begins, and the Newton iterations it took.

    Raises
    ------
    ConvergenceError
        If the yarn comes to no rest.
    """
    room = least_distance(state.q, model.samples, model.law) / (model.law.distance - model.law.overlap_limit)
    whole = room >= NEAREST
    begun = _Stage(state, 1.0, 1.0, 0) if whole else _Stage(state, min(LAID, CLEAR * room), STIFF, 0)
    return _grown(model, begun, options)


def _grown(loose: Model, begun: _Stage, options: Options) -> tuple[State, int]:
    """Return the equilibrium with the law at its own size and force, and all iterations."""
    stage = _settled(loose, begun, options)
    core = loose.law.distance - loose.law.overlap_limit
    for _ in range(MOST_STAGES):
        if stage.size < 1.0:
            law = scaled_law(loose.law, stage.size, stage.force)
            room = least_distance(stage.state.q, loose.samples, law) / core
            size = min(1.0, GROWTH * stage.size, stage.size + SHARE * (room - stage.size))
            stage = _settled(loose, replace(stage, size=size), options)
        elif stage.force > 1.0:
            stage = _settled(loose, replace(stage, force=max(1.0, stage.force / SOFTER)), options)
        else:
            return idle(stage.state), stage.iterations
    raise ConvergenceError(
        f"yarn that has no room to grow as it is laid in: at {stage.size:.3g} of its size cores touch"
    )


def _with_law(model: Model, size: float, force: float) -> Model:
    return replace(model, law=scaled_law(model.law, size, force))


def _with_lengths(model: Model, *, prescribed: bool) -> BoolArray:
    """Return what is prescribed (N, 4) when the cell's lengths are, or are free; it is not sheared."""
    fixed = model.fixed.copy()
    if model.ties is not None:
        for axis, vector in enumerate(model.ties.cell):
            fixed[vector, axis] = prescribed
    return fixed


def _settled(loose: Model, stage: _Stage, options: Options) -> _Stage:
    """Return the stage at rest with its law."""
    work = Workspace(_with_law(loose, stage.size, stage.force))

    def move(begun: State, drag: float) -> tuple[State | None, Report]:
        return advance(work, begun, begun.q, options, drag=drag)

    found, report = come_to_rest(move, stage.state, drag=THICK, most=MOST_MOVES)
    if found is None:
        raise ConvergenceError(Failure.of(work, stage.state, report, stage.size, "laying in"))
    return replace(stage, state=found, iterations=stage.iterations + work.clock.iterations)

"""Relax a yarn into its loops before a test, as machine-knitted cotton is: it is straight at rest, its loops are not.

    model, state = make_model(strands, ..., straight=True)
    model.fixed[...] = True
    work = Workspace(model)
    *_, (_, state, _) = knit_in(work, state)   # the carriages stay where they are
    state, travel = unload(work, state, ways)  # and then, if wished: to where no axis carries a force

and the test begins from there, its works at zero. There is no friction meanwhile: wet relaxing overcomes it, and a
relaxed state shall not depend on the way to it. It is handed over with every load known and no slip, so that it is
an equilibrium with friction too and nothing jumps when the test begins.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.march import Failure, advance, march
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError, SpecificationError
from knitlab_core.rods.rod import measure_strains

STEPS = 8
"""Steps in which a yarn is relaxed; a step that fails is cut."""

BALANCE = 1e-4
"""Force left on an axis at rest, relative to the sum of what its hooks feel."""

LONGEST_WAY = 4.0
"""Farthest that an axis opens or closes between two equilibria on its way to rest [r]."""

SHORTEST_WAY = 1e-3
"""Where it gives up [r]."""

MOST_WAYS = 100


def knit_in(
    work: Workspace, state: State, *, steps: int = STEPS, options: Options | None = None
) -> Iterator[tuple[float, State, Report]]:
    """Relax a yarn from the shape it was laid in to its equilibrium, with the fixtures where they are.

    The rest shape goes from that of the given configuration, which is free of stress with it, to the model's own.

    Parameters
    ----------
    work : Workspace
        Buffers of a model whose yarn is at rest in another shape than it was laid in: straight, as a rule.
    state : State
        The knit as laid in; only its configuration counts, which need not be an equilibrium.
    steps : int
        Steps of the way; a step that fails is cut as in a march.
    options : Options, optional
        How hard to try.

    Yields
    ------
    share, State, Report
        Share of the way, the equilibrium there and how it was found. The last, at share 1, is that of the model,
        from which a test begins; the yarn of those before is half relaxed.

    Raises
    ------
    SpecificationError
        If strands are fused: points fuse in print, and a printed knit is at rest as it is.
    ConvergenceError
        If no way is found.
    """
    model = work.model
    wet = _wet(model)
    curvature, twist = np.zeros((len(state.q), 2)), np.zeros(len(state.q))
    measure_strains(state.q, wet.rods.is_inner, state.frames, curvature, twist)

    def ease(share: float) -> FloatArray:
        rods = wet.rods._replace(
            rest_curvature=curvature + share * (wet.rods.rest_curvature - curvature),
            rest_twist=twist + share * (wet.rods.rest_twist - twist),
        )
        work.model = replace(wet, rods=rods)
        return state.q

    try:
        for share, found, report in march(work, _begun(state), ease, longest=1.0 / steps, options=options):
            # Whoever takes the state finds the model it began with.
            work.model = model
            yield share, _begun(found), report
    finally:
        work.model = model


def unload(
    work: Workspace, state: State, ways: Sequence[FloatArray], *, options: Options | None = None
) -> tuple[State, FloatArray]:
    """Open or close the axes until none carries a force: the size to which a knit relaxes by itself.

    Parameters
    ----------
    work : Workspace
        Buffers of the model.
    state : State
        An equilibrium, as `knit_in` ends with.
    ways : sequence of (N, 4) arrays
        For each axis, how far its opening by 1 r moves every fixed unknown [1].
    options : Options, optional
        How hard to try.

    Returns
    -------
    State, (K,) array
        The equilibrium at rest, and how far each axis opened [r].

    Raises
    ------
    SpecificationError
        If strands are fused.
    ConvergenceError
        If no way is found.

    Notes
    -----
    Forces of axes are the slopes of the energy of equilibria over their openings, so this is Newton's method on that
    energy, with steps that lower it.
    """
    model = work.model
    along = np.stack(ways)
    opened = np.zeros(len(along))
    work.model = _wet(model)
    try:
        for _ in range(MOST_WAYS):
            force = _forces(along, state.reaction)
            if (np.abs(force) <= BALANCE * _forces(np.abs(along), np.abs(state.reaction))).all():
                return _begun(state), opened
            step = _towards_rest(_stiffness(work, state, along), force)
            state, step = _lower(work, state, along, step, options)
            opened += step
    finally:
        work.model = model
    raise ConvergenceError

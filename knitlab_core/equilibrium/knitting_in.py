"""Relax a yarn into its loops before a test, as machine-knitted cotton is: straight at rest, bent by its neighbours.

    model, state = make_model(strands, ..., straight=True)
    model.fixed[...] = True
    work = Workspace(model)
    *_, (_, state, _) = knit_in(work, state)

and the test begins from this state: what is stored in it is stored from the start, its works are nought.

Friction acts meanwhile. It is what holds such a knit together: without it the yarn slides through its loops until
they let go of each other (docs/decisions/0010).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import SpecificationError
from knitlab_core.rods.rod import measure_strains

STEPS = 8
"""Steps in which a yarn is relaxed."""

PATIENT = Options(max_iterations=100)
"""Loops that are slack, or snap to the other side of the fabric, take more iterations than a test's steps."""


def knit_in(
    work: Workspace, state: State, *, steps: int = STEPS, options: Options = PATIENT
) -> Iterator[tuple[float, State, Report]]:
    """Relax a yarn from the shape it was laid in to its equilibrium, with the fixtures where they are.

    The rest shape goes evenly from that of the given configuration, which is free of stress with it, to the model's.

    Parameters
    ----------
    work : Workspace
        Buffers of a model whose yarn is at rest in another shape than it was laid in: straight, as a rule.
    state : State
        The knit as laid in. Only its configuration counts, which need not be an equilibrium of the model.
    steps : int
        Steps of the way; one that fails is cut, as in a march.
    options : Options
        How hard to try.

    Yields
    ------
    share, State, Report
        Share of the way, the equilibrium there and how it was found. The last, the second at share 1, is that from
        which a test begins; the yarn of those at smaller shares is half relaxed.

    Raises
    ------
    SpecificationError
        If strands are fused: points fuse in print, and a printed knit is at rest as it is.
    ConvergenceError
        If a step finds no equilibrium however short.

    Notes
    -----
    What relaxes (Prony) has done so when the test begins: it stores and carries what lasts.
    """
    model = work.model
    settled = _settled(model)
    curvature, twist = np.zeros((len(state.q), 2)), np.zeros(len(state.q))
    measure_strains(state.q, settled.rods.is_inner, state.frames, curvature, twist)

    def ease(share: float) -> FloatArray:
        rods = settled.rods._replace(
            rest_curvature=curvature + share * (settled.rods.rest_curvature - curvature),
            rest_twist=twist + share * (settled.rods.rest_twist - twist),
        )
        work.model = replace(settled, rods=rods)
        return state.q

    try:
        last = _idle(state)
        for share, found, report in march(work, last, ease, longest=1.0 / steps, options=options):
            # Whoever takes the state finds the model it gave.
            work.model, last = model, found
            yield share, _idle(found), report
        # Friction comes to rest, so that nothing stirs in the test before the fixtures do.
        for _, found, report in march(work, last, lambda _: ease(1.0), longest=1.0, options=options):
            work.model = model
            yield 1.0, _idle(found), report
    finally:
        work.model = model


def _settled(model: Model) -> Model:
    """Return a model with no more stiffness than lasts, and nothing left to relax."""
    if model.bonds is not None:
        raise SpecificationError("model.bonds", f"{model.bonds.a.size} fused points", "none in a yarn to be knitted in")
    if model.relaxation is None:
        return model
    lasting = model.relaxation.lasting
    rods = model.rods._replace(
        stretch_stiffness=lasting * model.rods.stretch_stiffness,
        bend_stiffness=lasting * model.rods.bend_stiffness,
        twist_stiffness=lasting * model.rods.twist_stiffness,
    )
    return replace(model, rods=rods, relaxation=None)


def _idle(state: State) -> State:
    """Return a state from which a test may begin: it remembers its contacts, but no work and no motion."""
    return replace(
        state,
        increment=np.zeros_like(state.q),
        external_work=0.0,
        friction_work=0.0,
        history=None,
        viscous_work=0.0,
        fracture_work=0.0,
    )

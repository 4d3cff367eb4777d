"""Relax a yarn into its loops before a test, as machine-knitted cotton is: straight at rest, bent by its neighbours.

    model, state = make_model(strands, ..., straight=True)
    model.fixed[...] = True
    work = Workspace(model)
    *_, (_, state, _) = knit_in(work, state)

and the test begins from this state: what is stored in it is stored from the start, its works are zero.

Friction acts meanwhile. It is what holds such a knit together: without it the yarn slides through its loops until
they let go of each other. Where loops snap, the yarn moves as through a viscous fluid that thins out, so that they
come down where they stand (docs/decisions/0010).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from knitlab_core.equilibrium.march import Failure, advance
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_through import BRISK, come_to_rest
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError, SpecificationError
from knitlab_core.rods.rod import Rods, measure_strains

STEPS = 16
"""Steps in which a yarn is relaxed."""


def knit_in(
    work: Workspace, state: State, *, steps: int = STEPS, options: Options = BRISK
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
        Steps of the way.
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
        If a yarn comes to no rest.

    Notes
    -----
    What relaxes (Prony) has done so when the test begins: it stores and carries what lasts.
    """
    model = work.model
    settled = _settled(model)
    curvature, twist = np.zeros((len(state.q), 2)), np.zeros(len(state.q))
    measure_strains(state.q, settled.is_inner, state.frames, curvature, twist)

    def eased(share: float) -> Rods:
        return settled._replace(
            rest_curvature=curvature + share * (settled.rest_curvature - curvature),
            rest_twist=twist + share * (settled.rest_twist - twist),
        )

    last = _idle(state)
    # Once more at the end: friction comes to rest, so that nothing stirs in the test before the fixtures do.
    for share in [*((step + 1) / steps for step in range(steps)), 1.0]:
        last, report = _come_to_rest(work, last, eased(share), options, share)
        yield share, last, report


def _come_to_rest(work: Workspace, state: State, rods: Rods, options: Options, share: float) -> tuple[State, Report]:
    """Return the equilibrium with the fixtures where they are, and how it was found, all iterations counted."""

    def move(begun: State, drag: float) -> tuple[State | None, Report]:
        found, report = advance(work, begun, begun.q, options, rods=rods, drag=drag)
        return (None if found is None else _idle(found)), report

    found, report = come_to_rest(move, state)
    if found is not None:
        return _idle(found), report
    x, y, z = state.q[report.node, :3] * work.model.scales.length
    place = (float(x), float(y), float(z))
    raise ConvergenceError(Failure(progress=share, report=report, position=place, way="relaxing into the knit"))


def _settled(model: Model) -> Rods:
    """Return rods with no more stiffness than lasts."""
    if model.bonds is not None:
        raise SpecificationError("model.bonds", f"{model.bonds.a.size} fused points", "none in a yarn to be knitted in")
    if model.relaxation is None:
        return model.rods
    lasting = model.relaxation.lasting
    return model.rods._replace(
        stretch_stiffness=lasting * model.rods.stretch_stiffness,
        bend_stiffness=lasting * model.rods.bend_stiffness,
        twist_stiffness=lasting * model.rods.twist_stiffness,
    )


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
        snap_work=0.0,
    )

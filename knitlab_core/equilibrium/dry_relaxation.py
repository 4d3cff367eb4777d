"""Relax a yarn into its loops before a test, as machine-knitted cotton is: straight at rest, bent by its neighbours.

    model, state = make_model(strands, ..., straight=True)
    model.fixed[...] = True
    work = Workspace(model)
    *_, (_, state, _) = knit_in(work, state)

and the test begins from this state: what is stored in it is stored from the start, its works are zero.

Friction acts meanwhile. It is what holds such a knit together: without it the yarn slides through its loops until
they let go of each other. What friction does depends on the path, so no step is longer than the path allows: none in
which a node goes farther than `REACH`. Where even a short step would, loops snap. They are followed down as through a
viscous fluid that thins out, in moves that are no longer (docs/decisions/0010).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import Failure
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_through import THICK, come_to_rest, longest_way
from knitlab_core.equilibrium.step_control import LARGEST_CHANGE, Pace, StepControl
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError, SpecificationError
from knitlab_core.rods.rod import Rods, measure_strains

STEPS = 16
"""Fewest steps in which a yarn is relaxed."""

REACH = 2.0
"""Farthest that a node may go in a step or a move [r], where the fewest steps are `STEPS`."""

MOST_MOVES = 2000
"""Moves in which a snap must come to rest: the end of a yarn that slips out of its loop goes 50 r in short ones."""

DIRECT = Options(max_iterations=20, rescue=False)
"""No rescue: continuation would pass a snap in moves of any length."""


def knit_in(
    work: Workspace, state: State, *, steps: int = STEPS, options: Options = DIRECT
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
        Fewest steps of the way. They are made shorter, down to 1/16, where nodes would go farther than
        `REACH` * `STEPS` / `steps`.
    options : Options
        How hard to try.

    Yields
    ------
    share, State, Report
        Share of the way, the equilibrium there and how it was found, with the iterations of all searches since the
        one before. The last, the second at share 1, is that from which a test begins; the yarn of those at smaller
        shares is half relaxed.

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
    settled = settled_rods(model)
    curvature, twist = np.zeros((len(state.q), 2)), np.zeros(len(state.q))
    measure_strains(state.q, settled.is_inner, state.frames, curvature, twist)

    def eased(share: float) -> Rods:
        return settled._replace(
            rest_curvature=curvature + share * (settled.rest_curvature - curvature),
            rest_twist=twist + share * (settled.rest_twist - twist),
        )

    last, at, still, spent = idle(state), 0.0, False, work.clock.iterations
    control, reach = StepControl.of(1.0 / steps, Pace(), turns=False), REACH * STEPS / steps
    # Once more at the end: friction comes to rest, so that nothing stirs in the test before the fixtures do.
    while not still:
        still, to = at == 1.0, control.goal(at)
        rods = eased(to)
        found, report = advance(work, last, last.q, options, rods=RodTerm(rods))
        change = np.inf if found is None else LARGEST_CHANGE * longest_way(found) / reach
        if not still and control.rejects(change):
            continue
        if found is None or change > LARGEST_CHANGE:
            found, report = follow_down(work, last, rods, options, to, reach)
        control.accept(to, change)
        at, last = to, idle(found)
        yield at, last, replace(report, iterations=work.clock.iterations - spent)
        spent = work.clock.iterations


def follow_down(
    work: Workspace, state: State, rods: Rods, options: Options, share: float, reach: float
) -> tuple[State, Report]:
    """Return the equilibrium that loops come to which snap, with the fixtures where they are, and the last search."""

    def move(begun: State, drag: float) -> tuple[State | None, Report]:
        return advance(work, begun, begun.q, options, rods=RodTerm(rods), drag=drag)

    found, report = come_to_rest(move, state, drag=THICK, most=MOST_MOVES, reach=reach)
    if found is not None:
        return found, report
    raise ConvergenceError(Failure.of(work, state, report, share, "relaxing into the knit"))


def settled_rods(model: Model) -> Rods:
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


def idle(state: State) -> State:
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

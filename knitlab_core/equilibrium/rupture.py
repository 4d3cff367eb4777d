"""Brittle rupture of a fibre: where it is strained most, when that passes the limit, and what is left.

A test that watches for it does, after every equilibrium of a march:

    if weakest(model, found).strain >= limit:
        share, state, edge, report = reach_rupture(work, before, path, limit=limit)
        work, state = break_fibre(work, state, edge)

and marches on with the new workspace from the new state, or ends there: rupture is an outcome.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.friction import Memory
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import Failure, settle_after_break
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_location import with_snap_counted
from knitlab_core.equilibrium.snap_through import kept
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.rupture import cut_history, cut_rods, fibre_strain
from knitlab_core.rods.yielding import cut_plastic

OVERSHOOT = 1e-4
"""How far beyond the limit a fibre is taken when it breaks, relative to the limit."""

MOST_TRIALS = 16
"""Equilibria sought on the way to a rupture before giving up; one that can be reached takes up to 8."""

NARROW = 1.0 / 256.0
"""Share of the step to which a place beyond which nothing is found is narrowed down: strands snap there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """Most strained spot of all fibres: its edge and the strain at its surface [1]."""

    edge: int
    strain: float


def weakest(model: Model, state: State, radius: float = 1.0) -> Spot:
    """Return the most strained spot; of spots strained alike, the first.

    Parameters
    ----------
    model : Model
        Gives the rest shape.
    state : State
        An equilibrium.
    radius : float
        Radius of a fibre [r]; less than 1 where a rod stands for a yarn of several.
    """
    strain = fibre_strain(state.q, model.rods, state.frames, radius)
    edge = int(np.argmax(strain))
    return Spot(edge=edge, strain=float(strain[edge]))


def reach_rupture(
    work: Workspace,
    state: State,
    path: Callable[[float], FloatArray],
    *,
    limit: float,
    radius: float = 1.0,
    options: Options | None = None,
    duration: float = 0.0,
    end: tuple[State, Report] | None = None,
) -> tuple[float, State | None, int, Report | None]:
    """Find where on a step the first fibre reaches its limit.

    Parameters
    ----------
    work : Workspace
        Buffers of the model.
    state : State
        Equilibrium at parameter 0 of the step, below the limit.
    path : callable
        Target (N, 4) at a parameter; at 1 the limit is passed.
    limit : float
        Strain at which the material breaks [1].
    radius : float
        Radius of a fibre [r].
    options : Options, optional
        How hard to try.
    duration : float
        Time the whole step takes [s].
    end : (State, Report), optional
        Equilibrium at parameter 1 and its search, where they are known.

    Returns
    -------
    share, State or None, edge, Report or None
        Parameter, equilibrium there, at most `OVERSHOOT` beyond the limit, the edge that breaks, and the search that
        found it. None where no such equilibrium was found: a step that snaps passes the limit without reaching it.
        What a snap on the way sets free is in `snap_work`.

    Notes
    -----
    False position with halving (Illinois). Every trial starts from `state`, so that its number leaves no trace
    in what friction and relaxation remember.
    """
    aim, slack = limit * (1.0 + 0.5 * OVERSHOOT), 0.5 * OVERSHOOT * limit
    start = weakest(work.model, state, radius)
    low, high, below, above = 0.0, 1.0, start.strain - aim, np.inf
    at, side, edge = 1.0, 0, start.edge
    found, report = (None, None) if end is None else end
    ahead = None
    for _ in range(MOST_TRIALS):
        if found is None:
            found, report = advance(work, state, path(at), options, duration=at * duration, ahead=ahead)
            found = None if found is None else with_snap_counted(state, found, report)
        if found is None:
            high, above, side = at, np.inf, 0
        else:
            spot = weakest(work.model, found, radius)
            off, edge = spot.strain - aim, spot.edge
            if abs(off) <= slack:
                return at, found, edge, report
            if off < 0.0:
                ahead = found.increment
                low, below, above = at, off, above * (0.5 if side < 0 else 1.0)
            else:
                high, above, below = at, off, below * (0.5 if side > 0 else 1.0)
            side = -1 if off < 0.0 else 1
        if low >= high or (np.isinf(above) and high - low < NARROW):
            break
        at = 0.5 * (low + high) if np.isinf(above) else low + (high - low) * below / (below - above)
        found = None
    return at, None, edge, report


def sever(model: Model, edge: int) -> Model:
    """Cut a fibre: an edge is gone, and its two nodes neither bend, twist nor touch anything.

    Parameters
    ----------
    model : Model
        The model of whole fibres.
    edge : int
        Number of the node that the edge leaves.

    Returns
    -------
    Model
        With loose ends there. Angles that nothing turns any more are fixed.
    """
    rods = cut_rods(model.rods, edge)
    return replace(
        model,
        rods=rods,
        samples=model.samples._replace(spans=np.flatnonzero(rods.is_inner)),
        fixed=model.fixed | _unheld(rods),
    )


def break_fibre(work: Workspace, state: State, edge: int, options: Options | None = None) -> tuple[Workspace, State]:
    """Cut a fibre and let all that hung on it find its balance, with the fixtures where they are.

    The forces that held the cut together are gone at once; a fluid keeps the knit from being thrown (`transient.py`).

    Parameters
    ----------
    work : Workspace
        Buffers of the model of whole fibres.
    state : State
        The equilibrium at which it breaks.
    edge : int
        Number of the node that the broken edge leaves.
    options : Options, optional
        How hard to try.

    Returns
    -------
    Workspace, State
        Buffers of the cut model and the new equilibrium. What the snap sets free, elastic energy that friction
        and relaxation do not use up, is added to `fracture_work`.

    Raises
    ------
    ConvergenceError
        If the broken knit finds no equilibrium.
    """
    state = _torn(work.model, state, edge)
    left = Workspace(sever(work.model, edge), work.clock)
    left.dead.loads[:] = work.dead.loads
    found, report = settle_after_break(left, state, options)
    if found is None:
        raise ConvergenceError(Failure.of(left, state, report, 0.0, "the break of a fibre"))
    free = kept(state) - kept(found) - (found.bonds.released - state.bonds.released)
    return left, replace(found, fracture_work=state.fracture_work + free, snap_work=state.snap_work)


def _torn(model: Model, state: State, edge: int) -> State:
    """Take away what acted at the two nodes where a fibre breaks: friction, and fused points with their energy.

    What relaxes remembers strains of spans; the two nodes keep those of half edges.
    """
    state = replace(state, memory=_untouched(model, state, edge))
    if state.history is not None:
        state = replace(state, history=cut_history(state.history, model.rods, edge))
    if state.plastic is not None and model.yielding is not None:
        state = replace(state, plastic=cut_plastic(state.plastic, model.yielding, edge))
    if model.bonds is None:
        return state
    at = [edge, edge + 1]
    torn = np.isin(model.bonds.span_a, at) | np.isin(model.bonds.span_b, at)
    bonds = state.bonds
    left = bonds._replace(hold=np.where(torn, 0.0, bonds.hold), load=np.where(torn, 0.0, bonds.load))
    return replace(state, bonds=left)


def _untouched(model: Model, state: State, edge: int) -> Memory:
    """Return what friction remembers but for pairs at the two nodes, which touch nothing any more."""
    memory, m = state.memory, len(model.samples.weights)
    nodes = np.stack([memory.key // (len(state.q) * m), memory.key % (len(state.q) * m)]) // m
    keep = ~np.isin(nodes, [edge, edge + 1]).any(axis=0)
    return Memory(memory.key[keep], *(values[keep] for values in memory[1:]))


def _unheld(rods: Rods) -> BoolArray:
    """Mark unknowns (N, 4) that nothing turns: angles of no edge, or of an edge left alone."""
    bends = rods.is_inner | np.append(rods.is_inner[1:], False)
    unheld = np.zeros((rods.has_edge.size, 4), dtype=np.bool_)
    unheld[:, 3] = ~(rods.has_edge & bends)
    return unheld

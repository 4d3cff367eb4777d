"""Snap-through: strands that snap come to rest, with the fixtures where they are.

Past a limit point, or after a fibre broke, there is no equilibrium near by. Strands then move as through a viscous
fluid that thins out: each move minimises the energy and a drag c |x - x0|^2 / 2 to where it began, an implicit Euler
step of pseudo-time 1 / c. Only what is found without drag is an equilibrium.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.sparse.sums import inner

BRISK = Options(max_iterations=25)
"""A search that takes longer is of a loop that snaps: it is cheaper to follow it down."""

THICK, THIN, SOLID = 1e-3, 1e-9, 1e3
"""First drag of the fluid, the last before it is gone, and one in which nothing moves [E r].

A loop resists its bending by about 1e-6.
"""

THINNER, THICKER = 0.25, 8.0
"""Factors of the drag after a move that was easy, and after one that failed."""

EASY = 10
"""Iterations of an easy move."""

EASY_SEARCH = 20
"""Iterations from which on a search without drag may have passed a snap, however little that set free."""

MOST_MOVES = 400

Search = Callable[[State, float], tuple[State | None, Report]]
"""Goes from a state to the next one under a drag [E r], the fixtures at the end of the step."""


def come_to_rest(
    search: Search, state: State, *, drag: float = 0.0, most: int = MOST_MOVES, reach: float = np.inf
) -> tuple[State | None, Report]:
    """Follow a snap to its end.

    Parameters
    ----------
    search : callable
        Makes one move.
    state : State
        Where it begins; its forces need not be in balance.
    drag : float
        That of the first move [E r].
    most : int
        Moves after which to give up.
    reach : float
        Farthest that a node may go in a move [r]; a longer one is made again with more drag.

    Returns
    -------
    State or None, Report
        The equilibrium without drag, None where none was found, and the last move with the iterations of all.
        What the snap set free and nothing took up is added to `snap_work`.
    """
    begun, spent, moves = state, 0, 0
    while True:
        found, report = search(state, drag)
        way = 0.0 if found is None else longest_way(found)
        easy = report.iterations <= EASY and way <= THINNER * reach
        found = found if way <= reach else None
        spent, moves = spent + report.iterations, moves + 1
        report = replace(report, iterations=spent)
        if found is not None and drag == 0.0:
            return _with_loss(begun, found), report
        if found is None:
            drag = THICKER * drag if drag >= THIN else THICK
        else:
            state = found
            if easy:
                drag = THINNER * drag if THINNER * drag >= THIN else 0.0
        if drag > SOLID or moves == most:
            return None, report


def counted(before: State, after: State) -> State:
    """Count what a search set free that passed a snap by itself: more than the rule of its work can be wrong by.

    The work of fixtures is taken by the trapezium rule, which errs by no more than half the change of their force
    times their way as long as that force goes one way.
    """
    return _with_loss(before, after) if kept(before) - kept(after) > doubt(before, after) else after


def jumps_between(before: State, after: State) -> bool:
    """Return whether a fibre or a fused point broke, or strands snapped, between one equilibrium and the next."""
    broke = before.fracture_work != after.fracture_work or before.bonds.whole.sum() != after.bonds.whole.sum()
    return broke or after.snap_work - before.snap_work > doubt(before, after)


def doubt(before: State, after: State) -> float:
    """Return by how much the trapezium rule of the work of a step can be wrong [E r^3]."""
    return 0.5 * abs(inner(after.reaction - before.reaction, after.increment))


def doubt_of_each(before: State, after: State) -> float:
    """Return the same where the forces of fixtures may change against each other [E r^3]."""
    return 0.5 * inner(np.abs(after.reaction - before.reaction), np.abs(after.increment))


def _with_loss(before: State, after: State) -> State:
    return replace(after, snap_work=before.snap_work + kept(before) - kept(after))


def longest_way(state: State) -> float:
    """Return how far the node went that moved most since the equilibrium before [r]."""
    return farthest(state.increment)


def farthest(motion: FloatArray) -> float:
    """Return how far the node goes that moves most in a motion (N, 4) [r]."""
    x, y, z = motion[:, :3].T
    return float(np.sqrt(x * x + y * y + z * z).max())


def kept(state: State) -> float:
    """Return what is stored or was lost to friction, relaxing and yielding, less what was put in [E r^3]."""
    lost = state.friction_work + state.viscous_work + state.plastic_work - state.external_work
    return float(state.energies.sum()) + state.bonds.energy + lost

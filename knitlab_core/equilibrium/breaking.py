"""Bonds that break on the way from equilibrium to equilibrium.

A step goes no farther than to where the next bond is at its strength, so that the peak is kept whatever the
step. Then comes the break: at the same fixtures, again and again until no bond is at its strength.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from knitlab_core.arrays import BoolArray
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Report

TRIES = 12
"""Steps tried before a bond may break beyond its strength: its load jumps, as where strands snap."""

NOTHING = 1e-4
"""Share of a bond's stiffness that may be let go in one go, whatever the way there."""

Search = Callable[[State, float, float], tuple[State | None, Report]]
"""Goes from a state at one parameter of the path to the equilibrium at another; no bond breaks on the way."""

Settle = Callable[[State], tuple[State | None, Report]]
"""Goes from a state some of whose bonds have let go to the equilibrium without them, the fixtures where they are."""


def reach(
    search: Search, settle: Settle, state: State, locate: float, start: float, goal: float
) -> tuple[float, State | None, Report]:
    """Break the bonds that are at their strength, then go on, at most to where the next one is.

    Parameters
    ----------
    search : callable
        Finds one equilibrium.
    settle : callable
        Finds the equilibrium after a break.
    state : State
        The last equilibrium.
    locate : float
        A bond breaks from 1 - locate of its strength on.
    start, goal : float
        Parameter of the last equilibrium, and that of the one wanted.

    Returns
    -------
    float, State or None, Report
        Parameter reached, the equilibrium there with no bond beyond its strength (None where a search failed),
        and the last search, with the iterations of all.
    """
    at, to = start, goal
    spent, tries = 0, 0
    while True:
        broken = break_due(settle, state, locate)
        found, report = search(state, at, to) if broken is None else broken
        spent += report.iterations
        report = replace(report, iterations=spent)
        if found is None:
            return to, None, report
        if broken is not None:
            state = found
            continue
        load = float(found.bonds.load.max(initial=0.0))
        if load <= 1.0:
            return to, found, report
        tries += 1
        if tries >= TRIES:
            at, state = to, found
            continue
        begin = float(state.bonds.load.max(initial=0.0))
        share = (1.0 - 0.5 * locate - begin) / (load - begin)
        to = at + min(max(share, 0.1), 0.9) * (to - at)


def break_due(settle: Settle, state: State, locate: float) -> tuple[State | None, Report] | None:
    """Break the bonds that are at their strength, the fixtures where they are; None where there is no such bond.

    Returns
    -------
    (State or None, Report) or None
        The equilibrium without them, in which others may be at their strength; None where none was found.
    """
    due = state.bonds.load >= 1.0 - locate
    return _break(settle, state, due) if due.any() else None


def _break(settle: Settle, state: State, due: BoolArray) -> tuple[State | None, Report]:
    """Find the equilibrium without the bonds that are due: in one go, or else weakening them by a factor at a time.

    Where there is no way in one go, even steps of stiffness are no better: most of
    the motion happens when a hundredth of it is left.
    """
    found, left, factor, spent = state, 1.0, 0.0, 0
    while True:
        rest = left * factor if left * factor > NOTHING else 0.0
        bonds = found.bonds._replace(hold=np.where(due, rest, found.bonds.hold))
        weaker, report = settle(replace(found, bonds=bonds))
        spent += report.iterations
        report = replace(report, iterations=spent)
        if weaker is not None:
            found, left = weaker, rest
        elif factor < 0.5:
            factor = 0.5 if factor > 0.0 else 0.25
        else:
            return None, report
        if left == 0.0:
            return _released(state, found), report


def _released(before: State, after: State) -> State:
    """Count what a break released: what is no longer stored, less the work of friction; it takes no time."""
    lost = _stored(before) - _stored(after)
    after = replace(after, snap_work=before.snap_work)
    pushed = after.external_work - before.external_work
    rubbed = after.friction_work - before.friction_work
    return replace(after, bonds=after.bonds._replace(released=before.bonds.released + lost + pushed - rubbed))


def _stored(state: State) -> float:
    return float(state.energies.sum()) + state.bonds.energy

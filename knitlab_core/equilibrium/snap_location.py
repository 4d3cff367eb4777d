"""Where in a long step strands snap: the step is gone again in shorter ones, so that the snap's peak is kept.

Up to the snap a step is a trial, which is given up as soon as it is slow: then it is taken for one that snaps. The
shortest of those goes through the snap, and from there one step leads to the end of the long one; what the long step
found there is the guess for both, and is taken as it is where they fail. So no snap is followed down twice.
"""

from dataclasses import dataclass, replace

from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import PATIENCE, Options, Report
from knitlab_core.equilibrium.snap_through import EASY_SEARCH, counted, doubt, doubt_of_each, kept

SUDDEN = 1e-4
"""Least loss of a snap whose place is searched for, as a share of what is stored or was lost so far."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedSnap:
    """A snap that a long step passed.

    Attributes
    ----------
    beyond, report
        Equilibrium at the end of that step, and its search.
    to, step : float
        Parameter of the path there, and length of the step.
    crossed : bool
        Whether a short step went through the snap since.
    """

    beyond: State
    report: Report
    to: float
    step: float
    crossed: bool = False


def trial_options(options: Options | None) -> Options:
    """Return how hard a trial searches: no longer than patience lasts, and without continuation."""
    wanted = options or Options()
    return replace(wanted, max_iterations=min(wanted.max_iterations, PATIENCE), rescue=False)


def snaps(before: State, after: State, *, quickly: bool = False) -> bool:
    """Tell whether strands snap between two equilibria, hard enough for the place to be searched for.

    The work that is missing must be more than the trapezium rule can be wrong by; after a search that was quick, which
    hardly passes a snap, more than it can be wrong by on each of the fixtures.
    """
    lost = after.friction_work + after.viscous_work + after.snap_work
    size = float(after.energies.sum()) + after.bonds.energy + lost
    wrong = doubt_of_each(before, after) if quickly else doubt(before, after)
    # Where no fixture moved, loads grew or yarn relaxed: the work of that is not known as well.
    return wrong > 0.0 and kept(before) - kept(after) > max(wrong, SUDDEN * size)


def with_snap_counted(before: State, after: State, report: Report) -> State:
    """Return the end of a step with what a snap on it set free in `snap_work`, if its search may have passed one.

    Every step that becomes a row goes through here, also one that ends where a fibre breaks.
    """
    slow = report.continued or report.iterations > EASY_SEARCH
    return counted(before, after) if slow or snaps(before, after, quickly=True) else after

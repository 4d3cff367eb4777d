"""Draw the axes apart until each carries a force, and stop it there."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from rigs.motion import PRELOAD_REACH
from rigs.record import Outcome
from rigs.rig import read
from rigs.way import between

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from knitlab_core.equilibrium.model import State
    from rigs.bench import Bench
    from rigs.cursor import Displacement
    from rigs.motion import Stroke
    from rigs.record import Equilibrium
    from rigs.steps import Axis
    from rigs.way import Step

TOLERANCE: Final = 5e-3
"""An axis stops within this share of its force."""

MOST_REFINEMENTS: Final = 40


def preload(
    bench: Bench, stroke: Stroke, force: float, increment: float
) -> Generator[Equilibrium, None, Outcome | None]:
    """Move the axes of a stroke until each has met a force.

    An axis that has met it stays where it is while the other goes on, as with a stop switch: what it carries in the
    end is no longer controlled.

    Parameters
    ----------
    bench : Bench
        The test under way.
    stroke : Stroke
        Where the axes would go at most.
    force : float
        Load at which an axis stops [N].
    increment : float
        Largest strain between two rows [1].

    Yields
    ------
    Equilibrium
        Every row on the way; none lies beyond a stop.

    Returns
    -------
    Outcome or None
        A limit, if the reach of a preload or an instrument's range is used up before.
    """
    kept = bench.cursor.variables
    share = kept.get("share", 0.0)
    pace = increment / bench.strain(stroke.start, stroke.end)
    stopped = {axis: stroke.start[axis] for axis in stroke.end if stroke.start[axis] == stroke.end[axis]}
    stopped |= {axis: kept[_stop(axis)] for axis in stroke.end if _stop(axis) in kept}

    def where(share: float) -> Displacement:
        return {**between(stroke.start, stroke.end, share), **stopped}

    def excess(state: State) -> float:
        felt = read(bench.rig, state).force
        return max(felt[axis] / force - 1.0 for axis in stroke.end if axis not in stopped)

    while True:
        felt = read(bench.rig, bench.state).force
        met = (axis for axis in stroke.end if felt[axis] >= (1.0 - TOLERANCE) * force)
        stopped = {**{axis: bench.displacement[axis] for axis in met}, **stopped}
        if len(stopped) == len(stroke.end):
            return None
        if share >= 1.0:
            short = ", ".join(f"axis {axis} carries {felt[axis]:.3g} N" for axis in stroke.end if axis not in stopped)
            reach = f"preload of {force:g} N not met within a strain of {PRELOAD_REACH:g}"
            return Outcome(end="limit", message=f"{reach}: {short}")
        step, share = _approach(bench, where, excess, (share, min(1.0, share + pace)), stroke.duration)
        bench.time = bench.cursor.begun + share * stroke.duration
        bench.note(share=share, **{_stop(axis): at for axis, at in stopped.items()})
        yield bench.accept(step, stroke.phase, stroke.cycle, stroke.tag)
        ended = bench.outcome()
        if ended is not None:
            return ended


def _stop(axis: Axis) -> str:
    """Return the name under which the place is kept where an axis stopped."""
    return f"stop_{axis}"


def _approach(
    bench: Bench,
    where: Callable[[float], Displacement],
    excess: Callable[[State], float],
    bracket: tuple[float, float],
    duration: float,
) -> tuple[Step, float]:
    """Return the equilibrium at the end of a bracket of shares, or before it where `excess` is zero.

    A fibre that ends the test by breaking ends it there. The whole stroke would take the `duration` [s].
    """
    low, high = bracket
    begin = low
    share, found = high, bench.reach(where(high), duration=(high - begin) * duration)
    under, over = excess(bench.state), excess(found.state)
    if over <= TOLERANCE:
        return found, begin + found.share * (share - begin) if found.final else share
    for _ in range(MOST_REFINEMENTS):
        # Regula falsi, kept from either end: the force is nought while the knit is slack.
        share = low + (high - low) * min(max(under / (under - over), 0.1), 0.9)
        tried = bench.reach(where(share), duration=(share - begin) * duration)
        found = replace(
            tried,
            iterations=found.iterations + tried.iterations,
            factorisations=found.factorisations + tried.factorisations,
            seconds=found.seconds + tried.seconds,
        )
        value = excess(found.state)
        if abs(value) <= TOLERANCE or (tried.final and value < 0.0):
            share = begin + tried.share * (share - begin) if tried.final else share
            break
        if value > 0.0:
            high, over = share, value
        else:
            low, under = share, value
    return found, share

"""Length of a march's steps, chosen by the error of friction's path instead of by how easily a search converges.

Where strands touch, lock or turn back, the slip rate has a kink, and a step across it leaves friction's forces wrong
for the rest of the test. `slip_change` measures that; a step with too much of it is gone again in shorter ones.
All lengths are 1, 1/2, 1/4, ... of the longest step and start on multiples of themselves, so that the same way is
always gone over the same places.
"""

from dataclasses import dataclass

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.friction import STEADY, Lead, Memory, slip_change
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.sparse.sums import inner, length

LARGEST_CHANGE = 0.5
"""Largest change of slip in a step; see `friction.slip_change`."""

FAR_BEYOND = 0.65
"""Change of slip from which the next trial is a quarter of the step instead of half."""

SHRINK, GROW = 0.35, 0.25
"""Change of slip from which the next step is halved, and up to which it is doubled."""

IMPORTANT = 0.02
"""Share of the largest loads so far from which on a change of slip counts in full."""

FINEST = 1.0 / 16.0
"""Shortest step for the sake of friction, relative to the longest."""

SMALLEST = 1.0 / 256.0
"""Shortest step tried before giving up, relative to the longest."""

SNAP = 0.25
"""Step from which on a failed search is taken for a snap, relative to the longest; cutting it further costs more."""

LONGEST_RATIO = 2.5
"""Largest ratio of a step to the one before that tells how slip, or the configuration, goes on."""

ALONG = 0.999
"""Cosine of the angle within which two motions of the fixtures have one direction."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of the fixtures in a step against that of the step before.

    Attributes
    ----------
    ratio : float
        Length of this step over that of the one before [1]; 0 where either stood still.
    cosine : float
        Cosine of the angle between the two [1].
    """

    ratio: float
    cosine: float

    @classmethod
    def of(cls, state: State, motion: FloatArray, fixed: BoolArray) -> "Motion":
        """Compare a motion (N, 4) of the fixed unknowns with the increment of the last equilibrium."""
        before, now = state.increment * fixed, motion * fixed
        travel, last = length(now), length(before)
        if travel == 0.0 or last == 0.0:
            return cls(0.0, 0.0)
        return cls(travel / last, inner(before, now) / (travel * last))

    @property
    def goes_on(self) -> bool:
        """Whether the fixtures go on as before, not too far for what was learnt there."""
        return self.cosine > ALONG and self.ratio <= LONGEST_RATIO

    @property
    def turns(self) -> bool:
        """Whether the fixtures set out in another direction than they came from."""
        return self.ratio > 0.0 and self.cosine <= ALONG


def lead_of(state: State, motion: Motion) -> Lead:
    """Return how slip is extrapolated in a step: not at all after a kink."""
    if not motion.goes_on or state.slip_change > LARGEST_CHANGE:
        return STEADY
    return Lead(motion.ratio / (1.0 + motion.ratio), motion.ratio)


def path_error(before: State, memory: Memory, motion: Motion, model: Model) -> tuple[float, float]:
    """Return the error of friction's path in a step [1], and the largest sum of loads so far [E r^2].

    It is the change of slip; less where strands hardly press on each other, against what they did so far: what is
    wrong there is soon forgotten.
    """
    change, loads = slip_change(before.memory, memory, motion.ratio, model.law.slip)
    largest = max(before.largest_load, loads)
    if motion.ratio == 0.0 or loads == 0.0:
        return 0.0, largest
    return change * min(1.0, loads / (IMPORTANT * max(largest, model.force_floor))), largest


@dataclass(slots=True, kw_only=True)
class Pace:
    """Position of a march; kept up to date, so that another can resume from there.

    Attributes
    ----------
    at : float
        Parameter of the last equilibrium.
    step : float or None
        Length of the next step; None at the start of a march.
    """

    at: float = 0.0
    step: float | None = None


@dataclass(slots=True)
class StepControl:
    """Lengths of the steps of one march, as shares of its way.

    Attributes
    ----------
    longest : float
        Longest step, a whole part of the way.
    step : float
        The next step.
    snap_tried : bool
        Whether a snap was tried since the last equilibrium.
    """

    longest: float
    step: float
    snap_tried: bool = False

    @classmethod
    def of(cls, longest: float, pace: Pace, *, turns: bool) -> "StepControl":
        """Begin a march, or go on with one; the first step is a short one where rubbing strands turn back."""
        whole = 1.0 / max(1, int(np.ceil(1.0 / longest - 1e-9)))
        first = FINEST * whole if turns else whole
        return cls(whole, first if pace.step is None else pace.step)

    def goal(self, at: float) -> float:
        """Return the next multiple of the step; a march that stopped at a break goes back to it."""
        steps = at / self.step
        to = at + self.step if abs(steps - round(steps)) < 1e-6 else self.step * float(np.ceil(steps))
        return 1.0 if to > 1.0 - 1e-9 else to

    def tries_snap(self) -> bool:
        """Whether a search that failed is taken for one of strands that snap: at a short step, and at the shortest."""
        short = self.step < 1.5 * SNAP * self.longest and not self.snap_tried
        self.snap_tried = self.snap_tried or short
        return short or self.step < 2.0 * SMALLEST * self.longest

    def cut(self) -> bool:
        """Halve the step after a search that failed; return False if it is as short as may be."""
        self.step *= 0.5
        return self.step >= SMALLEST * self.longest

    def rejects(self, change: float) -> bool:
        """Whether slip changed too much in a step that can be shorter; if so, shorten it."""
        finest = FINEST * self.longest
        if change <= LARGEST_CHANGE or self.step < 1.5 * finest:
            return False
        self.step = max(finest, self.step * (0.25 if change > FAR_BEYOND else 0.5))
        return True

    def accept(self, at: float, change: float) -> None:
        """Choose the next step after one that ended at `at`; it grows only where the longer one is on its own grid."""
        self.snap_tried = False
        doubled = at / (2.0 * self.step)
        if self.step < self.longest and change <= GROW and abs(doubled - round(doubled)) < 1e-6:
            self.step = min(2.0 * self.step, self.longest)
        elif change > SHRINK and self.step > 1.5 * FINEST * self.longest:
            self.step *= 0.5

"""Search for coordinates at which a test comes to what is wanted: a design that fills the space, then proposals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.surrogate import Goal, Prediction, Surrogate, candidates, ranked, widening_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigs.axes import FloatArray

    Evaluate = Callable[[Sequence[FloatArray]], Sequence[FloatArray | None]]
    Encode = Callable[[FloatArray], FloatArray]
    Allowed = Callable[[FloatArray], bool]

MOST_REFUSED: Final = 60
"""Candidates of a round that may be refused before the round goes without."""

NEAREST: Final = 3
"""Tests about which candidates are looked for."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """One test of a search.

    Attributes
    ----------
    z : FloatArray, shape (d,)
        Its coordinates.
    round : int
        0 of the first design.
    features : FloatArray or None
        What it came to (m,); None if it could not be carried out.
    distance : float
        From what is wanted [1]; inf if it could not be carried out.
    predicted : Prediction or None
        What the surrogate expected before; None in the first design.
    """

    z: FloatArray
    round: int
    features: FloatArray | None
    distance: float
    predicted: Prediction | None = None


def search(
    evaluate: Evaluate,
    goal: Goal,
    design: Sequence[FloatArray],
    *,
    within: float,
    rounds: int,
    encode: Encode = lambda z: z,
    snap: Encode = lambda z: z,
    allowed: Allowed = lambda _: True,
) -> list[Trial]:
    """Return the tests of a search, in order.

    Each round tests two proposals: the largest expected improvement, and the least expected distance. It ends when a
    test is within the tolerance, after so many rounds, or when nothing is left to propose.

    Parameters
    ----------
    evaluate : callable
        Carries out tests at coordinates; None of one that cannot be.
    goal : Goal
        What is wanted.
    design : sequence of FloatArray, shape (d,)
        Coordinates of the first tests.
    within : float
        Distance that is near enough [1].
    rounds : int
        Most rounds of proposals.
    encode : callable
        Coordinates (n, d) as the surrogate takes them (n, e).
    snap : callable
        Coordinates (n, d) moved to those that there are, where a parameter has few values.
    allowed : callable
        Whether coordinates may be proposed.

    Raises
    ------
    SpecificationError
        If fewer than `LEAST_POINTS` tests of the first design can be used.
    """
    trials = [_trial(z, 0, features, goal) for z, features in zip(design, evaluate(design), strict=True)]
    for number in range(1, rounds + 1):
        if best_of(trials).distance <= within:
            break
        surrogate = surrogate_of(trials, encode)
        nearest = sorted((one for one in trials if one.features is not None), key=lambda one: one.distance)[:NEAREST]
        z = candidates(np.stack([one.z for one in trials]), [one.z for one in nearest], number, snap)
        chosen = _proposals(surrogate, goal, z, encode(z), nearest[0].distance, allowed)
        if not chosen:
            break
        predicted = [surrogate.predict(encode(z[None])) for z in chosen]
        for z, features, expected in zip(chosen, evaluate(chosen), predicted, strict=True):
            trials.append(_trial(z, number, features, goal, expected))
    return trials


def surrogate_of(
    trials: Sequence[Trial], encode: Encode, but: FloatArray | None = None, *, widened: bool = False
) -> Surrogate:
    """Return the surrogate through all tests that were carried out, but one at some coordinates.

    Its deviations are `widened` where an interval is to be told; proposals do without.
    """
    used = [one for one in trials if one.features is not None and (but is None or not np.array_equal(one.z, but))]
    z = encode(np.stack([one.z for one in used])) if used else np.zeros((0, 1))
    features = np.stack([one.features for one in used if one.features is not None] or [np.zeros(1)])
    return Surrogate(z, features, widening_of(z, features) if widened and used else None)


def best_of(trials: Sequence[Trial]) -> Trial:
    """Return the test that is nearest to what is wanted, the first of equals."""
    return min(trials, key=lambda one: one.distance)


def _trial(
    z: FloatArray, number: int, features: FloatArray | None, goal: Goal, predicted: Prediction | None = None
) -> Trial:
    distance = float("inf") if features is None else float(goal.distance(features))
    return Trial(z=z, round=number, features=features, distance=distance, predicted=predicted)


def _proposals(
    surrogate: Surrogate, goal: Goal, z: FloatArray, encoded: FloatArray, best: float, allowed: Allowed
) -> list[FloatArray]:
    """Return at most two of some candidates to test next, which are allowed and differ."""
    chosen: list[FloatArray] = []
    if not len(z):
        return chosen
    for order in ranked(surrogate, goal, encoded, best):
        for at in order[:MOST_REFUSED]:
            if any(np.array_equal(z[at], one) for one in chosen):
                continue
            if allowed(z[at]):
                chosen.append(z[at])
                break
    return chosen

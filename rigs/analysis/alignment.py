"""Curves of one test on the axes of another: direction, zero of the force, slack, cycle."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.analysis.branches import branch

if TYPE_CHECKING:
    from rigs.axes import FloatArray
    from rigs.measurement import Measurement

RESTING: Final = 2e-3
"""Share of the range of travel within which a test has not begun."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
    """How tests are made to lie on each other.

    Attributes
    ----------
    cycle : int
        Which cycle, from 1, in the order of those of a test.
    slack : float or None
        Force at which slack is taken up [N]: strain counts from there, and so does the gauge length; None to leave it.
    offset : bool
        Whether the force counts from its mean before the test begins to move.
    """

    cycle: int = 1
    slack: float | None = None
    offset: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Aligned:
    """One cycle of a test as it is compared.

    Attributes
    ----------
    test : Measurement
        Its rows, aligned.
    loading : Measurement
        The rows of its loading alone.
    slack : float
        Travel that was taken off as slack [m].
    offset : float
        Force that was taken off [N].
    reversed_force, reversed_travel : bool
        Whether the file counts them the other way round.
    """

    test: Measurement
    loading: Measurement
    slack: float
    offset: float
    reversed_force: bool
    reversed_travel: bool


def aligned(test: Measurement, how: Alignment) -> Aligned:
    """Return a cycle of a test with both directions positive, its force zeroed and its slack taken off.

    Raises
    ------
    SpecificationError
        If the test has no such cycle, or its force never reaches that of the slack.
    """
    back, pulled = _is_reversed(test.travel), _is_reversed(test.force)
    test = _turned(test, travel=back, force=pulled)
    offset = _resting_force(test) if how.offset else 0.0
    test = _with_force(test, offset)
    part = _cycle(test, how.cycle)
    up = branch(part.phase, part.cycle, int(part.cycle[-1]), ["Stretch"])
    slack = 0.0
    if how.slack is not None:
        first = onset(part.travel[up], part.force[up], how.slack)
        if first is None:
            most = f"{float(np.nanmax(part.force[up])):.4g} N at most in {test.name}"
            raise SpecificationError("--slack", most, f"a force that is reached, below {how.slack:g} N")
        slack = first
        part = _tightened(part, slack)
    return Aligned(
        test=part,
        loading=part.chosen(up),
        slack=slack,
        offset=offset,
        reversed_force=pulled,
        reversed_travel=back,
    )


def onset(travel: FloatArray, force: FloatArray, level: float) -> float | None:
    """Return the travel [m] from which on the force of a loading stays above a level [N]; None if it never does.

    Linear between the last row at or below the level and the next.

    Parameters
    ----------
    travel, force : FloatArray, shape (n,)
        The loading.
    level : float
        Force [N].
    """
    below = np.flatnonzero(force <= level)
    if not len(force) or force[-1] <= level:
        return None
    if not len(below):
        return float(travel[0])
    last = int(below[-1])
    share = (level - force[last]) / (force[last + 1] - force[last])
    return float(travel[last] + share * (travel[last + 1] - travel[last]))


def _is_reversed(values: FloatArray) -> bool:
    """Return whether values go further below where they began than above it."""
    known = values[np.isfinite(values)]
    return bool(len(known) and known[0] - known.min() > known.max() - known[0])


def _turned(test: Measurement, *, travel: bool, force: bool) -> Measurement:
    if travel:
        # Phases told from the travel are those of the other way.
        ways = {"Stretch": "Recover", "Recover": "Stretch"}
        phase = tuple(ways.get(one, one) for one in test.phase)
        test = replace(test, travel=-test.travel, strain=-test.strain, phase=phase)  # type: ignore[arg-type]
    return replace(test, force=-test.force, stress=-test.stress) if force else test


def _resting_force(test: Measurement) -> float:
    """Return the mean force before a test begins to move [N]."""
    moved = np.flatnonzero(np.abs(test.travel - test.travel[0]) > RESTING * np.ptp(test.travel))
    return float(test.force[: max(1, int(moved[0]) if len(moved) else 1)].mean())


def _with_force(test: Measurement, offset: float) -> Measurement:
    if offset == 0.0:
        return test
    with np.errstate(divide="ignore", invalid="ignore"):
        section = test.force / test.stress
    # Rows without force tell no section.
    known = np.median(section[np.isfinite(section) & (section > 0.0)]) if np.isfinite(section).any() else np.nan
    return replace(test, force=test.force - offset, stress=test.stress - offset / known)


def _cycle(test: Measurement, number: int) -> Measurement:
    """Return one of the cycles of a test that are loaded, with the row it sets out from."""
    loaded = np.unique(test.cycle[np.asarray(test.phase, dtype=object) == "Stretch"])
    if not 1 <= number <= len(loaded):
        raise SpecificationError("--cycle", number, f"1 to {len(loaded)}, the cycles of {test.name}")
    rows = branch(test.phase, test.cycle, int(loaded[number - 1]), ["Stretch", "Hold", "Recover"])
    part = test.chosen(rows)
    return replace(part, cycle=np.full(len(part), number))


def _tightened(test: Measurement, slack: float) -> Measurement:
    """Return a test whose travel, and strain, count from where its slack is taken up; the gauge length is longer by it.

    ε' = (ε - ε₀) / (1 + ε₀), where ε₀ is the strain at the slack.
    """
    known = np.isfinite(test.strain) & (np.abs(test.travel) > 0.0)
    gauge = float(np.median(test.travel[known] / test.strain[known])) if known.any() else np.nan
    at = slack / gauge
    return replace(test, travel=test.travel - slack, strain=(test.strain - at) / (1.0 + at))

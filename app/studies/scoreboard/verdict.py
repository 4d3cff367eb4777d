"""What a row of the scoreboard comes to: our figures, a verdict by a criterion, and why."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping

Verdict: TypeAlias = Literal["reproduced", "differs", "not scorable"]

WITHIN: Final = 0.25
"""Share of the paper's number by which ours may differ from it where a number is reproduced."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What a row comes to.

    Attributes
    ----------
    verdict : Verdict
        By the row's criterion.
    ours : str
        Our figures in words.
    why : str
        What was measured that explains a difference, or why there is no verdict; empty where there is nothing to add.
    values : Mapping
        Our figures, in SI units.
    """

    verdict: Verdict
    ours: str
    why: str = ""
    values: Mapping[str, float] = field(default_factory=dict)


def judged(reproduced: bool, ours: str, values: Mapping[str, float], why: str = "") -> Score:  # noqa: FBT001 (its subject)
    """Return the score of figures that do or do not meet a criterion; figures that are not finite have no verdict.

    Reasons are those of a difference, and left out where there is none.
    """
    unknown = [name for name, value in values.items() if not isfinite(value)]
    if unknown:
        return Score(verdict="not scorable", ours=ours, why=f"no value of {', '.join(unknown)}", values=dict(values))
    verdict: Verdict = "reproduced" if reproduced else "differs"
    return Score(verdict=verdict, ours=ours, why="" if reproduced else why, values=dict(values))


def is_near(value: float, paper: float, within: float = WITHIN) -> bool:
    """Return whether a number is that of the paper within a share of it."""
    return abs(value - paper) <= within * abs(paper)


def percent_off(value: float, paper: float) -> str:
    """Return by how much a number is off that of the paper, as +12 %."""
    return f"{100.0 * (value / paper - 1.0):+.0f} %"

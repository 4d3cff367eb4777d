"""What a design shall come to, and what a run came to: a secant, the area of a loop, or a curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.surrogate import Goal
from app.views.overlay import groups_of, run_groups
from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment
from rigs.analysis.comparison import secant
from rigs.analysis.repeatability import read_at
from rigs.analysis.work import is_closed, loop_area

if TYPE_CHECKING:
    from pathlib import Path

    from app.schemas.designs import DesignTarget
    from rigs.analysis.comparison import Group
    from rigs.axes import FloatArray

POINTS: Final = 12
"""Points at which a wanted curve is met."""

FIRST: Final = 0.1
"""Share of a wanted curve's range at which its first point is [1]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Target:
    """What a design shall come to.

    Attributes
    ----------
    name, unit : str
        What it is called, and its unit.
    wanted : DesignTarget
        As the file says it.
    goal : Goal
        The wanted features.
    at : FloatArray
        Strains of the points of a wanted curve [1]; empty otherwise.
    """

    name: str
    unit: str
    wanted: DesignTarget
    goal: Goal
    at: FloatArray

    @property
    def scalar(self) -> bool:
        """Return whether it is one number, and not a curve."""
        return not len(self.at)

    def drawn(self) -> tuple[FloatArray, FloatArray] | None:
        """Return strains and stresses that are wanted: the ends of a secant, or a curve; None of a loop area."""
        if self.wanted.secant is not None:
            return np.array([0.0, self.wanted.to]), np.array([0.0, self.wanted.secant * self.wanted.to])
        return None if self.scalar else (self.at, self.goal.features)

    def features(self, folder: Path) -> FloatArray | None:
        """Return what a run came to (m,); None of one that did not go so far, or did not come back."""
        try:
            groups = run_groups(folder, Alignment(cycle=self.wanted.cycle))
        except SpecificationError:
            return None
        group = next((one for one in groups if one.axis == self.wanted.axis), None)
        found = None if group is None else self._of(group)
        return None if found is None or not np.isfinite(found).all() else found

    def _of(self, group: Group) -> FloatArray | None:
        test, loading = group.tests[0].test, group.tests[0].loading
        if self.wanted.secant is not None:
            return np.array([secant(loading.strain, loading.stress, self.wanted.to)])
        if self.wanted.loop_area is not None:
            return np.array([loop_area(test.strain, test.stress)]) if is_closed(test.strain) else None
        return read_at(loading.strain, loading.stress, self.at)


def target_of(wanted: DesignTarget) -> Target:
    """Return the target of a design file.

    Raises
    ------
    FormatError, SpecificationError
        If a wanted curve cannot be read, or has no stress over strain.
    """
    where = f"{wanted.axis}, cycle {wanted.cycle}"
    nothing = np.zeros(0)
    if wanted.secant is not None:
        name = f"Modulus (secant 0 % - {100.0 * wanted.to:g} %), {where}"
        goal = Goal(features=np.array([wanted.secant]), scale=wanted.secant)
        return Target(name=name, unit="Pa", wanted=wanted, goal=goal, at=nothing)
    if wanted.loop_area is not None:
        goal = Goal(features=np.array([wanted.loop_area]), scale=wanted.loop_area)
        return Target(name=f"Loop area, {where}", unit="J/m3", wanted=wanted, goal=goal, at=nothing)
    if wanted.curve is None:
        raise SpecificationError("target", "nothing that is wanted", "a secant, a loop area or a curve")
    (group,) = groups_of([wanted.curve], None, Alignment(cycle=1), wanted.axis)
    band = group.band("strain", "stress")
    at = band.x[0] + (band.x[-1] - band.x[0]) * np.linspace(FIRST, 1.0, POINTS)
    values = read_at(band.x, band.mean, at)
    return Target(
        name=f"NRMSE from {wanted.curve.name}, {where}",
        unit="1",
        wanted=wanted,
        goal=Goal(features=values, scale=float(np.ptp(values))),
        at=at,
    )

"""Friction acts between surfaces that turn with their strands: cases in which slip of centrelines says otherwise.

Two like rods lie side by side, their axes d apart. The line between the axes turns by an angle A, the rods about their
own axes by a and b. The material points that touch half-way between the axes then part at the rate of a planetary gear
(Willis 1841): d (A - (a + b) / 2), and the work lost is mu N times it. Were slip measured on the centrelines, it would
be d A whatever a and b are, and no rod would feel a couple.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import straight, unit_model

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State

MU: Final = 0.3

APART: Final = 1.95
"""Distance of the axes [r]: 2.5 % of indentation."""

STEP: Final = 0.01
"""Angle of a step [rad]."""

SETTLED: Final = 20
"""Steps after which all elastic slip (0.02 r) is used up."""

STEPS: Final = 80

GEAR: Final = "planetary gear (Willis 1841) with Coulomb's friction"


class Pair:
    """Two rods of which all is prescribed: the first along z on the origin, the second APART from it along x."""

    def __init__(self, *, friction: float = MU, across: bool = False) -> None:
        # Off the middle, so that no symmetry of the samples hides a bias.
        upper = straight((APART, 0, 0.07), (0, 1, 0) if across else (0, 0, 1), 12.0)
        lower = straight((0, 0, 0), (0, 0, 1), 24.0)
        model, self.state = unit_model([lower, upper], friction=friction)
        self.first, self.start = len(lower), self.state.q.copy()
        model.fixed[:] = True
        self.work = Workspace(model)

    def move_to(self, q: FloatArray) -> State:
        """Find the forces with everything, or all that is not free, at `q`."""
        found, report = advance(self.work, self.state, q)
        if found is None:
            pytest.fail(f"no equilibrium: {report}")
        self.state = found
        return found

    def turn(self, line: float, lower: float, upper: float) -> State:
        """Turn the line between parallel axes to an angle [rad], and the rods about their axes."""
        q = self.start.copy()
        q[self.first :, :2] = APART * np.array([np.cos(line), np.sin(line)])
        q[: self.first - 1, 3] = lower
        q[self.first : -1, 3] = upper
        return self.move_to(q)

    @property
    def pull(self) -> FloatArray:
        """Force (3,) that holds the upper rod [E r^2]."""
        return np.asarray(self.state.reaction[self.first :, :3].sum(axis=0))

    @property
    def couples(self) -> FloatArray:
        """Couples (2,) that hold the rods about their own axes [E r^3]."""
        angle = self.state.reaction[:, 3]
        return np.array([angle[: self.first].sum(), angle[self.first :].sum()])


def limit(*, across: bool = False) -> float:
    """Return mu N: all is prescribed, so N is the force that holds the rods together without friction."""
    smooth = Pair(friction=0.0, across=across)
    return -MU * float(smooth.move_to(smooth.start).reaction[smooth.first :, 0].sum())


@pytest.mark.parametrize(
    ("name", "line", "lower", "upper"),
    [
        ("carried round without spin", 1.0, 0.0, 0.0),
        ("carried round, the same side inwards", 1.0, 0.0, 1.0),
        ("rolls", 1.0, 0.0, 2.0),
        ("both turn as one body", 1.0, 1.0, 1.0),
        ("spin in place, like ways", 0.0, 1.0, 1.0),
        ("spin in place, as gears do", 0.0, 1.0, -1.0),
    ],
)
def test_rods_that_turn_about_each_other(
    bar: Callable[..., None], name: str, line: float, lower: float, upper: float
) -> None:
    pair, most = Pair(), limit()
    lost = [pair.turn(*(k * STEP * np.array([line, lower, upper]))).friction_work for k in range(1, STEPS + 1)]
    rate = (lost[-1] - lost[SETTLED]) / ((STEPS - 1 - SETTLED) * STEP)
    parting = APART * (line - 0.5 * (lower + upper))
    angle = STEPS * STEP * line
    across = float(pair.pull @ [-np.sin(angle), np.cos(angle), 0.0])
    for figure, found, wanted in (
        ("work over mu N d A", rate / APART, abs(parting) / APART),
        ("force across over mu N", across, np.sign(parting)),
        ("lower couple over mu N d / 2", pair.couples[0] / (0.5 * APART), -np.sign(parting)),
        ("upper couple over mu N d / 2", pair.couples[1] / (0.5 * APART), -np.sign(parting)),
    ):
        bar(f"two rods, {name}: {figure}", found / most - wanted, 0.01, "1", GEAR)


def test_rod_spun_across_another_drags_it(bar: Callable[..., None]) -> None:
    pair, most = Pair(across=True), limit(across=True)
    q = pair.start.copy()
    for _ in range(STEPS):
        q[pair.first : -1, 3] += STEP
        pair.move_to(q)
    bar("rod spun across another: drag against mu N", abs(pair.pull[2]) / most - 1.0, 0.01, "1", GEAR)
    couple = abs(pair.couples[1]) / (0.5 * APART * most)
    # Between r, the arm before, and d / 2, that of the flattened contact.
    bar("rod spun across another: couple against mu N d / 2", couple - 1.0, 0.025, "1", GEAR)


def test_rod_spun_across_another_drives_away(bar: Callable[..., None]) -> None:
    pair = Pair(across=True)
    pair.work.model.fixed[pair.first :, 2] = False
    for _ in range(STEPS):
        q = pair.state.q.copy()
        q[pair.first : -1, 3] += STEP
        pair.move_to(q)
    way = abs((pair.state.q[pair.first :, 2] - pair.start[pair.first :, 2]).mean())
    angle = STEPS * STEP
    bar("rod spun across another and let go: way against A d / 2", way / (0.5 * APART * angle) - 1.0, 0.025, "1", GEAR)

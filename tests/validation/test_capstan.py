"""A thin rod pulled around a drum: T2 = T1 exp(mu phi).

All strands have one radius, so the drum is a cage: clamped strands side by side, parallel to the drum's axis.
Euler's rod is thin. One of radius r has its tension at R from the drum's axis but its friction at R - r: moments
about the axis and the shear that balances friction's couple lower the exponent by (1 + mu^2) r / R, which is 0.9 % of
it (1.7 % of the tension where mu phi is largest) on a drum 60 rods thick. Bending at the ends of the wrap takes
EI / (2 T R^2) = 0.1 % of the smaller tension at most. A cage of pegs 2 b apart in angle holds by
(1 + mu tan b) / (1 - mu tan b) each, which is exp(2 mu b) within b^2 / 3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import EDGE, straight, unit_model

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray


DRUM: Final = 120.0
"""Radius of the circle of pegs [r]."""

PITCH: Final = 5.0
"""Shift along the axis in one turn [r], so that the rod does not meet itself."""

TENSION: Final = 0.03
"""Dead load at the slack end [E r^2]."""

STRAIGHT: Final = 16.0
"""Length of rod before and behind the drum [r]."""

TOUCH: Final = DRUM + 2.0
"""Radius of the circle of the rod's centreline [r]."""


def wrapped(phi: float) -> FloatArray:
    """Return the nodes of a rod wrapped by an angle [rad], with straight ends along the tangents."""
    s = np.linspace(-STRAIGHT, TOUCH * phi + STRAIGHT, round((TOUCH * phi + 2 * STRAIGHT) / EDGE) + 1)
    angle = np.clip(s / TOUCH, 0.0, phi)
    beyond = s - TOUCH * angle
    x = TOUCH * np.cos(angle) - beyond * np.sin(angle)
    y = TOUCH * np.sin(angle) + beyond * np.cos(angle)
    return np.column_stack([x, y, PITCH * s / (2 * np.pi * TOUCH)])


def cage(phi: float) -> list[FloatArray]:
    """Return pegs about 0.1 rad apart, the outer ones half a gap inside the wrap."""
    count = round(phi / 0.1)
    angles = (np.arange(count) + 0.5) * phi / count
    centres = np.column_stack([DRUM * np.cos(angles), DRUM * np.sin(angles), PITCH * angles / (2 * np.pi)])
    return [straight(centre, (0, 0, 1), 8.0) for centre in centres]


def tension_ratio(mu: float, phi: float) -> float:
    """Pull the rod until it slips everywhere; return T2 / T1, the farthest from Euler's in the last steps."""
    rod = wrapped(phi)
    model, state = unit_model([rod, *cage(phi)], friction=mu)
    last = len(rod) - 1
    # The ends keep their height; else only the pulled one is held, along its tangent, so that
    # the forces on the ends lie along the tangents and the angle of wrap is exact. The rod slides, it must not roll.
    way = np.round([-np.sin(phi), np.cos(phi)])
    axis = int(np.argmax(np.abs(way)))
    model.fixed[len(rod) :] = True
    model.fixed[: len(rod), 3] = True
    model.fixed[0, 2] = True
    model.fixed[last, [2, axis]] = True
    work = Workspace(model)
    work.dead.loads[0, 1] = -TENSION
    # Travel in which the rod's stretch goes from exp(-mu s / R) to exp(mu s / R), and the ends', with 3 r to spare.
    euler = np.exp(mu * phi)
    travel = TENSION / np.pi * (TOUCH * (euler - 1.0 / euler) / mu + 2.0 * STRAIGHT * (euler - 1.0)) + 3.0
    found, report = advance(work, state, state.q)
    if found is None:
        pytest.fail(f"no equilibrium under the dead load: {report}")
    start = found.q.copy()

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[last, axis] += s * travel * way[axis]
        return target

    ratios = [
        float(state.reaction[last, axis] * way[axis]) / TENSION
        for _, state, _ in march(work, found, path, longest=1.0 / travel)
    ]
    return max(ratios[-3:], key=lambda ratio: abs(ratio / euler - 1.0))


@pytest.mark.parametrize(
    ("mu", "half_turns"),
    [
        *((mu, half_turns) for mu in (0.1, 0.3) for half_turns in (0.5, 1.0)),
        (0.1, 2.0),
        pytest.param(0.3, 2.0, marks=pytest.mark.slow),
    ],
)
def test_capstan(bar: Callable[..., None], mu: float, half_turns: float) -> None:
    phi = half_turns * np.pi
    bar(
        f"capstan, mu = {mu}, phi = {half_turns:g} pi: T2 / T1 against exp(mu phi)",
        figure=tension_ratio(mu, phi) / np.exp(mu * phi) - 1.0,
        limit=0.02,
        unit="1",
        source="Euler 1769, Eytelwein 1808",
    )

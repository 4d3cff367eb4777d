"""A yarn that hangs over a wire hook and is pulled round it.

Euler's rod is thin. One of radius r on a wire has its tension T at R from the wire's axis and its friction at R - r:
with no stiffness against bending, the shear Q = -mu r n balances the couple of friction by the pressure n. With
rho = r / R, the angle phi and N = n R the balance of forces is

    dT / dphi = mu (1 - rho) N,    dN / dphi = (T - N) / (mu rho),

whose solutions grow as exp(L phi), L (1 + mu rho L) = mu (1 - rho), but for the ends of the wrap. Where the yarn comes
on, shear and therefore pressure begin at zero, which a second solution with L' = -1 / (mu rho) - L takes care of. Where
it leaves, shear has to end: the pressure dies away along the straight leg as exp(-s / (mu r)), which adds mu^2 rho N
to the tension. There the gap is s^2 / (2 R), which at s = mu r is half the distance in which contact gives way. If that
were stiff, the yarn would keep to the wire a little longer and leave with a kink; the tension were 1.1 % less at
mu = 0.3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from knitlab_core.contact.law import make_law, pair_potential
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.section import Section

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray

EDGE: Final = 0.2
"""Length of the edges [r]: ten in a bend's radius."""

LEG: Final = 5.0
"""Length of yarn that hangs on either side [r]."""

TENSION: Final = 2e-3
"""Dead load at the slack end [E r^2]."""

APART: Final = 2.0
"""From the wire's axis to the yarn's [r]."""


def hanging() -> FloatArray:
    """Return the nodes of a yarn that hangs over a wire along z, from one leg's foot to the other's."""
    half = 0.5 * np.pi * APART
    s = np.linspace(-half - LEG, half + LEG, round(2.0 * (half + LEG) / EDGE) + 1)
    angle = np.clip(s, -half, half) / APART
    beyond = np.abs(s) - half
    return np.column_stack([APART * np.sin(angle), APART * np.cos(angle) - np.maximum(beyond, 0.0), 0.0 * s])


def pulled(mu: float) -> float:
    """Pull one leg down until the yarn slips; return the ratio of the tensions."""
    yarn = hanging()
    wire = np.column_stack([np.zeros(41), np.zeros(41), EDGE * np.arange(-20, 21)])
    model, state = make_model(
        [yarn],
        radius=1.0,
        young_modulus=1.0,
        poisson_ratio=0.37,
        friction=mu,
        section=Section(area=1.0, bend=1e-5, twist=1.0),
        wires=[wire],
    )
    last = len(yarn) - 1
    model.fixed[len(yarn) :] = True
    # In the plane, and not rolling about its axis; the pulled end keeps its way.
    model.fixed[: len(yarn), 2:] = True
    model.fixed[last, :2] = True
    work = Workspace(model)
    work.dead.loads[0, 1] = -TENSION
    found, report = advance(work, state, state.q)
    if found is None:
        pytest.fail(f"no equilibrium under the dead load: {report}")
    start = found.q.copy()

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[last, 1] -= 1.5 * s
        return target

    *_, (_, state, _) = march(work, found, path, longest=0.1)
    return float(-state.reaction[last, 1]) / TENSION


def thick_capstan(mu: float, rho: float, phi: float) -> float:
    """Return T2 / T1 round an angle [rad], ends of the wrap included; `rho` is the yarn's radius over R."""
    root = np.sqrt(1.0 + 4.0 * mu * rho * mu * (1.0 - rho))
    grows, dies = (root - 1.0) / (2.0 * mu * rho), -(root + 1.0) / (2.0 * mu * rho)
    grown, dead = np.exp(grows * phi), np.exp(dies * phi)
    # T = 1 and N = 0 where the yarn comes on.
    tension = (grows * dead - dies * grown) / (grows - dies)
    pressure = grows * dies * (dead - grown) / (grows - dies) / (mu * (1.0 - rho))
    return float(tension + mu**2 * rho * pressure)


def test_thin_yarn_obeys_euler() -> None:
    assert thick_capstan(0.3, 1e-4, np.pi) == pytest.approx(np.exp(0.3 * np.pi), rel=1e-3)


def test_thick_capstan_solves_the_balance_of_forces() -> None:
    mu, rho, steps = 0.3, 0.5, 20000
    tension, pressure, step = 1.0, 0.0, np.pi / 20000
    for _ in range(steps):
        slope = np.array([mu * (1.0 - rho) * pressure, (tension - pressure) / (mu * rho)])
        tension, pressure = np.array([tension, pressure]) + step * slope
    assert thick_capstan(mu, rho, np.pi) == pytest.approx(tension + mu**2 * rho * pressure, rel=1e-3)


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_yarn_slips_around_a_wire(bar: Callable[..., None], mu: float) -> None:
    bar(
        f"yarn hung over a wire as thick, mu = {mu}: T2 / T1 against Euler with friction's couple and ends",
        figure=pulled(mu) / thick_capstan(mu, 1.0 / APART, np.pi) - 1.0,
        limit=0.02,
        unit="1",
        source="Euler 1769; balance of forces",
    )


def pressures(mu: float, distances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the force on a length of yarn across a straight wire, and mu times the sum of pair forces [E r]."""
    law = make_law(0.37, mu)
    z = np.linspace(-1.0, 1.0, 1001)
    apart = np.hypot(distances[:, None], z)
    slope = np.array([pair_potential(law.distance - d, law)[1] if d < law.reach else 0.0 for d in apart.ravel()])
    slope = slope.reshape(apart.shape)
    along = np.trapezoid(slope * distances[:, None] / apart, z, axis=1)
    return np.asarray(along), mu * np.asarray(np.trapezoid(slope, z, axis=1))


def string_round_a_wire(mu: float) -> float:
    """Return T2 / T1 of a string without stiffness, its place and force (x, y, Fx, Fy) by a boundary-value problem.

    With no moment, shear is the couple of friction, mu n d / 2: the string points that far off its force.
    """
    distances = np.linspace(1.9, 2.05, 301)
    press, rub = pressures(mu, distances)

    def slope(_: FloatArray, state: FloatArray) -> FloatArray:
        x, y, fx, fy = state
        d, force = np.hypot(x, y), np.hypot(fx, fy)
        n, f = (np.interp(d, distances, values, right=0.0) for values in (press, rub))
        sine = np.clip(0.5 * f * d / force, -0.9, 0.9)
        cosine = np.sqrt(1.0 - sine**2)
        tx, ty = (cosine * fx + sine * fy) / force, (cosine * fy - sine * fx) / force
        ex, ey = x / d, y / d
        turn = np.sign(tx * ey - ty * ex)  # clockwise about the wire
        return np.array([tx, ty, -n * ex + f * turn * ey, -n * ey - f * turn * ex])

    def ends(start: FloatArray, end: FloatArray) -> FloatArray:
        return np.array([start[2] / TENSION, start[3] / TENSION - 1.0, start[1] + LEG, end[2] / TENSION])

    half = 0.5 * np.pi * APART
    s = np.linspace(-half - LEG, half + LEG, 1201)
    angle = np.clip(s, -half, half) / APART
    x, y = APART * np.sin(angle), APART * np.cos(angle) - np.maximum(np.abs(s) - half, 0.0)
    tension = TENSION * np.exp(mu / 2.0 * (angle + np.pi / 2.0))
    guess = np.array([x, y, tension * np.cos(angle), -tension * np.sin(angle)])
    found = solve_bvp(slope, ends, s, guess, tol=1e-5, max_nodes=60000)
    assert found.success, found.message
    return float(-found.y[3, -1] / TENSION)


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_yarn_slips_as_a_string_with_the_same_contact_law(bar: Callable[..., None], mu: float) -> None:
    bar(
        f"yarn hung over a wire as thick, mu = {mu}: T2 / T1 against a string with the same law of contact",
        figure=pulled(mu) / string_round_a_wire(mu) - 1.0,
        limit=0.005,
        unit="1",
        source="boundary-value problem (SciPy), no rods, no nodes",
    )

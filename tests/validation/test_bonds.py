"""Fused points: stiffness, strength and energy of one bond, and of those of a knit."""

from __future__ import annotations

from math import hypot, pi
from typing import TYPE_CHECKING, Final

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import POISSON_RATIO, straight
from tests.validation.knit import make_knit

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import Model, State
    from tests.validation.knit import Knit

TIGHT: Final = Options(tolerance=1e-8)
GAP, PATCH, STRENGTH, SHEAR_STRENGTH = 0.3, 0.4, 0.012, 0.008
AREA: Final = pi * PATCH**2
STIFFNESS: Final = AREA / (GAP + pi * (1.0 - POISSON_RATIO**2) * PATCH)
NODES = 13
MIDDLE: Final = np.array([0.0, 0.0, 1.0 + 0.5 * GAP])
NECK = "neck of length g between half-spaces: EA/(g + π(1−ν²)a)"
CRITERION = "(σ/σs)² + (τ/τs)² = 1"


def crossed(*, rigid: bool, weaker: float = 1.0) -> tuple[Model, State]:
    """Fuse two strands that cross, in units of r and E; hold all of their unknowns, or clamp their ends."""
    strands = [straight((0, 0, 0), (1, 0, 0), 24.0), straight((0, 0, 2.0 + GAP), (0, 1, 0), 24.0)]
    law = BondLaw(fuse_gap=0.5, patch_radius=PATCH, strength=STRENGTH / weaker, shear_strength=SHEAR_STRENGTH / weaker)
    model, state = make_model(
        strands, radius=1.0, young_modulus=1.0, poisson_ratio=POISSON_RATIO, friction=0.0, bonds=law
    )
    model.fixed[slice(None) if rigid else [0, 1, 11, 12, 13, 14, 24, 25]] = True
    return model, state


def moved(q: FloatArray, by: FloatArray) -> FloatArray:
    """Return the upper strand moved."""
    q = q.copy()
    q[NODES:, :3] += by
    return q


def turned(q: FloatArray, by: FloatArray, first: int = NODES) -> FloatArray:
    """Return the upper strand, or both from node 0 on, turned about the middle of the neck."""
    q = q.copy()
    q[first:, :3] = Rotation.from_rotvec(by).apply(q[first:, :3] - MIDDLE) + MIDDLE
    return q


def forces(states: list[State], way: FloatArray) -> FloatArray:
    """Return the force by which the upper strand is moved along a unit vector."""
    return np.array([float(state.reaction[NODES:, :3].sum(axis=0) @ way) for state in states])


def torques(states: list[State], axis: FloatArray) -> FloatArray:
    """Return the torque by which the upper strand is turned about the middle of the neck."""
    arms = [np.cross(state.q[NODES:, :3] - MIDDLE, state.reaction[NODES:, :3]).sum(axis=0) for state in states]
    return np.array([float(arm @ axis) for arm in arms])


def walk(model: Model, state: State, path: Callable[[float], FloatArray], steps: int) -> tuple[FloatArray, list[State]]:
    """Return the share of the way and the state of every equilibrium."""
    rows = list(march(Workspace(model), state, path, longest=1.0 / steps, options=TIGHT))
    return np.array([share for share, _, _ in rows]), [found for _, found, _ in rows]


def _along(q: FloatArray, by: FloatArray) -> Callable[[float], FloatArray]:
    return lambda s: moved(q, s * by)


WAYS = {"pull": (0.0, 0.0, 1.0), "shear": (1.0, 0.0, 0.0), "shear, other way": (0.0, 1.0, 0.0), "both": (0.6, 0.0, 0.8)}


@pytest.mark.parametrize("name", WAYS)
def test_force_on_a_bond_between_rigid_strands(bar: Callable[..., None], name: str) -> None:
    way = np.array(WAYS[name])
    strength = AREA / hypot(way[2] / STRENGTH, hypot(way[0], way[1]) / SHEAR_STRENGTH)
    far = 2.0 * strength / STIFFNESS
    peaks = []
    for steps in (4, 7, 25):
        model, state = crossed(rigid=True)
        share, states = walk(model, state, _along(state.q, far * way), steps)
        force = forces(states, way)
        peaks.append(force.max())
        assert not states[-1].bonds.whole.any()
        assert np.abs(states[-1].reaction).max() < 1e-12
    bar(f"bond, {name}: stiffness", force[0] / (far * share[0]) / STIFFNESS - 1.0, 0.01, "1", NECK)
    bar(f"bond, {name}: force at break", min(peaks) / strength - 1.0, 0.01, "1", CRITERION)
    bar(f"bond, {name}: force at break over step counts", np.ptp(peaks) / strength, 0.01, "1", "4, 7, 25 steps")
    assert max(peaks) <= strength * (1.0 + 1e-9)


AXES = {
    "twist": ((0.0, 0.0, 1.0), 0.5, SHEAR_STRENGTH * pi * PATCH**3 / 2.0),
    "tilt": ((1.0, 0.0, 0.0), 0.25, STRENGTH * pi * PATCH**3 / 4.0),
}


@pytest.mark.parametrize("name", AXES)
def test_torque_on_a_bond_between_rigid_strands(bar: Callable[..., None], name: str) -> None:
    axis, share_of_disc, strength = np.array(AXES[name][0]), *AXES[name][1:]
    stiffness = share_of_disc * STIFFNESS * PATCH**2
    far = 2.0 * strength / stiffness
    model, state = crossed(rigid=True)
    share, states = walk(model, state, lambda s: turned(state.q, s * far * axis), 7)
    torque = torques(states, axis)
    bar(f"bond, {name}: stiffness", torque[0] / (far * share[0]) / stiffness - 1.0, 0.01, "1", "disc of even springs")
    bar(f"bond, {name}: torque at break", torque.max() / strength - 1.0, 0.01, "1", "edge stress 4M/πa³, 2T/πa³")
    assert not states[-1].bonds.whole.any()


def test_energy_through_the_break_of_a_bond_between_bending_strands(bar: Callable[..., None]) -> None:
    model, state = crossed(rigid=False, weaker=5.0)
    way = np.array([0.0, 0.0, 1.0])
    share, states = walk(model, state, lambda s: moved(state.q, 0.25 * s * way), 10)
    force = forces(states, way)
    peak = int(force.argmax())
    end = states[-1]
    assert not end.bonds.whole.any()
    bar(
        "bond between bending strands: force at break",
        force[peak] / (0.2 * STRENGTH * AREA) - 1.0,
        0.01,
        "1",
        CRITERION,
    )
    # Deflections are a tenth of the radius, so that force over displacement is straight.
    work = 0.5 * force[peak] * 0.25 * share[peak]
    bar("bond between bending strands: work in", end.external_work / work - 1.0, 0.01, "1", "triangle F d / 2")
    kept = end.energies.sum() + end.bonds.energy + end.bonds.released + end.friction_work
    bar("bond between bending strands: energy balance", kept / end.external_work - 1.0, 0.01, "1", "specimens.md")
    # More is lost than the bond had: strands snap back.
    assert end.bonds.released > 1.5 * states[peak].bonds.energy > 0.0


def test_turning_fused_strands_makes_no_force(bar: Callable[..., None]) -> None:
    model, state = crossed(rigid=False)
    model.fixed[:, 3] = ~model.rods.has_edge
    axis = np.array([1.1, 0.9, -1.4])
    _, states = walk(model, state, lambda s: turned(state.q, s * axis, first=0), 20)
    bar("unloaded fused strands turned by 2 rad: largest force", np.abs(states[-1].reaction).max(), 1e-9, "E r^2", "0")
    assert states[-1].bonds.whole.all()


def test_turning_loaded_fused_strands_changes_no_force(bar: Callable[..., None]) -> None:
    model, state = crossed(rigid=False)
    model.fixed[:, 3] = ~model.rods.has_edge
    _, (*_, loaded) = walk(model, state, lambda s: moved(state.q, 0.06 * s * np.array([0.3, 0.2, 1.0])), 4)
    assert 0.3 < loaded.bonds.load[0] < 0.9
    axis = np.array([1.1, 0.9, -1.4])
    _, (*_, end) = walk(model, loaded, lambda s: turned(loaded.q, s * axis, first=0), 20)
    back = Rotation.from_rotvec(axis).inv().apply(end.reaction[:, :3])
    change = np.abs(back - loaded.reaction[:, :3]).max() / np.abs(loaded.reaction).max()
    bar("loaded fused strands turned by 2 rad: change of force", change, 1e-6, "1", "0")
    bar(
        "loaded fused strands turned by 2 rad: change of load",
        end.bonds.load[0] / loaded.bonds.load[0] - 1,
        1e-6,
        "1",
        "0",
    )


def _pulled(knit: Knit, strain: float, steps: int) -> tuple[FloatArray, FloatArray, list[State]]:
    """Pull a knit; return strains, forces (n, 2) and states."""
    path = march(Workspace(knit.model), knit.start, lambda s: knit.target(strain * s), longest=1.0 / steps)
    rows = [(strain * share, knit.force(state), state) for share, state, _ in path]
    return np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), [row[2] for row in rows]


def test_a_fused_knit_is_stiffer_until_its_bonds_have_broken(bar: Callable[..., None]) -> None:
    radius = make_knit(2).model.scales.radius
    law = BondLaw(fuse_gap=3.5 * radius, patch_radius=0.3 * radius, strength=20e6)
    _, free, _ = _pulled(make_knit(2, friction=0.0), 0.4, 40)
    strain, force, states = _pulled(make_knit(2, friction=0.0, bonds=law), 0.4, 40)
    whole = np.array([np.count_nonzero(state.bonds.whole) for state in states])
    assert whole[0] == 10
    assert whole[-1] == 0
    assert 0.04 < strain[whole == 10].max() < 0.08
    softer = (free[0] / force[0]).max()
    bar("2x2 knit, 1 %: force unfused over fused", softer, 0.2, "1", "the paper, Fig. 5b: stiffer at first")
    rest = np.abs(force[-1] / free[-1] - 1.0).max()
    bar("2x2 knit, 40 %: force after all bonds broke", rest, 1e-4, "1", "the paper, Fig. 5b: as unfused")
    end = states[-1]
    kept = end.energies.sum() + end.bonds.energy + end.bonds.released + end.friction_work
    bar("2x2 fused knit to 40 %: energy balance", kept / end.external_work - 1.0, 0.01, "1", "physics.md §6")

"""Axes of shear on a rig: work and energy, symmetry, and what friction takes of a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from app.schemas.machine_data import machines_of
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Options
from rigs.analysis.work import loop_area
from rigs.machines.mounting import mount
from rigs.machines.rig import pose, read
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Protocol, SpecimenSpec

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis, FloatArray
    from rigs.machines.rig import Rig

TIGHT: Final = Options(tolerance=1e-8)
SMALL: Final = 3e-5
SHEAR: Final = 0.15
PLANAR: Final[Mapping[Axis, float]] = {"C": 0.36, "W": 0.36}
VOLUMETRIC: Final[Mapping[Axis, float]] = {"C": 0.22, "W": 0.22, "P": 0.22}


@dataclass(slots=True, kw_only=True)
class Sheared:
    """A cell on a rig that shears it, its state, and the strain of each axis."""

    rig: Rig
    state: State
    strain: dict[Axis, float]

    @property
    def energy(self) -> float:
        """Return what is stored [J], in the links too, which are no part of the state's energies."""
        links = self.rig.work.links
        assert links is not None
        return self.rig.work.model.scales.energy * (float(self.state.energies.sum()) + links.energy())

    @property
    def volume(self) -> float:
        """Return the volume that stresses and strains of all axes refer to [m³]."""
        return prod(self.rig.size.extents.values())

    def stress(self, axis: Axis) -> float:
        """Return the stress of an axis [Pa]."""
        return read(self.rig, self.state).force[axis] / self.rig.size.section(axis)

    def go(self, strain: Mapping[Axis, float], *, steps: int = 1, options: Options = TIGHT) -> None:
        """Bring the axes to strains [1]."""
        rig, start = self.rig, dict(self.strain)
        goal = {**start, **strain}
        ways = {axis: (start[axis] * length, goal[axis] * length) for axis, length in rig.gauges.items()}
        path = march(
            rig.work,
            self.state,
            lambda share: pose(rig, {axis: a + share * (b - a) for axis, (a, b) in ways.items()}),
            longest=1.0 / steps,
            options=options,
        )
        for _, self.state, _ in path:
            pass
        self.strain = goal


def mounted(*, friction: float = 0.0, layers: int = 1) -> Sheared:
    """Mount a cell of one loop, or of one stitch of a volumetric knit, as printed."""
    protocol = Protocol(
        rig="biaxial-shear" if layers == 1 else "triaxial-shear",
        specimen=SpecimenSpec(
            knit="stockinette-default" if layers == 1 else "volumetric-default",
            rows=1,
            loops=1,
            layers=layers,
            loop_width=8e-3,
            material="RGD8530-DM",
            friction=friction,
            nodes_per_loop=16,
            periodic=True,
        ),
        others="hold",
    )
    rig, state = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol))
    return Sheared(rig=rig, state=state, strain=dict.fromkeys(rig.grips, 0.0))


@pytest.mark.parametrize("layers", [1, 2])
def test_the_stress_of_an_axis_is_the_slope_of_the_energy_per_volume(layers: int, bar: Callable[..., None]) -> None:
    """Also of a cell that is stretched and sheared along all axes at once: of shear, d psi / d gamma = tau."""
    cell = mounted(layers=layers)
    cell.go(PLANAR if layers == 1 else VOLUMETRIC, steps=5)
    leaning: list[Axis] = [axis for axis in cell.rig.grips if len(axis) > 1]
    cell.go(dict.fromkeys(leaning, SHEAR), steps=3)
    begun, strain = cell.state, dict(cell.strain)
    stress = {axis: cell.stress(axis) for axis in strain}
    errors = []
    for axis in strain if layers == 1 else leaning:
        energies = []
        for way in (-SMALL, SMALL):
            cell.state, cell.strain = begun, dict(strain)
            cell.go({axis: strain[axis] + way})
            energies.append(cell.energy / cell.volume)
        errors.append((energies[1] - energies[0]) / (2.0 * SMALL) - stress[axis])
    error = np.abs(errors).max() / max(map(abs, stress.values()))
    kind = "planar" if layers == 1 else "volumetric"
    bar(f"shear axis: stress against slope of energy, {kind}", error, 1e-6, "1", "virtual work")
    assert all(abs(stress[axis]) > 0.01 * max(map(abs, stress.values())) for axis in leaning)


def test_shear_of_stockinette_is_odd_and_its_normal_stresses_are_even(bar: Callable[..., None]) -> None:
    """Its loops are their own mirror images across the course: leaning one way or the other is the same."""
    found = []
    for way in (1.0, -1.0):
        cell = mounted()
        cell.go(PLANAR, steps=8)
        cell.go({"WC": way * SHEAR}, steps=4)
        found.append([cell.stress(axis) for axis in ("WC", "C", "W")])
    (one, *normal), (other, *mirrored) = found
    odd = abs(one + other) / abs(one)
    even = np.abs(np.array(normal) / np.array(mirrored) - 1.0).max()
    bar("shear axis: odd shear stress of stockinette", max(odd, float(even)), 1e-6, "1", "mirror symmetry")
    assert one > 0.0


def test_friction_takes_the_loop_of_a_cycle_of_shear(bar: Callable[..., None]) -> None:
    """To and fro at lengths that are held only the axis of shear does work: its loop is what friction took."""
    cell = mounted(friction=0.3)
    cell.go(PLANAR, steps=8, options=Options())
    way = np.linspace(-SHEAR, SHEAR, 13)
    cell.go({"WC": -SHEAR}, steps=6, options=Options())
    begun, strains, stresses = cell.state, [-SHEAR], [cell.stress("WC")]
    for strain in (*way[1:], *way[-2::-1]):
        cell.go({"WC": float(strain)}, options=Options())
        strains.append(float(strain))
        stresses.append(cell.stress("WC"))
    unit = cell.rig.work.model.scales.energy / cell.volume
    lost = unit * (cell.state.friction_work - begun.friction_work)
    area = loop_area(_array(strains), _array(stresses))
    done = unit * (cell.state.external_work - begun.external_work)
    stored = unit * float(cell.state.energies.sum() - begun.energies.sum())
    assert area > 0.05 * max(stresses) * SHEAR
    bar("shear axis: loop of a cycle against friction", abs(area / lost - 1.0), 0.03, "1", "first law")
    bar("shear axis: energy balance of a cycle", abs((stored + lost) / done - 1.0), 0.01, "1", "first law")


def _array(values: list[float]) -> FloatArray:
    return np.array(values)

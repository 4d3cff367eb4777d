"""Put a rig together: a knit on sliding hooks, carriages, load cells and encoders on the clocks of their machines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import material_named
from rigs.catalogue import arranged
from rigs.fixtures import largest_lateral, place, prescribe, pull, sliding_pins
from rigs.machine import instrument_of
from rigs.specimen import size_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.knits import Specimen
    from rigs.catalogue import MachineName
    from rigs.fixtures import Grip
    from rigs.instruments import Instrument
    from rigs.machine import Datum, MachineData
    from rigs.protocol import Protocol
    from rigs.record import FloatArray, SpecimenSize
    from rigs.steps import Axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rig:
    """Hold a rig with its specimen mounted.

    Attributes
    ----------
    specimen : Specimen
        The knit as it was made.
    size : SpecimenSize
        Its extents and radius [m].
    grips : Mapping
        The two grips of each axis that is driven, negative side first.
    work : Workspace
        The solver's model of the specimen and its buffers.
    mounted : FloatArray, shape (N, 4)
        The unknowns when the specimen was mounted [r], [rad].
    instruments : tuple of Instrument
        Load cells and encoders, one instrument a machine, each on its own clock.
    """

    specimen: Specimen
    size: SpecimenSize
    grips: Mapping[Axis, tuple[Grip, Grip]]
    work: Workspace
    mounted: FloatArray
    instruments: tuple[Instrument, ...]

    @property
    def gauges(self) -> dict[Axis, float]:
        """Return the initial hook-to-hook length of each axis that is driven [m]."""
        return {axis: self.size.extents[axis] for axis in self.grips}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Hold what the carriages feel, flawless and before any zeroing.

    Attributes
    ----------
    force : Mapping
        What the load cell of each axis feels of the pull on its two carriages [N], positive in tension.
    imbalance : Mapping
        Difference of those two pulls [N]; the solver's tolerance, not physics.
    lateral : float
        Largest force of a hook along its pole [N].
    """

    force: Mapping[Axis, float]
    imbalance: Mapping[Axis, float]
    lateral: float


def mount(specimen: Specimen, protocol: Protocol, data: Mapping[MachineName, MachineData]) -> tuple[Rig, State]:
    """Hang a specimen on the rig of a protocol, free of stress.

    Parameters
    ----------
    specimen : Specimen
        The knit that the protocol names.
    protocol : Protocol
        Gives rig, material, friction and the rate of the log.
    data : Mapping
        The numbers of the machines of the rig.

    Returns
    -------
    Rig, State
        The rig and the specimen's state as mounted.

    Raises
    ------
    SpecificationError
        If a machine's numbers ask for what pins on rigid carriages cannot do.
    """
    for numbers in data.values():
        _require_zero("pole.friction", numbers.pole.friction)
        _require_zero("carriage.compliance", numbers.carriage.compliance)
    material = material_named(protocol.specimen.material)
    model, state = make_model(
        [specimen.nodes],
        radius=specimen.radius,
        young_modulus=material.young_modulus.value,
        poisson_ratio=material.poisson_ratio.value,
        friction=protocol.specimen.friction,
    )
    drives = arranged(protocol.rig, protocol.mount)
    grips = {axis: sliding_pins(specimen, axis, drive) for axis, drive in drives.items()}
    for pair in grips.values():
        prescribe(pair, model.fixed)
    driven = {name: [axis for axis, drive in drives.items() if drive.machine == name] for name in data}
    rig = Rig(
        specimen=specimen,
        size=size_of(specimen, thickness=next(iter(data.values())).convention.thickness.value),
        grips=grips,
        work=Workspace(model),
        mounted=state.q.copy(),
        instruments=tuple(instrument_of(name, data[name], axes, protocol.log.rate) for name, axes in driven.items()),
    )
    return rig, state


def pose(rig: Rig, displacement: Mapping[Axis, float]) -> FloatArray:
    """Return the target (N, 4) of the held unknowns [r] with the axes at `displacement` [m]."""
    length = rig.work.model.scales.length
    travel = {axis: displacement[axis] / length for axis in rig.grips}
    return place(tuple(grip for pair in rig.grips.values() for grip in pair), rig.mounted, travel)


def read(rig: Rig, state: State) -> Reading:
    """Return what the carriages feel at an equilibrium."""
    unit = rig.work.model.scales.force
    pulls = {axis: [unit * pull(grip, state.reaction) for grip in pair] for axis, pair in rig.grips.items()}
    laterals = [largest_lateral(grip, state.reaction) for pair in rig.grips.values() for grip in pair]
    return Reading(
        force={
            axis: sum(grip.cell * felt for grip, felt in zip(rig.grips[axis], pair, strict=True))
            for axis, pair in pulls.items()
        },
        imbalance={axis: high - low for axis, (low, high) in pulls.items()},
        lateral=unit * max(laterals),
    )


def axial_strain(rig: Rig, state: State) -> FloatArray:
    """Return the axial strain of every edge of the yarn, shape (N - 1,) [1]."""
    edges: FloatArray = np.linalg.norm(np.diff(state.q[:, :3], axis=0), axis=1)
    return edges / rig.work.model.rods.rest_length[:-1] - 1.0


def place_of(rig: Rig, node: int) -> str:
    """Name the place of a node of the yarn in the words of a knitter."""
    specimen = rig.specimen
    return specimen.centreline.place(float(specimen.arc_lengths[node]) / specimen.loop_width)


def _require_zero(name: str, datum: Datum) -> None:
    """Raise unless a number of a machine is zero: what it stands for is not modelled with pins."""
    if datum.value != 0.0:
        raise SpecificationError(f"rig.{name}", f"{datum.value:g} {datum.unit}", "0 with hooks as pins")

"""Put the biaxial stage together: a knit on sliding hooks, four carriages, two load cells, an encoder, a clock.

The carriages of an axis stand and move symmetrically about the specimen's centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import material_named
from rigs.biaxial_data import stage_instrument
from rigs.fixtures import largest_lateral, place, prescribe, pull, sliding_pins
from rigs.motion import gauge_lengths
from rigs.protocol import AXES
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.knits import Specimen
    from rigs.biaxial_data import BiaxialData, Datum
    from rigs.fixtures import Grip
    from rigs.instruments import Instrument
    from rigs.protocol import Axis, Protocol
    from rigs.record import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BiaxialStage:
    """Hold a stage with its specimen mounted.

    Attributes
    ----------
    specimen : Specimen
        The knit as it was made.
    size : SpecimenSize
        Its hook-to-hook lengths, radius and thickness [m].
    grips : Mapping
        The two grips of each axis, negative side first.
    work : Workspace
        The solver's model of the specimen and its buffers.
    mounted : FloatArray, shape (N, 4)
        The unknowns when the specimen was mounted [r], [rad].
    instrument : Instrument
        Load cells and encoders, on the stage's clock.
    """

    specimen: Specimen
    size: SpecimenSize
    grips: Mapping[Axis, tuple[Grip, Grip]]
    work: Workspace
    mounted: FloatArray
    instrument: Instrument

    @property
    def gauges(self) -> dict[Axis, float]:
        """Return the initial hook-to-hook length of each axis [m]."""
        return {"C": self.size.gauge_C, "W": self.size.gauge_W}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Hold what the carriages feel, flawless and before any zeroing.

    Attributes
    ----------
    force : Mapping
        Load of each axis [N]: the mean pull on its two carriages, positive in tension.
    imbalance : Mapping
        Difference of those two pulls [N]; the solver's tolerance, not physics.
    lateral : float
        Largest force of a hook along its pole [N].
    """

    force: Mapping[Axis, float]
    imbalance: Mapping[Axis, float]
    lateral: float


def mount(specimen: Specimen, protocol: Protocol, data: BiaxialData) -> tuple[BiaxialStage, State]:
    """Hang a specimen on the stage, free of stress.

    Parameters
    ----------
    specimen : Specimen
        The knit that the protocol names.
    protocol : Protocol
        Gives material, friction and the rate of the log.
    data : BiaxialData
        The stage's numbers.

    Returns
    -------
    BiaxialStage, State
        The stage and the specimen's state as mounted.

    Raises
    ------
    SpecificationError
        If the stage's numbers ask for what pins on rigid carriages cannot do.
    """
    _require_zero("pole.friction", data.pole.friction)
    _require_zero("carriage.compliance", data.carriage.compliance)
    material = material_named(protocol.specimen.material)
    model, state = make_model(
        [specimen.nodes],
        radius=specimen.radius,
        young_modulus=material.young_modulus.value,
        poisson_ratio=material.poisson_ratio.value,
        friction=protocol.specimen.friction,
    )
    grips: dict[Axis, tuple[Grip, Grip]] = {axis: sliding_pins(specimen, axis) for axis in AXES}
    for pair in grips.values():
        prescribe(pair, model.fixed)
    lengths = gauge_lengths(specimen)
    stage = BiaxialStage(
        specimen=specimen,
        size=SpecimenSize(
            gauge_C=lengths["C"],
            gauge_W=lengths["W"],
            fibre_radius=specimen.radius,
            thickness=data.convention.thickness.value,
        ),
        grips=grips,
        work=Workspace(model),
        mounted=state.q.copy(),
        instrument=stage_instrument(data, protocol.log.rate),
    )
    return stage, state


def pose(stage: BiaxialStage, displacement: Mapping[Axis, float]) -> FloatArray:
    """Return the target (N, 4) of the held unknowns [r] with the axes at `displacement` [m]."""
    length = stage.work.model.scales.length
    travel = {axis: displacement[axis] / length for axis in AXES}
    return place(tuple(grip for pair in stage.grips.values() for grip in pair), stage.mounted, travel)


def read(stage: BiaxialStage, state: State) -> Reading:
    """Return what the carriages feel at an equilibrium."""
    unit = stage.work.model.scales.force
    pulls = {axis: [unit * pull(grip, state.reaction) for grip in pair] for axis, pair in stage.grips.items()}
    laterals = [largest_lateral(grip, state.reaction) for pair in stage.grips.values() for grip in pair]
    return Reading(
        force={axis: 0.5 * (low + high) for axis, (low, high) in pulls.items()},
        imbalance={axis: high - low for axis, (low, high) in pulls.items()},
        lateral=unit * max(laterals),
    )


def axial_strain(stage: BiaxialStage, state: State) -> FloatArray:
    """Return the axial strain of every edge of the yarn, shape (N - 1,) [1]."""
    edges: FloatArray = np.linalg.norm(np.diff(state.q[:, :3], axis=0), axis=1)
    return edges / stage.work.model.rods.rest_length[:-1] - 1.0


def place_of(stage: BiaxialStage, node: int) -> str:
    """Name the place of a node of the yarn in the words of a knitter."""
    specimen = stage.specimen
    return specimen.centreline.place(float(specimen.arc_lengths[node]) / specimen.loop_width)


def _require_zero(name: str, datum: Datum) -> None:
    """Raise unless a number of the stage is zero: what it stands for is not modelled with pins."""
    if datum.value != 0.0:
        raise SpecificationError(f"rig.{name}", f"{datum.value:g} {datum.unit}", "0 with hooks as pins")

"""A rig with its specimen mounted: a knit on hooks, carriages, load cells and encoders on their clocks."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.hook_friction import pole_forces
from knitlab_core.equilibrium.model import DECIMALS
from knitlab_core.equilibrium.rupture import Spot, break_fibre, weakest
from rigs.axes import DIRECTIONS, FACE, SHEARS
from rigs.machines.fixtures import (
    largest_lateral,
    place,
    pull,
    rigid_forces,
    rigid_names,
)
from rigs.machines.pins import distance, stitch_pitch

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from knitlab_core.equilibrium.workspace import Workspace
    from knitlab_core.knits import PinSpots, Specimen
    from rigs.axes import Axis, FloatArray
    from rigs.instruments.channels import Instrument
    from rigs.machines.fixtures import Grip
    from rigs.machines.load_train import LoadTrain
    from rigs.record import SpecimenSize


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rig:
    """A rig with its specimen mounted.

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
        The unknowns when the specimen was mounted, those of wires after the yarn's [r], [rad].
    instruments : tuple of Instrument
        Load cells and encoders, one instrument a machine, each on its own clock.
    breaks_at : float or None
        Strain at its surface at which a fibre breaks [1]; None where rupture is off.
    trains : Mapping
        What lies between crosshead and fixture of each axis.
    pins : Mapping
        Both pins of the extensometer along each axis that it measures.
    relaxed : bool
        Whether the yarn is straight at rest, and relaxed into its loops before it was mounted.
    severed : tuple of int
        The edges of the yarn that broke, in order.
    measured : bool
        Whether the yarn is one by measurement, of whose fibres only the mean strain is known.
    sheared : bool
        Whether a periodic cell is free to shear where no axis drives it.
    """

    specimen: Specimen
    size: SpecimenSize
    grips: Mapping[Axis, tuple[Grip, Grip]]
    work: Workspace
    mounted: FloatArray
    instruments: tuple[Instrument, ...]
    breaks_at: float | None
    trains: Mapping[Axis, LoadTrain]
    pins: Mapping[Axis, PinSpots] = field(default_factory=dict)
    relaxed: bool = False
    severed: tuple[int, ...] = ()
    measured: bool = False
    sheared: bool = False

    @property
    def gauges(self) -> dict[Axis, float]:
        """Return the gauge length of each axis that is driven [m]: the initial hook-to-hook length along it."""
        return {axis: self.size.gauge(axis) for axis in self.grips}

    @property
    def cell_columns(self) -> tuple[str, ...]:
        """Return the components of a periodic cell's vectors that its rows have; none of a specimen with edges.

        ``W`` is the length along the wale, ``WC`` how far its vector leans along the course where it is driven or free
        to.
        """
        if self.specimen.cell is None:
            return ()
        directions = DIRECTIONS[: len(self.specimen.cell.vectors)]
        leaning = [axis for axis in SHEARS if FACE[axis] in directions and (self.sheared or axis in self.grips)]
        return (*directions, *leaning)

    @property
    def fixture_forces(self) -> list[str]:
        """Return the names of the forces that its clamps or plates are read by; none where hooks hold the specimen."""
        grips = (grip for pair in self.grips.values() for grip in pair)
        return [name for grip in grips if grip.rigid for name in rigid_names(grip.axis, grip.side)]

    @property
    def relaxed_pitch(self) -> dict[Axis, float]:
        """Return the pitch of the stitches as mounted [m] of a yarn that relaxed into them; empty of a printed one."""
        model = self.work.model
        return stitch_pitch(self.specimen, self.mounted * model.scales.length) if self.relaxed else {}

    @property
    def strands(self) -> tuple[int, ...]:
        """Return the nodes of every strand."""
        return tuple(len(strand) for strand in self.specimen.strands)

    @property
    def fibre_reach(self) -> float:
        """Return how far from its centreline a rod strains when it bends [r].

        A solid fibre to its surface; loose fibres of a yarn seen as one rod each to its own, glued ones to the yarn's;
        of a yarn by measurement nothing is known of it, so that what it strains by is the axial strain alone.
        """
        if self.measured:
            return 0.0
        yarn = self.specimen.yarn
        reach = yarn.fibre_radius
        if yarn.model == "yarn":
            reach += yarn.bonding * yarn.winding_radius
        return reach / yarn.contact_radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Forces on the carriages, without noise and before any zeroing.

    Attributes
    ----------
    force : Mapping
        What the load cell of each axis feels of the pull on its two carriages [N], positive in tension.
    imbalance : Mapping
        Difference of those two pulls [N]; the solver's tolerance, not physics.
    lateral : float
        Largest force of a hook along its pole [N].
    pins : Mapping
        Distance of the extensometer's pins along each axis that it measures [m].
    fixture : Mapping
        Force of every clamp or plate on the specimen [N] along each direction: ``W+_C`` is that of the upper clamp
        of the wale along the course. Empty where hooks hold it.
    """

    force: Mapping[Axis, float]
    imbalance: Mapping[Axis, float]
    lateral: float
    fixture: Mapping[str, float]
    pins: Mapping[Axis, float]


def pose(rig: Rig, displacement: Mapping[Axis, float]) -> FloatArray:
    """Return the target (N, 4) of the held unknowns [r] with the axes at `displacement` [m]."""
    length = rig.work.model.scales.length
    travel = {axis: round(displacement[axis] / length, DECIMALS) for axis in rig.grips}
    return place(tuple(grip for pair in rig.grips.values() for grip in pair), rig.mounted, travel)


def read(rig: Rig, state: State) -> Reading:
    """Return what the carriages feel at an equilibrium."""
    unit = rig.work.model.scales.force
    pulls = {axis: [unit * pull(grip, state.reaction) for grip in pair] for axis, pair in rig.grips.items()}
    laterals = [largest_lateral(grip, state.reaction) for pair in rig.grips.values() for grip in pair]
    model = rig.work.model
    if model.hooks is not None:
        laterals += list(np.abs(pole_forces(model.hooks, state.poles, model.law.slip)))
    return Reading(
        force={
            axis: sum(grip.cell * felt for grip, felt in zip(rig.grips[axis], pair, strict=True))
            for axis, pair in pulls.items()
        },
        imbalance={axis: 0.0 if rig.specimen.cell else high - low for axis, (low, high) in pulls.items()},
        lateral=unit * max(laterals),
        fixture={
            name: unit * force
            for pair in rig.grips.values()
            for grip in pair
            for name, force in rigid_forces(grip, state.reaction).items()
        },
        pins={axis: distance(spots, axis, state.q) * model.scales.length for axis, spots in rig.pins.items()},
    )


def most_strained(rig: Rig, state: State) -> Spot:
    """Return the spot where a fibre's surface is strained most: its edge and its strain [1]."""
    return weakest(rig.work.model, state, rig.fibre_reach)


def without_edge(rig: Rig, state: State, edge: int, options: Options | None = None) -> tuple[Rig, State]:
    """Break a fibre where it is strained most, and let go what hung on it.

    Returns
    -------
    Rig, State
        The rig with a fibre the less, its carriages where they were.

    Raises
    ------
    ConvergenceError
        If what is left finds no equilibrium.
    """
    before = rig.work.model.fixed
    work, found = break_fibre(rig.work, state, edge, options)
    # Angles that nothing turns any more stay where they are.
    mounted = np.where(work.model.fixed & ~before, found.q, rig.mounted)
    return replace(rig, work=work, mounted=mounted, severed=(*rig.severed, edge)), found


def place_of(rig: Rig, node: int) -> str:
    """Return the place of a node of the yarn as text: row and loop."""
    specimen = rig.specimen
    if node >= len(specimen.nodes):
        return "a wire" if specimen.cell is None else "an image of the cell"
    fibre, along = divmod(node, len(specimen.arc_lengths))
    if specimen.cell is not None:
        loop = along * specimen.loops // (len(specimen.arc_lengths) - 2)
        return f"row {fibre}, loop {loop % specimen.loops} of the cell"
    place = specimen.centreline.place(float(specimen.arc_lengths[along]) / specimen.loop_width)
    return place if len(rig.strands) == 1 else f"fibre {fibre + 1} at {place}"

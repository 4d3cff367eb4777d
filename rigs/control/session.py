"""Session of a test: the rig with its specimen, the current state, and the rows it yields."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import floor
from typing import TYPE_CHECKING, Final, TypeVar

from knitlab_core.equilibrium.stopwatch import Cost
from knitlab_core.knits import clasp_nodes, clasps_held, clasps_hold
from rigs.analysis.clasps import unravelled
from rigs.control.checkpoint import checkpoint_of
from rigs.control.path import AxisPath, follow, with_jumps
from rigs.control.resume_point import END, START
from rigs.control.stop_criteria import StopReason
from rigs.instruments.channels import overloaded
from rigs.machines.rig import most_strained, place_of, read
from rigs.machines.shape import axial_strain, bending_strain, cell_shape, contact_force, wire_ends
from rigs.protocol.strokes import Readings
from rigs.record import Equilibrium, Frame

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from knitlab_core.equilibrium.rupture import Spot
    from knitlab_core.knits import ClaspNodes
    from rigs.axes import Axis
    from rigs.control.checkpoint import Checkpoint
    from rigs.control.controller import Controller, Memory
    from rigs.control.path import PathPoint
    from rigs.control.resume_point import Displacement, ResumePoint
    from rigs.machines.rig import Rig
    from rigs.protocol.strokes import Stroke

T = TypeVar("T")

FRAME_SPACING: Final = 0.025
"""Between marks, frames are as many equilibria that are there anyway as keep them about this strain apart."""


@dataclass(slots=True, kw_only=True, eq=False)
class Session:
    """Test under way.

    Attributes
    ----------
    rig : Rig
        The rig with the specimen on it.
    state : State
        The specimen's state now.
    controller : Controller
        The controller, which reads the load cells.
    cursor : ResumePoint
        Position in the protocol; its last row has the displacements of the axes and the time.
    increment : float
        Largest strain between two equilibria [1].
    options : Options or None
        How hard the solver tries.
    go_on : bool
        Whether the test goes on after a fibre broke.
    displacement, crosshead : Mapping
        Displacements of the fixtures, and of the crossheads, of the axes [m]; 0 where the specimen was mounted.
    time : float
        Time on the rig's clock [s].
    counted : Cost
        What the solver spent on the rows that were accepted.
    torn, stopping : str or None, bool
        Message of the fibre that ended the test by breaking; whether the step under way is to end at its next row.
    clasps : Mapping
        Nodes of the specimen's clasps, by what they join.
    """

    rig: Rig
    state: State
    controller: Controller
    cursor: ResumePoint
    increment: float
    options: Options | None = None
    go_on: bool = False
    displacement: Displacement = field(init=False)
    crosshead: Displacement = field(init=False)
    time: float = field(init=False)
    counted: Cost = field(default_factory=Cost)
    torn: str | None = None
    stopping: bool = False
    clasps: Mapping[str, ClaspNodes] = field(init=False)

    def __post_init__(self) -> None:
        self.clasps = clasp_nodes(self.rig.specimen)
        last, still = self.cursor.last, dict.fromkeys(self.rig.grips, 0.0)
        self.displacement = still if last is None else last.displacement
        self.crosshead = still if last is None else last.crosshead
        self.time = 0.0 if last is None else last.time
        if last is not None:
            self.counted = self.rig.work.clock.cost

    @property
    def last(self) -> Equilibrium | None:
        """Return the last row."""
        return self.cursor.last

    @property
    def memory(self) -> Memory:
        """Return what the controller remembers."""
        return self.cursor.memory

    def remember(self, memory: Memory) -> None:
        """Replace the controller's memory."""
        self.cursor = replace(self.cursor, memory=memory)

    def readings(self) -> Readings:
        """Return the readings of the controller."""
        force = dict.fromkeys(self.rig.grips, 0.0) if self.last is None else self.last.force
        shown = self.controller.steady(force, self.memory)
        return Readings(displacement=self.crosshead, force=shown, opening=self.displacement)

    def begin(self, readings: Readings) -> None:
        """Begin a stroke at the current displacements."""
        self.cursor = replace(
            self.cursor,
            readings=readings,
            begun=self.time,
            segment=0,
            origin=self.displacement,
            place=START,
            variables={},
        )

    def segments(self, segments: Iterable[T]) -> Iterator[T]:
        """Yield the segments of a stroke, from the one under way on."""
        for number, segment in enumerate(segments):
            if number < self.cursor.segment:
                continue
            if number > self.cursor.segment:
                self.cursor = replace(self.cursor, segment=number, origin=self.displacement, place=START)
            yield segment

    def note(self, **variables: float) -> None:
        """Keep what the controller of the stroke needs to resume after the next row; it replaces what was kept."""
        self.cursor = replace(self.cursor, variables=variables)

    def checkpoint(self) -> Checkpoint | None:
        """Return what the test needs to resume from the last row; None if it cannot resume there."""
        if self.cursor.readings is None or self.cursor.place is None or self.over() is not None:
            return None
        return checkpoint_of(self.rig, self.state, self.cursor)

    def strain(self, start: Displacement, end: Displacement) -> float:
        """Return the largest strain of an axis between two displacements [1]."""
        return max(self.strains(start, end).values())

    def strains(self, start: Displacement, end: Displacement) -> dict[Axis, float]:
        """Return the magnitude of the strain of each axis between two displacements [1]."""
        return {axis: abs(end[axis] - start[axis]) / length for axis, length in self.rig.gauges.items()}

    def go_on_to(self, goal: Displacement, *, longest: float, duration: float = 0.0) -> Iterator[PathPoint]:
        """Yield the equilibria that are left of the segment under axis_path, which ends at `goal`; see `AxisPath`."""
        axis_path = self._axis_path(self.cursor.origin, goal, longest, duration)
        return follow(self.rig, self.state, axis_path, START if self.cursor.place is None else self.cursor.place)

    def reach(self, goal: Displacement, *, duration: float = 0.0, increment: float | None = None) -> PathPoint:
        """Return the equilibrium at `goal`, or where the test ends before; stay here."""
        strain = self.strain(self.displacement, goal)
        longest = 1.0 if increment is None or strain == 0.0 else min(1.0, increment / strain)
        steps = list(follow(self.rig, self.state, self._axis_path(self.displacement, goal, longest, duration), START))
        return with_jumps(self.state, steps)

    def _axis_path(self, start: Displacement, goal: Displacement, longest: float, duration: float) -> AxisPath:
        return AxisPath(
            start=start, goal=goal, longest=longest, duration=duration, options=self.options, go_on=self.go_on
        )

    def accept(self, step: PathPoint, stroke: Stroke, crosshead: Displacement) -> Equilibrium:
        """Take an equilibrium, with the displacements of its crossheads, as the current state; return its row."""
        self.rig, self.state, self.displacement, self.crosshead = step.rig, step.state, step.displacement, crosshead
        if step.broken is not None and step.final:
            self.torn = self._tear(step.broken)
        unit = self.rig.work.model.scales.energy
        reading = read(self.rig, step.state)
        stretch, bend, twist, contact = (unit * float(part) for part in step.state.energies)
        whole, cost = int(step.state.bonds.whole.sum()), self.uncounted()
        self.counted += cost
        row = Equilibrium(
            time=self.time,
            displacement=step.displacement,
            crosshead=crosshead,
            force=reading.force,
            lateral_force=reading.lateral,
            fixture_force=reading.fixture,
            pin_distance=reading.pins,
            elastic_stretch=stretch,
            elastic_bend=bend,
            elastic_twist=twist,
            contact_energy=contact,
            friction_work=unit * step.state.friction_work,
            external_work=unit * step.state.external_work,
            viscous_work=unit * step.state.viscous_work,
            plastic_work=unit * step.state.plastic_work,
            fracture_work=unit * step.state.fracture_work,
            snap_work=unit * step.state.snap_work,
            bond_energy=unit * step.state.bonds.energy,
            bond_released=unit * step.state.bonds.released,
            bonds_whole=whole,
            bonds_broken=step.state.bonds.whole.size - whole,
            clasps=clasps_held(step.state.q[:, :3], self.clasps),
            cell=cell_shape(self.rig, step.state),
            fibre_strain=most_strained(self.rig, step.state).strain,
            residual=step.report.residual,
            contacts=step.report.contacts,
            iterations=cost.iterations,
            factorisations=cost.factorisations,
            seconds=cost.seconds,
            cycle=stroke.cycle,
            phase=stroke.phase,
            tag=stroke.tag,
            step=stroke.step,
        )
        memory = self.controller.read(self.memory, row, len(self.rig.severed) + row.bonds_broken)
        self.cursor = replace(self.cursor, last=row, place=step.place, memory=memory)
        return row

    def uncounted(self) -> Cost:
        """Return what the solver spent since the last row, all trials included."""
        return self.rig.work.clock.cost - self.counted

    def stand(self, stroke: Stroke) -> Equilibrium:
        """Return the row of a specimen that did not move."""
        if self.last is None:
            msg = "a specimen must be mounted before it can stand still"
            raise RuntimeError(msg)
        row = replace(
            self.last,
            time=self.time,
            iterations=0,
            factorisations=0,
            seconds=0.0,
            cycle=stroke.cycle,
            phase=stroke.phase,
            tag=stroke.tag,
            step=stroke.step,
        )
        memory = self.controller.read(self.memory, row, len(self.rig.severed) + row.bonds_broken)
        self.cursor = replace(self.cursor, last=row, place=END, memory=memory)
        return row

    def frame(self, *, image: str | None = None) -> Frame:
        """Return the shape of the knit now; a frame for the microscope has the name of its image."""
        return Frame(
            time=self.time,
            nodes=self.state.q[: len(self.rig.specimen.nodes), :3] * self.rig.work.model.scales.length,
            axial_strain=axial_strain(self.rig, self.state),
            bending_strain=bending_strain(self.rig, self.state),
            contact_force=contact_force(self.rig, self.state),
            wires=wire_ends(self.rig, self.state),
            strain={axis: self.displacement[axis] / length for axis, length in self.rig.gauges.items()},
            cycle=1 if self.last is None else self.last.cycle,
            phase="Zero" if self.last is None else self.last.phase,
            image=image,
        )

    def passes_frame(self, before: Displacement) -> bool:
        """Return whether an axis passed the strain of a frame since some displacements [m]."""
        return any(
            floor(before[axis] / (FRAME_SPACING * length)) != floor(self.displacement[axis] / (FRAME_SPACING * length))
            for axis, length in self.rig.gauges.items()
        )

    def pictured(self, tag: str | None) -> Frame:
        """Return the shape of the knit, as one of which an image is taken."""
        return self.frame(image=tag or "image")

    def over(self) -> StopReason | None:
        """Return how the last row ended the test (a rupture, an instrument's limit) or its step (a stop), if it did."""
        if self.torn is not None:
            return StopReason(end="rupture", message=self.torn, test=True)
        for instrument in self.rig.instruments:
            channel = None if self.last is None else overloaded(instrument, self.last)
            if channel is not None:
                passed = f"{channel.name} passed its limit of {channel.limit:g} {channel.unit}"
                return StopReason(end="limit", message=f"{passed} at {self.whereabouts()}", test=True)
        return StopReason(end="abort", message="stopped") if self.stopping else None

    def parted(self) -> str:
        """Return as a message which rows or layers no clasp holds together any more; empty if all are held."""
        laid, now = (clasps_hold(x, self.clasps) for x in (self.rig.specimen.nodes, self.state.q[:, :3]))
        return unravelled(laid, now)

    def whereabouts(self) -> str:
        """Return the strains of the axes as text."""
        strains = ((axis, self.displacement[axis] / length) for axis, length in self.rig.gauges.items())
        return "strain " + ", ".join(f"{axis} {strain:.1%}" for axis, strain in strains)

    def _tear(self, spot: Spot) -> str:
        """Return the message of a fibre that ended the test by breaking."""
        where = f"{place_of(self.rig, spot.edge)} of the yarn, strained by {spot.strain:.3%}"
        torn = "; what is left of the knit finds no balance" if self.go_on else ""
        return f"a fibre broke at {self.whereabouts()}: {where}{torn}"

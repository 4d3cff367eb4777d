"""Stand a mounted specimen on its rig and move it: where it is now, and the row that says so."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rigs.instruments import overloaded
from rigs.record import Equilibrium, Frame, Outcome
from rigs.rig import axial_strain, most_strained, place_of, read, wire_ends
from rigs.way import Way, follow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from knitlab_core.equilibrium.rupture import Spot
    from rigs.motion import Stroke
    from rigs.record import Phase
    from rigs.rig import Rig
    from rigs.way import Displacement, Step


@dataclass(slots=True, kw_only=True, eq=False)
class Bench:
    """Hold a test under way.

    Attributes
    ----------
    rig : Rig
        The rig with the specimen on it.
    state : State
        The specimen's state now.
    options : Options or None
        How hard the solver tries.
    go_on : bool
        Whether the test goes on after a fibre broke.
    displacement : Mapping
        Where the axes stand [m]: at first, where they were when the specimen was mounted.
    time : float
        Time on the rig's clock [s].
    last : Equilibrium or None
        The last row.
    ended : Outcome or None
        How the test ended, if a fibre that broke ended it.
    """

    rig: Rig
    state: State
    options: Options | None = None
    go_on: bool = False
    displacement: Displacement = field(init=False)
    time: float = 0.0
    last: Equilibrium | None = None
    ended: Outcome | None = None

    def __post_init__(self) -> None:
        self.displacement = dict.fromkeys(self.rig.grips, 0.0)

    def strain(self, start: Displacement, end: Displacement) -> float:
        """Return the strain of a way: that of the axis that strains most [1]."""
        return max(abs(end[axis] - start[axis]) / length for axis, length in self.rig.gauges.items())

    def march_to(self, goal: Displacement, *, longest: float, duration: float = 0.0) -> Iterator[Step]:
        """Yield the equilibria on the straight way from here to `goal`, without going there; see `Way`."""
        way = Way(
            start=self.displacement,
            goal=goal,
            longest=longest,
            duration=duration,
            options=self.options,
            go_on=self.go_on,
        )
        return follow(self.rig, self.state, way)

    def reach(self, goal: Displacement, *, duration: float = 0.0) -> Step:
        """Return the equilibrium at `goal`, or where the test ends before, and the cost of the way; stay here."""
        steps = list(self.march_to(goal, longest=1.0, duration=duration))
        return replace(
            steps[-1],
            iterations=sum(step.iterations for step in steps),
            factorisations=sum(step.factorisations for step in steps),
            seconds=sum(step.seconds for step in steps),
        )

    def accept(self, step: Step, phase: Phase, cycle: int, tag: str | None) -> Equilibrium:
        """Go where a step went, and return its row."""
        self.rig, self.state, self.displacement = step.rig, step.state, step.displacement
        if step.broken is not None and step.final:
            self.ended = self._ruptured(step.broken)
        unit = self.rig.work.model.scales.energy
        reading = read(self.rig, step.state)
        stretch, bend, twist, contact = (unit * float(part) for part in step.state.energies)
        whole = int(step.state.bonds.whole.sum())
        self.last = Equilibrium(
            time=self.time,
            displacement=step.displacement,
            force=reading.force,
            lateral_force=reading.lateral,
            elastic_stretch=stretch,
            elastic_bend=bend,
            elastic_twist=twist,
            contact_energy=contact,
            friction_work=unit * step.state.friction_work,
            external_work=unit * step.state.external_work,
            viscous_work=unit * step.state.viscous_work,
            fracture_work=unit * step.state.fracture_work,
            bond_energy=unit * step.state.bonds.energy,
            bond_released=unit * step.state.bonds.released,
            bonds_whole=whole,
            bonds_broken=step.state.bonds.whole.size - whole,
            fibre_strain=most_strained(self.rig, step.state).strain,
            residual=step.report.residual,
            contacts=step.report.contacts,
            iterations=step.iterations,
            factorisations=step.factorisations,
            seconds=step.seconds,
            cycle=cycle,
            phase=phase,
            tag=tag,
        )
        return self.last

    def stand(self, stroke: Stroke) -> Equilibrium:
        """Return the row of a stroke that moves nothing."""
        if self.last is None:
            msg = "a specimen must be mounted before it can stand still"
            raise RuntimeError(msg)
        self.last = replace(
            self.last,
            time=self.time,
            iterations=0,
            factorisations=0,
            seconds=0.0,
            cycle=stroke.cycle,
            phase=stroke.phase,
            tag=stroke.tag,
        )
        return self.last

    def frame(self) -> Frame:
        """Return the shape of the knit as it is now."""
        return Frame(
            time=self.time,
            nodes=self.state.q[: len(self.rig.specimen.nodes), :3] * self.rig.work.model.scales.length,
            axial_strain=axial_strain(self.rig, self.state),
            wires=wire_ends(self.rig, self.state),
            strain={axis: self.displacement[axis] / length for axis, length in self.rig.gauges.items()},
            cycle=1 if self.last is None else self.last.cycle,
            phase="Zero" if self.last is None else self.last.phase,
        )

    def outcome(self) -> Outcome | None:
        """Return how the test ended, if the last row is its last: a rupture, or more than an instrument can take."""
        if self.ended is not None or self.last is None:
            return self.ended
        for instrument in self.rig.instruments:
            channel = overloaded(instrument, self.last)
            if channel is not None:
                passed = f"{channel.name} passed its limit of {channel.limit:g} {channel.unit}"
                return Outcome(end="limit", message=f"{passed} at {self.whereabouts()}")
        return None

    def whereabouts(self) -> str:
        """Say where the axes stand, as strains."""
        strains = ((axis, self.displacement[axis] / length) for axis, length in self.rig.gauges.items())
        return "strain " + ", ".join(f"{axis} {strain:.1%}" for axis, strain in strains)

    def _ruptured(self, spot: Spot) -> Outcome:
        """Return the outcome of a fibre that broke."""
        where = f"{place_of(self.rig, spot.edge)} of the yarn, strained by {spot.strain:.3%}"
        torn = "; what is left of the knit finds no balance" if self.go_on else ""
        return Outcome(end="rupture", message=f"a fibre broke at {self.whereabouts()}: {where}{torn}")

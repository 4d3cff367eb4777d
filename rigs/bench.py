"""Stand a mounted specimen on its rig and move it: where it is now, and the row that says so."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeVar

from rigs.checkpoint import checkpoint_of
from rigs.cursor import END, START, Cursor
from rigs.instruments import overloaded
from rigs.record import Equilibrium, Frame, Outcome
from rigs.rig import axial_strain, most_strained, place_of, read
from rigs.way import Way, follow

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options
    from knitlab_core.equilibrium.rupture import Spot
    from rigs.checkpoint import Checkpoint
    from rigs.cursor import Displacement
    from rigs.motion import Stroke
    from rigs.record import Phase
    from rigs.rig import Rig
    from rigs.way import Step

T = TypeVar("T")


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
    cursor : Cursor
        Where in its protocol the test stands; its last row says where the axes are and what time it is.
    displacement : Mapping
        Where the axes stand [m]: at first, where they were when the specimen was mounted.
    time : float
        Time on the rig's clock [s].
    ended : Outcome or None
        How the test ended, if a fibre that broke ended it.
    """

    rig: Rig
    state: State
    options: Options | None = None
    go_on: bool = False
    cursor: Cursor = field(default_factory=Cursor)
    displacement: Displacement = field(init=False)
    time: float = field(init=False)
    ended: Outcome | None = None

    def __post_init__(self) -> None:
        last = self.cursor.last
        self.displacement = dict.fromkeys(self.rig.grips, 0.0) if last is None else last.displacement
        self.time = 0.0 if last is None else last.time

    @property
    def last(self) -> Equilibrium | None:
        """Return the last row."""
        return self.cursor.last

    def begin(self) -> None:
        """Begin the next stroke where the axes stand."""
        self.cursor = replace(
            self.cursor,
            stroke=self.cursor.stroke + 1,
            begun=self.time,
            leg=0,
            origin=self.displacement,
            place=START,
            variables={},
        )

    def legs(self, legs: Iterable[T]) -> Iterator[T]:
        """Yield the legs of a stroke, from the one under way on."""
        for number, leg in enumerate(legs):
            if number < self.cursor.leg:
                continue
            if number > self.cursor.leg:
                self.cursor = replace(self.cursor, leg=number, origin=self.displacement, place=START)
            yield leg

    def note(self, **variables: float) -> None:
        """Keep what the controller of the stroke needs to go on after the next row; all of it anew."""
        self.cursor = replace(self.cursor, variables=variables)

    def finish(self, stroke: Stroke) -> None:
        """End a stroke where the axes stand."""
        if self.displacement != stroke.end:
            reached = {**self.cursor.reached, self.cursor.stroke: self.displacement}
            self.cursor = replace(self.cursor, reached=reached)

    def checkpoint(self) -> Checkpoint | None:
        """Return what the test needs to go on from the last row; None if it cannot go on from there."""
        if self.cursor.stroke == 0 or self.cursor.place is None or self.outcome() is not None:
            return None
        return checkpoint_of(self.rig, self.state, self.cursor)

    def strain(self, start: Displacement, end: Displacement) -> float:
        """Return the strain of a way: that of the axis that strains most [1]."""
        return max(abs(end[axis] - start[axis]) / length for axis, length in self.rig.gauges.items())

    def march_to(self, goal: Displacement, *, longest: float, duration: float = 0.0) -> Iterator[Step]:
        """Yield the equilibria on the straight way from here to `goal`, without going there; see `Way`."""
        return follow(self.rig, self.state, self._way(self.displacement, goal, longest, duration))

    def go_on_to(self, goal: Displacement, *, longest: float, duration: float = 0.0) -> Iterator[Step]:
        """Yield the equilibria that are left of the leg under way, which ends at `goal`; see `Way`."""
        way = self._way(self.cursor.origin, goal, longest, duration)
        return follow(self.rig, self.state, way, START if self.cursor.place is None else self.cursor.place)

    def _way(self, start: Displacement, goal: Displacement, longest: float, duration: float) -> Way:
        return Way(start=start, goal=goal, longest=longest, duration=duration, options=self.options, go_on=self.go_on)

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
        row = Equilibrium(
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
        self.cursor = replace(self.cursor, last=row, place=step.place)
        return row

    def stand(self, stroke: Stroke) -> Equilibrium:
        """Return the row of a stroke that moves nothing."""
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
        )
        self.cursor = replace(self.cursor, last=row, place=END)
        return row

    def frame(self) -> Frame:
        """Return the shape of the knit as it is now."""
        return Frame(
            time=self.time,
            nodes=self.state.q[:, :3] * self.rig.work.model.scales.length,
            axial_strain=axial_strain(self.rig, self.state),
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

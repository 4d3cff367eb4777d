"""Stand a mounted specimen on its rig and move it: where it is now, and the row that says so."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING, TypeAlias

from knitlab_core.equilibrium.march import march
from rigs.instruments import overloaded
from rigs.record import Equilibrium, Frame, Outcome
from rigs.rig import axial_strain, pose, read

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.newton import Options, Report
    from rigs.motion import Stroke
    from rigs.record import Phase
    from rigs.rig import Rig
    from rigs.steps import Axis

Displacement: TypeAlias = "Mapping[Axis, float]"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """Hold one equilibrium on a way.

    Attributes
    ----------
    share : float
        How far along the way it lies [1].
    displacement : Mapping
        Where the axes stand [m].
    state, report
        The specimen's state, and how its search went.
    iterations, factorisations : int
        What the search cost.
    seconds : float
        How long it took [s].
    """

    share: float
    displacement: Displacement
    state: State
    report: Report
    iterations: int
    factorisations: int
    seconds: float


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
    displacement : Mapping
        Where the axes stand [m]: at first, where they were when the specimen was mounted.
    time : float
        Time on the rig's clock [s].
    last : Equilibrium or None
        The last row.
    """

    rig: Rig
    state: State
    options: Options | None = None
    displacement: Displacement = field(init=False)
    time: float = 0.0
    last: Equilibrium | None = None

    def __post_init__(self) -> None:
        self.displacement = dict.fromkeys(self.rig.grips, 0.0)

    def strain(self, start: Displacement, end: Displacement) -> float:
        """Return the strain of a way: that of the axis that strains most [1]."""
        return max(abs(end[axis] - start[axis]) / length for axis, length in self.rig.gauges.items())

    def march_to(self, goal: Displacement, *, longest: float) -> Iterator[Step]:
        """Yield the equilibria on the straight way from here to `goal`; the caller's own time is not counted."""
        rig, start = self.rig, self.displacement
        path = march(
            rig.work,
            self.state,
            lambda share: pose(rig, between(start, goal, share)),
            longest=longest,
            options=self.options,
        )
        while True:
            began, made = perf_counter(), rig.work.factorisations
            found = next(path, None)
            if found is None:
                return
            share, state, report = found
            yield Step(
                share=share,
                displacement=between(start, goal, share),
                state=state,
                report=report,
                iterations=report.iterations,
                factorisations=rig.work.factorisations - made,
                seconds=perf_counter() - began,
            )

    def reach(self, goal: Displacement) -> Step:
        """Return the equilibrium at `goal`, and what the whole way to it cost, without going there."""
        steps = list(self.march_to(goal, longest=1.0))
        return replace(
            steps[-1],
            iterations=sum(step.iterations for step in steps),
            factorisations=sum(step.factorisations for step in steps),
            seconds=sum(step.seconds for step in steps),
        )

    def accept(self, step: Step, phase: Phase, cycle: int, tag: str | None) -> Equilibrium:
        """Go where a step went, and return its row."""
        self.state, self.displacement = step.state, step.displacement
        unit = self.rig.work.model.scales.energy
        reading = read(self.rig, step.state)
        stretch, bend, twist, contact = (unit * float(part) for part in step.state.energies)
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
            nodes=self.state.q[:, :3] * self.rig.work.model.scales.length,
            axial_strain=axial_strain(self.rig, self.state),
            strain={axis: self.displacement[axis] / length for axis, length in self.rig.gauges.items()},
            cycle=1 if self.last is None else self.last.cycle,
            phase="Zero" if self.last is None else self.last.phase,
        )

    def overload(self) -> Outcome | None:
        """Return the outcome if the last row is more than an instrument of the rig can take."""
        if self.last is None:
            return None
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


def between(start: Displacement, end: Displacement, share: float) -> dict[Axis, float]:
    """Return the displacements at a share of a straight way; exact at both ends, and where an axis stands still."""
    if share == 1.0:
        return dict(end)
    return {axis: start[axis] + share * (end[axis] - start[axis]) for axis in end}

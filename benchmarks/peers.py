"""Print one table of the lab's kernels beside those of peers: ``python -m benchmarks.peers``.

- MKL's Pardiso and QDLDL factor the lab's stiffness, planar 6x6 at 33 % strain and volumetric 6x6x6.
- ipctk (IPC toolkit) computes barrier and friction of the knit's centrelines at 33 %, with about as many contacts.
- PyElastica drags a rod over two rigid cylinders: its contact between two rods has no friction, that of a rod on a
  rigid cylinder has. The force of friction is mu N, so both codes have the same known answer; both have six edges.

A peer that is not installed is named and left out. One thread each; times are the least of several.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from math import pi
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.linear_solvers import System, compare, milliseconds, printed
from benchmarks.main_job import at_strain, stiffness
from knitlab_core.contact.friction import Memory
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray, IndexArray

STRAIN: Final = 0.33
MU: Final = 0.3

# The rod on two cylinders: lengths in r, forces in E r^2.
EDGE: Final = 2.0
HALF_SPAN: Final = 3.0
HALF_LENGTH: Final = 6.0
OVERLAP: Final = 0.05
TRAVEL: Final = 1.0
POISSON_RATIO: Final = 0.37
PRESS: Final = 4.0 / 3.0 * 0.5 / (1.0 - POISSON_RATIO**2) * OVERLAP**1.5
"""Hertz's force on each crossing at that overlap (Johnson 1985, eq. 4.23)."""


Peer: TypeAlias = Any
"""An object of a peer that ships no types."""


class Line(NamedTuple):
    """One line of the table."""

    case: str
    code: str
    figures: str


def missing(module: str, name: str, case: str) -> list[Line]:
    """Return a line that says that a peer is not installed, or none if it is."""
    return [] if find_spec(module) else [Line(case, name, "not installed")]


def linear() -> list[Line]:
    """Analyse, factor and solve at both sizes."""
    pattern, blocks = stiffness()
    lines = []
    for system in (System("planar 6x6, 33 %", pattern, blocks, None), printed(6, 2.3)):
        for name, *times in compare(system):
            if name in {"SuperLU", "QDLDL, pivots read"}:
                continue
            analyse, factor, solve = (least for _, least in times)
            lines.append(
                Line(system.name, name, f"analyse {analyse:8.2f}  factor {factor:8.2f}  solve {solve:7.2f}  [ms]")
            )
        lines += missing("qdldl", "QDLDL", system.name) + missing("pypardiso", "MKL Pardiso", system.name)
    return lines


def least(call: Callable[[], object]) -> float:
    """Return the least time of a call [us]."""
    return 1e3 * milliseconds(call, longest=1.0)[1]


def contact() -> list[Line]:
    """Gradient and Hessian of contact and friction of the main job at 33 %, for each active contact."""
    rig, before = at_strain(STRAIN)
    work = rig.work
    model, contacts = work.model, work.contacts
    case = f"contact of the planar 6x6, {100.0 * STRAIN:.0f} %"
    active = int(np.count_nonzero(contacts.state.load))

    def timed(work: Workspace) -> tuple[float, float]:
        gradient = np.zeros((len(model.fixed), 4))
        work.assemble()
        return (
            least(lambda: work.contacts.add_gradient(gradient)),
            least(lambda: work.contacts.add_hessian(1.0, work.stiffness.blocks)),
        )

    smooth = Workspace(replace(model, law=model.law._replace(friction=0.0)))
    smooth.start_step(work.rods.q, work.rods.frames, Memory.empty())

    lines = [
        _per_contact(case, "knitlab, normal", active, *timed(smooth)),
        _per_contact(case, "knitlab, and friction", active, *timed(work)),
    ]
    if not find_spec("ipctk"):
        return [*lines, *missing("ipctk", "ipctk", case)]
    m = len(model.samples.weights)
    spans = model.samples.spans
    own = (spans[:, None] * m + np.arange(m)).ravel()
    strand = np.repeat(model.samples.strand[spans], m)
    spacing = float(model.samples.length[spans].mean())
    for stride, mesh in ((1, "fine edges"), (m, "knit's edges")):
        at = own[::stride]
        lines += _ipctk(
            case,
            mesh,
            work.placed.points[at],
            before[at],
            strand[::stride],
            skip=int(np.ceil(model.law.exclusion / (spacing * stride))),
            most=active,
        )
    return lines


def _per_contact(case: str, code: str, active: int, gradient: float, hessian: float) -> Line:
    return Line(
        case,
        code,
        f"{active:6d} active; a contact: gradient {gradient / active:.3f}  Hessian {hessian / active:.3f}  [us]",
    )


def _ipctk(
    case: str, name: str, points: FloatArray, before: FloatArray, strand: IndexArray, *, skip: int, most: int
) -> list[Line]:
    """Time ipctk on polygons (n, 3) of the strands that moved from `before` [r].

    Its barrier acts where the lab's contact does, up to 2.04 r between centrelines, or less far if more than `most`
    contacts were active; it is infinite at r, as the lab's is. Finding what touches is left out on both sides.
    """
    import ipctk  # noqa: PLC0415  (a peer that need not be installed)

    ipctk.set_num_threads(1)
    points, before = np.asfortranarray(points), np.asfortranarray(before)
    first = np.flatnonzero(strand[1:] == strand[:-1])
    edges = np.column_stack([first, first + 1]).astype(np.int32)
    mesh = ipctk.CollisionMesh(before, np.asfortranarray(edges))
    middle = points[edges].mean(axis=1)
    longest = float(np.linalg.norm(np.diff(points[edges], axis=1), axis=2).max())
    near = cKDTree(middle).query_pairs(2.04 + longest, output_type="ndarray")
    a, b = edges[near[:, 0], 0], edges[near[:, 1], 0]
    near = near[(strand[a] != strand[b]) | (np.abs(a - b) > skip)]
    candidates = ipctk.Candidates()
    candidates.ee_candidates = [ipctk.EdgeEdgeCandidate(int(i), int(j)) for i, j in near]
    core, reach, step = 1.0, 1.04, 0.01
    collisions = ipctk.NormalCollisions()
    collisions.build(candidates, mesh, points, reach, core)
    while len(collisions) > most or step > 1e-4:
        fits = len(collisions) <= most
        if fits and reach >= 1.04:
            break
        step *= 0.5 if fits else 1.0
        reach += step if fits else -step
        collisions.build(candidates, mesh, points, reach, core)
    barrier = ipctk.BarrierPotential(reach, 1.0)
    rubbing = ipctk.TangentialCollisions()
    rubbing.build(mesh, points, collisions, barrier, MU)
    friction = ipctk.FrictionPotential(0.02)
    moved = np.asfortranarray(points - before)
    active = len(collisions)
    normal = (
        least(lambda: barrier.gradient(collisions, mesh, points)),
        least(lambda: barrier.hessian(collisions, mesh, points)),
    )
    both = (
        normal[0] + least(lambda: friction.gradient(rubbing, mesh, moved)),
        normal[1] + least(lambda: friction.hessian(rubbing, mesh, moved)),
    )
    return [
        _per_contact(case, f"ipctk, {name}, normal", active, *normal),
        _per_contact(case, f"ipctk, {name}, and friction", active, *both),
    ]


def crossing() -> list[Line]:
    """Wall time and error of the force of friction of a rod dragged over two cylinders."""
    case = f"rod dragged {TRAVEL:g} r over two cylinders"
    lines = [
        _dragged(case, f"knitlab, {steps} step{'s' * (steps > 1)}", partial(_drag_quasistatic, steps))
        for steps in (1, 2, 4, 8, 16)
    ]
    if not find_spec("elastica"):
        return [*lines, *missing("elastica", "PyElastica", case)]
    return lines + [
        _dragged(case, f"PyElastica, {duration:.0f} r sqrt(rho / E)", partial(_drag_dynamic, duration))
        for duration in (25.0, 50.0, 100.0, 200.0, 400.0, 800.0)
    ]


def _dragged(case: str, code: str, run: Callable[[], float]) -> Line:
    error = run() / (2.0 * MU * PRESS) - 1.0
    return Line(case, code, f"error of mu N {error:+8.2%}  in {milliseconds(run, longest=3.0)[1]:9.1f} ms")


def _drag_quasistatic(steps: int) -> float:
    """Return the force along two fixed rods that drags a loaded one, found by the lab."""
    n = round(2.0 * HALF_LENGTH / EDGE) + 1
    y = np.linspace(-HALF_LENGTH, HALF_LENGTH, n)
    x = np.arange(-6.0, 6.0 + EDGE, EDGE)
    rod = np.column_stack([0.0 * y, y, 0.0 * y + 2.0 - OVERLAP])
    drums = [np.column_stack([x, np.full(x.size, at), 0.0 * x]) for at in (-HALF_SPAN, HALF_SPAN)]
    model, state = make_model(
        [rod], radius=1.0, young_modulus=1.0, poisson_ratio=POISSON_RATIO, friction=MU, wires=drums
    )
    middle = slice(n // 2 - 1, n // 2 + 2)
    model.fixed[n:] = True
    model.fixed[:n, 3] = True  # the rod slides, it must not roll
    model.fixed[middle, :2] = True
    work = Workspace(model)
    work.dead.loads[middle, 2] = -2.0 * PRESS / 3.0
    found, report = advance(work, state, state.q)
    if found is None:
        msg = f"no equilibrium under the dead load: {report}"
        raise RuntimeError(msg)
    start = found.q.copy()

    def path(share: float) -> FloatArray:
        q = start.copy()
        q[middle, 0] += TRAVEL * share
        return q

    *_, (_, last, _) = march(work, found, path, longest=1.0 / steps)
    return float(last.reaction[middle, 0].sum())


def _drag_dynamic(duration: float) -> float:
    """Return the same force found by PyElastica, in a time in units of r sqrt(density / E)."""
    import elastica as ea  # noqa: PLC0415  (a peer that need not be installed)

    n = round(2.0 * HALF_LENGTH / EDGE)
    step = 1.0  # stable up to 1.3
    felt: dict[int, float] = {}

    class Lab(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping, ea.Contact):  # type: ignore[misc]
        pass

    class Felt(ea.RodCylinderContact):  # type: ignore[misc]
        """Contact that keeps the force on its cylinder along the axis."""

        def apply_contact(self, system_one: Peer, system_two: Peer, time: float = 0.0) -> None:
            before = float(system_two.external_forces[0, 0])
            super().apply_contact(system_one, system_two, time)
            felt[id(system_two)] = float(system_two.external_forces[0, 0]) - before

    class Grip(ea.ConstraintBase):  # type: ignore[misc]
        """Move the middle nodes along x, evenly; let them rise and sink."""

        def constrain_values(self, system: Peer, time: float) -> None:
            system.position_collection[0, n // 2 - 1 : n // 2 + 2] = TRAVEL * min(time / duration, 1.0)
            system.position_collection[1, n // 2] = 0.0

        def constrain_rates(self, system: Peer, time: float) -> None:
            system.velocity_collection[0, n // 2 - 1 : n // 2 + 2] = TRAVEL / duration * (time < duration)
            system.velocity_collection[1, n // 2] = 0.0

    class Load(ea.NoForces):  # type: ignore[misc]
        def apply_forces(self, system: Peer, time: float = 0.0) -> None:  # noqa: ARG002  (its interface)
            system.external_forces[2, n // 2 - 1 : n // 2 + 2] -= 2.0 * PRESS / 3.0

    lab = Lab()
    rod = ea.CosseratRod.straight_rod(
        n,
        np.array([0.0, -HALF_LENGTH, 2.0 - OVERLAP]),
        np.array([0.0, 1.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        2.0 * HALF_LENGTH,
        1.0,
        1.0,
        youngs_modulus=1.0,
        shear_modulus=0.5 / (1.0 + POISSON_RATIO),
    )
    lab.append(rod)
    lab.constrain(rod).using(Grip)
    lab.add_forcing_to(rod).using(Load)
    # Critical for the rod's bouncing on its two contacts.
    swing = np.sqrt(2.0 * PRESS / OVERLAP / (2.0 * pi * HALF_LENGTH))
    lab.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=2.0 * swing, time_step=step)
    for at in (-HALF_SPAN, HALF_SPAN):
        drum = ea.Cylinder(
            np.array([-6.0, at, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 12.0, 1.0, 1.0
        )
        lab.append(drum)
        lab.constrain(drum).using(ea.FixedConstraint, constrained_position_idx=(0,), constrained_director_idx=(0,))
        lab.detect_contact_between(rod, drum).using(
            Felt, k=PRESS / OVERLAP, nu=0.05, velocity_damping_coefficient=10.0, friction_coefficient=MU
        )
    lab.finalize()
    stepper = ea.PositionVerlet()
    time = np.float64(0.0)
    for _ in range(round(duration / step)):
        time = stepper.step(lab, time, np.float64(step))
    return sum(felt.values())


def main() -> None:
    """Print the table."""
    last = ""
    for case, code, figures in [*linear(), *contact(), *crossing()]:
        if case != last:
            print(case)
            last = case
        print(f"  {code:34s} {figures}")


if __name__ == "__main__":
    main()

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.coupling import load_coupling
from knitlab_core.equilibrium.hook_friction import DRAG, TIE, Hooks, HookTerm, PoleMemory, pole_forces
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.pattern import multiply
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.frames import follow

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

LIMIT = 0.02
# Node 1 is a pin pulled along x that slides along y; nodes 3 to 5 are a wire pulled along y that slides along x.
HOOKS = Hooks(
    nodes=np.array([1, 3, 4, 5]),
    hook=np.array([0, 1, 1, 1]),
    pull=np.array([0, 1]),
    pole=np.array([1, 0]),
    slider=np.array([1, 4]),
    friction=np.array([0.3, 0.1]),
    tied=np.array([4, 5]),
    apart=np.array([0.0, 0.0]),
)
PULLS = np.zeros((6, 4))
PULLS[1, 0], PULLS[3:, 1] = -0.2, [0.1, 0.2, 0.1]


def poles_at(slid: tuple[float, float], memory: PoleMemory | None = None) -> HookTerm:
    """Return poles whose hooks slid so far, pulled by PULLS."""
    poles, q = HookTerm(HOOKS, LIMIT), np.zeros((6, 4))
    poles.start(q, memory)
    q[1, 1], q[3:, 0] = slid
    poles.place(q)
    poles.lag()
    poles.add_gradient(PULLS.copy())
    return poles


def forces(poles: HookTerm) -> FloatArray:
    """Return what the poles add to forces."""
    gradient = PULLS.copy()
    poles.add_gradient(gradient)
    return gradient - PULLS


@pytest.mark.parametrize("slid", [(0.005, -0.01), (0.3, -0.01), (-0.4, 0.5)])
def test_forces_are_the_slope_of_the_energy(slid: tuple[float, float]) -> None:
    poles = poles_at(slid)
    rng = np.random.default_rng(0)
    base = np.zeros((6, 4))
    base[1, 1], base[3:, 0] = slid[0], slid[1] + 1e-3 * np.arange(3)
    way, h = rng.standard_normal((6, 4)), 1e-6
    energies = []
    for sign in (-1.0, 1.0):
        poles.place(base + sign * h * way)
        energies.append(poles.energy())
    poles.place(base)
    assert (energies[1] - energies[0]) / (2 * h) == pytest.approx(float(np.vdot(forces(poles), way)), rel=1e-6)


@pytest.mark.parametrize(("slid", "share"), [((0.005, -0.01), (0.25, -0.5)), ((0.3, -2.0), (1.0, -1.0))])
def test_a_hook_sticks_up_to_its_share_of_the_pull_and_then_slides(
    slid: tuple[float, float], share: tuple[float, float]
) -> None:
    found = forces(poles_at(slid))
    assert found[1, 1] == pytest.approx(0.3 * 0.2 * share[0])
    assert found[4, 0] == pytest.approx(0.1 * 0.4 * share[1] + DRAG * slid[1])
    assert np.count_nonzero(found) == 2


def test_a_hook_that_slid_pushes_back_where_it_is_held() -> None:
    memory, work = poles_at((0.3, 0.0)).settle()
    assert memory.slip == pytest.approx([LIMIT, 0.0])
    assert pole_forces(HOOKS, memory, LIMIT) == pytest.approx([0.06, 0.0])
    # From zero to the limit, by the trapezium rule.
    assert work == pytest.approx(0.5 * 0.06 * 0.3)
    # Held there for a step it still pulls, and does no work.
    again, more = poles_at((0.0, 0.0), memory).settle()
    assert pole_forces(HOOKS, again, LIMIT) == pytest.approx([0.06, 0.0])
    assert more == 0.0


def test_a_wire_is_tied_along_its_pole() -> None:
    poles, q = HookTerm(HOOKS, LIMIT), np.zeros((6, 4))
    poles.start(q, None)
    q[4, 0] = 1e-3
    poles.place(q)
    gradient = np.zeros((6, 4))
    poles.add_gradient(gradient)
    assert gradient[[3, 5], 0] == pytest.approx(-TIE * 1e-3)
    assert gradient[4, 0] == pytest.approx(2 * TIE * 1e-3, rel=1e-6)
    assert poles.energy() == pytest.approx(TIE * 1e-6, rel=1e-6)


def test_a_wire_counts_as_one_fixture() -> None:
    held = np.zeros((6, 3), dtype=np.bool_)
    held[1, [0, 2]] = held[3:, 1:] = held[0] = True
    sizes = HookTerm(HOOKS, LIMIT).fixture_forces(PULLS, held)
    assert sorted(sizes[sizes > 0.0]) == pytest.approx([0.2, 0.4])
    # Three of the clamped node, two of the pin, two of the wire.
    assert sizes.size == 7


def test_stiffness_and_coupling_are_the_slope_of_the_forces() -> None:
    rod = np.column_stack([2.0 * np.arange(6), np.zeros(6), np.zeros(6)])
    wire = np.column_stack([np.full(5, 6.0), np.full(5, 1.97), 2.0 * np.arange(-2, 3)])
    model, state = make_model([rod], radius=1.0, young_modulus=1.0, poisson_ratio=0.37, friction=0.0, wires=[wire])
    nodes = np.arange(6, 11)
    model.fixed[nodes] = True
    model.fixed[nodes, 0] = False
    hooks = Hooks(
        nodes=nodes,
        hook=np.zeros(5, dtype=np.int64),
        pull=np.array([1]),
        pole=np.array([0]),
        slider=np.array([8]),
        friction=np.array([0.3]),
        tied=nodes[1:],
        apart=np.zeros(4),
    )
    work = Workspace(replace(model, hooks=hooks))
    q = state.q.copy()
    q[nodes, 0] += 0.5
    work.start_step(state.q, state.frames, state.memory)
    work.move_to(q, state.frames)

    def force(at: FloatArray) -> FloatArray:
        frames = state.frames.copy()
        follow(at, model.rods.has_edge, state.frames, frames)
        work.move_to(at, frames)
        work.lag()
        return work.gradient()

    force(q)
    work.assemble()
    way = np.zeros_like(q)
    way[2:4, 1], way[nodes, 0] = 1.0, 0.5
    out = np.zeros_like(q)
    multiply(work.stiffness.pattern, work.stiffness.blocks, way, out)
    slope = out + load_coupling(work, way)
    h = 1e-6
    expected = (force(q + h * way) - force(q - h * way)) / (2 * h)
    free = ~model.fixed
    free[:, 3] = False
    assert slope[free] == pytest.approx(expected[free], rel=1e-4, abs=1e-6)
    assert abs(expected[8, 0]) > 0.0

"""Tangential force of sliding strands: none without friction, Coulomb's with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import EDGE, EFFECTIVE_MODULUS, hertz, straight, touch, unit_model

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State

COULOMB = "Coulomb 1785; physics.md, section 6"
MU = 0.3
BLOCK = 12.0
"""Length of the block [r]."""


@pytest.mark.parametrize("degrees", [90, 60, 30])
def test_ripple_of_a_rod_dragged_across_ten_segments(bar: Callable[..., None], degrees: float) -> None:
    angle = np.radians(degrees)
    lower = straight((0, 0, 0), (1, 0, 0), 64.0)
    worst = 0.0
    for share in (0.02, 0.04, 0.08):
        upper = straight((-5 * EDGE, 0, 2.0 * (1.0 - share)), (np.cos(angle), np.sin(angle), 0), 32.0)
        model, state = unit_model([lower, upper])
        # 161 places are no multiple of the sample spacing, so every phase is met.
        for travel in np.linspace(0.0, 10 * EDGE, 161):
            q = state.q.copy()
            q[len(lower) :, 0] += travel
            force = touch(model, state, q=q, skin=0.1).gradient(q)[len(lower) :, :3].sum(axis=0)
            worst = max(worst, float(np.hypot(force[0], force[1]) / abs(force[2])))
    bar(
        f"sliding ripple at {degrees} degrees, mu = 0: tangential over normal",
        figure=worst,
        limit=0.01,
        unit="1",
        source="smooth cylinders: 0",
    )


class Block:
    """A short rod pressed with a dead load onto a long clamped one along x, lying along or across it.

    Its spin is held, for a block across that may spin rolls; a wheel is one that may.
    """

    def __init__(self, *, across: bool, load: float, drive: str, wheel: bool = False) -> None:
        rod = straight((0, 0, 0), (1, 0, 0), 40.0)
        # Off the middle, so that no symmetry of the samples hides a bias.
        block = straight((0.07, 0, 2), (0, 1, 0) if across else (1, 0, 0), BLOCK)
        model, self.state = unit_model([rod, block], friction=MU)
        self.load, self.nodes, self.first = load, len(block), len(rod)
        model.fixed[: self.first] = True
        model.fixed[self.first :, 1] = True
        model.fixed[self.first : -1, 3] = not wheel
        model.fixed[self.first :, 0] = drive == "displacement"
        self.work = Workspace(model)
        self.work.dead.loads[self.first :, 2] = -load / self.nodes
        self.step()

    def step(self, dx: float = 0.0) -> State:
        """Find the next equilibrium with the block moved by `dx`, where it is held."""
        target = self.state.q.copy()
        target[self.first :, 0] += dx
        found, report = advance(self.work, self.state, target)
        if found is None:
            pytest.fail(f"no equilibrium: {report}")
        self.state = found
        return found

    def pull(self, share: float) -> bool:
        """Pull with a share of mu N; return whether the block stays within a radius of its place."""
        self.work.dead.loads[self.first :, 0] = share * MU * self.load / self.nodes
        found, _ = advance(self.work, self.state, self.state.q.copy())
        if found is None or abs(found.q[self.first, 0] - self.state.q[self.first, 0]) > 1.0:
            return False
        self.state = found
        return True

    @property
    def drag(self) -> float:
        """Force that pulls the held block, over mu N."""
        return float(self.state.reaction[self.first :, 0].sum()) / (MU * self.load)


def pressing_load(*, across: bool) -> float:
    """Return the load [E r^2] for an indentation of about 2.5 % of D."""
    return hertz(0.05) if across else 0.79 * EFFECTIVE_MODULUS * 0.05 * (BLOCK - EDGE)


@pytest.mark.parametrize("across", [False, True], ids=["along", "across"])
def test_block_slides_at_mu_n(bar: Callable[..., None], across: bool) -> None:  # noqa: FBT001 a parameter of pytest
    block = Block(across=across, load=pressing_load(across=across), drive="displacement")
    drag: list[float] = []
    for _ in range(60):
        block.step(0.06)
        drag.append(block.drag)
    # Slip has developed after 0.3 r; what follows covers more than a whole edge.
    worst = max((d - 1.0 for d in drag[5:]), key=abs)
    bar(
        f"Coulomb, block {'across' if across else 'along'}: sliding force against mu N, worst place",
        figure=worst,
        limit=0.01,
        unit="1",
        source=COULOMB,
    )
    assert block.state.reaction[: block.first, 0].sum() == pytest.approx(-block.drag * MU * block.load, rel=1e-6)


@pytest.mark.parametrize("across", [False, True], ids=["along", "across"])
def test_block_sticks_below_mu_n(bar: Callable[..., None], across: bool) -> None:  # noqa: FBT001 a parameter of pytest
    block = Block(across=across, load=pressing_load(across=across), drive="load")
    held = 0.0
    for share in (0.2, 0.4, 0.6, 0.8, *np.arange(0.9, 1.05, 0.0025)):
        if not block.pull(share):
            break
        held = share
    bar(
        f"Coulomb, block {'across' if across else 'along'}: largest load that sticks against mu N",
        figure=held - 1.0,
        limit=0.01,
        unit="1",
        source=COULOMB,
    )


def test_block_that_may_spin_rolls(bar: Callable[..., None]) -> None:
    wheel = Block(across=True, load=pressing_load(across=True), drive="displacement", wheel=True)
    start = wheel.state.q[wheel.first :].copy()
    drag = []
    for _ in range(50):
        wheel.step(0.06)
        drag.append(wheel.drag)
    turn = (wheel.state.q[wheel.first : -1, 3] - start[:-1, 3]).mean()
    # The rolling radius is that of the surface within the indentation, 2.5 % of D.
    bar("rod across that may spin: turn against travel over r", turn / 3.0 - 1.0, 0.025, "1", "rolling")
    bar("rod across that may spin: rolling force over mu N", np.abs(drag).max(), 0.01, "1", "rolling")


def places(block: Block) -> FloatArray:
    """Return where the block's nodes are, and what friction remembers."""
    return np.concatenate([block.state.q[block.first :].ravel(), block.state.memory.slip.ravel()])


def test_stuck_block_carries_its_load_without_drift() -> None:
    block = Block(across=True, load=pressing_load(across=True), drive="load")
    for share in (0.3, 0.6, 0.9):
        assert block.pull(share)
    before = places(block)
    for _ in range(50):
        block.step()
    np.testing.assert_allclose(places(block), before, rtol=0.0, atol=1e-12)


def test_stuck_block_keeps_its_force_when_held() -> None:
    block = Block(across=True, load=pressing_load(across=True), drive="displacement")
    for _ in range(3):
        block.step(0.2 * block.work.model.law.slip)
    before = block.drag
    assert 0.3 < before < 0.9
    for _ in range(50):
        block.step()
    assert block.drag == pytest.approx(before, rel=1e-12)

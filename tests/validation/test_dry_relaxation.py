"""A yarn that is straight at rest, knitted in: elastica in closed form, and states that forget how they were found.

Elastica, ends on hinges (Love 1927, art. 263; Timoshenko & Gere 1961, section 2.7): with modulus k = sin(α/2), α the
slope at the ends, they are 2 E/K - 1 of the length L apart, the middle stands off by k/K L and the thrust is
4 K² EI/L².
"""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.dry_relaxation import STEPS, knit_in
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.strands import SAMPLE_SPACING
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import clasp_numbers
from tests.validation.bare_rod import EI, bare_rod
from tests.validation.cotton import Relaxed, apart, lay, relax

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State

LOVE = "Love 1927, art. 263"
TIGHT = Options(tolerance=1e-7, max_iterations=300)
EDGES = 100
LENGTH = 400.0
ALPHA = 1.5


def _laid(bump: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> NDArray[np.float64]:
    """Lay a yarn of the elastica's length in the x-y plane, its slope along it given up to a factor.

    Ends are as far apart as the elastica's, on the x axis.
    """
    m = np.sin(ALPHA / 2.0) ** 2
    chord = 2.0 * ellipe(m) / ellipk(m) - 1.0
    s = (np.arange(EDGES) + 0.5) / EDGES
    low, high = 0.0, 4.0
    for _ in range(60):
        size = 0.5 * (low + high)
        t = np.exp(1j * size * bump(s))
        low, high = (size, high) if abs(t.mean()) > chord else (low, size)
    z = LENGTH / EDGES * np.concatenate([[0.0], np.cumsum(t)]) * np.exp(-1j * np.angle(t.mean()))
    return np.column_stack([z.real, z.imag, np.zeros(EDGES + 1)])


PRINTED = {
    "arc": lambda s: 1.0 - 2.0 * s,
    "skew": lambda s: 1.0 - 3.0 * s**4,
    "wavy": lambda s: 1.0 - 2.0 * s + 0.6 * np.sin(14.0 * s + 0.5),
}


def _hinged(name: str) -> State:
    work, state = bare_rod(_laid(PRINTED[name]), straight=True)
    work.model.fixed[[0, -1], :2] = True
    work.model.fixed[:, 2] = True
    *_, (_, state, _) = knit_in(work, state, options=TIGHT)
    return state


@pytest.mark.parametrize("name", PRINTED)
def test_hinged_yarn_is_the_elastica_however_it_was_laid(bar: Callable[..., None], name: str) -> None:
    state = _hinged(name)
    m = np.sin(ALPHA / 2.0) ** 2
    k, big_k = np.sqrt(m), ellipk(m)
    deflection = np.abs(state.q[EDGES // 2, 1]) / LENGTH
    thrust = state.reaction[0, 0] * LENGTH**2 / EI
    bar(f"elastica laid as {name}: height of the middle", deflection / (k / big_k) - 1.0, 0.005, "1", LOVE)
    bar(f"elastica laid as {name}: thrust", thrust / (4.0 * big_k**2) - 1.0, 0.005, "1", LOVE)


@cache
def _relaxed(stitch: str, nodes: int = 48, steps: int = STEPS, spacing: float = SAMPLE_SPACING) -> Relaxed:
    return relax(lay(stitch, 3, nodes_per_loop=nodes, sample_spacing=spacing), steps=steps)


FINER = {
    "96 nodes per loop": partial(_relaxed, nodes=96),
    "half the spacing of samples": partial(_relaxed, spacing=0.5 * SAMPLE_SPACING),
    "twice the steps": partial(_relaxed, steps=2 * STEPS),
    "four times the steps": partial(_relaxed, steps=4 * STEPS),
}
STEADY = ("energy", "largest curvature")


def _judge(bar: Callable[..., None], stitch: str, finer: str, *, steady: bool) -> None:
    for what, off in apart(_relaxed(stitch), FINER[finer](stitch)).items():
        if (what in STEADY) == steady:
            bar(f"{stitch} 3x3 knitted in, against {finer}: {what}", off, 0.02, "1", "issue 3, line 3")


@pytest.mark.slow
@pytest.mark.parametrize("finer", FINER)
@pytest.mark.parametrize("stitch", ["plain-knit", "stockinette-default"])
def test_energy_and_bend_are_those_found_more_finely(bar: Callable[..., None], stitch: str, finer: str) -> None:
    _judge(bar, stitch, finer, steady=True)


@pytest.mark.slow
@pytest.mark.parametrize("finer", FINER)
@pytest.mark.parametrize("stitch", ["plain-knit", "stockinette-default"])
def test_shape_and_forces_are_those_found_more_finely(bar: Callable[..., None], stitch: str, finer: str) -> None:
    _judge(bar, stitch, finer, steady=False)


def test_a_coarse_knit_comes_to_the_same_state_in_twice_the_steps(bar: Callable[..., None]) -> None:
    """With steps of one length and snaps passed in moves of any it came to another, 65 % more bent."""
    few, many = (relax(lay("plain-knit", 2, nodes_per_loop=24), steps=steps) for steps in (STEPS, 2 * STEPS))
    for what, off in apart(few, many).items():
        bar(f"plain-knit 2x2 knitted in, against twice the steps: {what}", off, 0.02, "1", "issue 3, line 3")


@pytest.mark.slow
def test_a_knit_of_36_loops_relaxes_and_its_loops_hold_each_other() -> None:
    laid = lay("stockinette-default", 6)
    *_, (_, state, _) = knit_in(Workspace(laid.model), laid.state)
    held = np.abs(clasp_numbers(laid.specimen, state.q[:, :3]))
    # Two for each of six loops in each pair of rows; turn-arounds of the course edges may let go.
    assert held.shape == (5, 6, 2)
    assert held[:, 1:-1].all()
    assert held.sum() >= 57


def test_hardly_anything_moves_when_the_test_begins(bar: Callable[..., None]) -> None:
    """A contact that slides forgets a little when strands turn; that must be over."""
    laid, before = lay("plain-knit", 3), _relaxed("plain-knit").state
    after, _ = advance(Workspace(laid.model), before, before.q)
    assert after is not None
    assert len(before.memory.load) > 500
    jump = np.tensordot(laid.ways, after.reaction - before.reaction, 2) / _relaxed("plain-knit").felt
    moved = float(np.linalg.norm(after.q[:, :3] - before.q[:, :3], axis=1).max())
    bar("cotton 3x3 stands still: jump of the carriages' forces", np.abs(jump).max(), 0.01, "1", "issue 3, line 3")
    bar("cotton 3x3 stands still: largest motion, in loop widths", moved / 20.0, 0.01, "1", "issue 3, line 3")


def test_work_of_a_test_is_stored_or_rubbed_away_from_the_relaxed_state_on(bar: Callable[..., None]) -> None:
    laid, state = lay("plain-knit", 3), _relaxed("plain-knit").state
    assert (state.external_work, state.friction_work) == (0.0, 0.0)
    pulled = 6.0 * laid.ways[0] + 3.0 * laid.ways[1]
    *_, (_, end, _) = march(Workspace(laid.model), state, lambda s: state.q + s * pulled, longest=1 / 24)
    stored = float(end.energies.sum() - state.energies.sum())
    balance = (end.external_work - stored - end.friction_work) / (abs(stored) + end.friction_work)
    bar("cotton 3x3 pulled from its relaxed state: energy balance", balance, 0.01, "1", "physics.md §5")


@pytest.mark.slow
def test_friction_is_what_holds_a_straight_yarn_in_its_loops() -> None:
    kept = []
    for friction in (0.3, 0.0):
        laid = lay("plain-knit", 3, friction=friction)
        *_, (_, state, _) = knit_in(Workspace(laid.model), laid.state)
        kept.append(int(np.abs(clasp_numbers(laid.specimen, state.q[:, :3])).sum()))
    # Of twelve.
    assert kept[0] == 12
    assert kept[1] <= 6

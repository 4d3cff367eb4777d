"""Friction in a whole knit: it holds, it loses the same work however it is stepped, and none without friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.contact.friction import Memory
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.workspace import Workspace
from tests.validation.knit import Knit, loop_area, make_knit, pull

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State

SOURCE = "physics.md §6"
HOLD = 1e-3
SIZES = [3, pytest.param(6, marks=pytest.mark.slow)]


def _drift(knit: Knit, state: State, strain: float, *, forget: bool = False) -> float:
    """Hold a knit for 50 steps; return the largest change of force, relative to the first."""
    work, force = Workspace(knit.model), [knit.force(state)]
    for _ in range(50):
        if forget:
            state = replace(state, memory=Memory.empty())
        found, _ = advance(work, state, knit.target(strain))
        assert found is not None
        state = found
        force.append(knit.force(state))
    return float(np.abs(np.array(force) / force[0] - 1.0).max())


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("strains", [(0.3,), (0.3, 0.25)], ids=["pulled", "let back"])
def test_forces_do_not_drift_while_a_knit_is_held(
    bar: Callable[..., None], size: int, strains: tuple[float, ...]
) -> None:
    knit = make_knit(size)
    _, state = pull(knit, strains, steps=20)
    drift = _drift(knit, state, strains[-1])
    bar(f"hold, {size}x{size}, 50 steps at {strains[-1]:.0%}", drift, HOLD, "1", SOURCE)


def test_forces_would_drift_without_memory() -> None:
    knit = make_knit(2)
    _, state = pull(knit, [0.3, 0.25], steps=20)
    assert _drift(knit, state, 0.25, forget=True) > 10.0 * HOLD


@pytest.mark.parametrize(
    ("size", "steps"),
    # 32 steps are the default of a protocol, 1.25 % of strain each.
    [(3, 20), pytest.param(6, 32, marks=pytest.mark.slow), pytest.param(6, 40, marks=pytest.mark.slow)],
)
def test_loop_area_does_not_depend_on_the_step_count(bar: Callable[..., None], size: int, steps: int) -> None:
    area = []
    for count in (steps, 4 * steps):
        knit = make_knit(size)
        area.append(loop_area(knit, pull(knit, [0.4, 0.0], steps=count)[0]))
    name = f"loop area, {size}x{size}, {steps} against {4 * steps} steps up and as many down"
    bar(name, area[0] / area[1] - 1.0, 0.03, "1", SOURCE)


@pytest.mark.parametrize("size", SIZES)
def test_no_work_is_lost_without_friction(bar: Callable[..., None], size: int) -> None:
    knit = make_knit(size, friction=0.0)
    rows, _ = pull(knit, [0.4, 0.0], steps=20)
    share = loop_area(knit, rows) / max(row.external_work for row in rows)
    # Forces are balanced to 1e-4, so the work of a path that returns may differ by as much.
    bar(f"loop area over work, {size}x{size}, mu = 0", share, 1e-4, "1", SOURCE + ", solver tolerance")


@pytest.mark.parametrize("size", SIZES)
def test_energy_is_accounted_for(bar: Callable[..., None], size: int) -> None:
    rows, _ = pull(make_knit(size), [0.4, 0.0], steps=40)
    most = max(row.external_work for row in rows)
    gap = max(abs(row.external_work - row.energy - row.friction_work) for row in rows) / most
    bar(f"energy balance, {size}x{size}, worst of a cycle over the largest work", gap, 0.01, "1", SOURCE)
    end = rows[-1]
    lost = (end.external_work - end.energy) / end.friction_work - 1.0
    bar(f"energy balance, {size}x{size}, work lost over a cycle against friction's", lost, 0.01, "1", SOURCE)

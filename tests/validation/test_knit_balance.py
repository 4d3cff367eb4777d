"""Action and reaction, and motion of a whole knit with its fixtures, which nothing may feel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import clasp_numbers
from tests.validation.knit import FloatArray, Knit, make_knit, pull

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State

TIGHT = Options(tolerance=1e-8)
SOURCE = "physics.md §6"
FRICTIONS = [0.0, 0.3]


def _clamped(friction: float, strain: float) -> tuple[Knit, State]:
    """Pull a knit, then clamp the pins' nodes where they stand."""
    knit = make_knit(2, friction=friction)
    _, state = pull(knit, [strain] if strain else [], steps=20, options=TIGHT)
    knit.model.fixed[knit.held(), :3] = True
    found, _ = advance(Workspace(knit.model), state, state.q, TIGHT)
    assert found is not None
    return knit, found


def _turn(q: FloatArray, turn: Rotation, shift: FloatArray) -> FloatArray:
    moved = q.copy()
    moved[:, :3] = turn.apply(q[:, :3]) + shift
    return moved


def _carry(knit: Knit, state: State, rotation: FloatArray, shift: FloatArray) -> FloatArray:
    """Carry all fixtures along in twenty steps; return the reactions (N, 3), turned back."""
    begin = state.q

    def path(s: float) -> FloatArray:
        return _turn(begin, Rotation.from_rotvec(s * rotation), s * shift)

    *_, (_, end, _) = march(Workspace(knit.model), state, path, longest=0.05, options=TIGHT)
    back: FloatArray = Rotation.from_rotvec(rotation).inv().apply(end.reaction[:, :3])
    return back


def _change(knit: Knit, state: State, rotation: tuple[float, ...], shift: tuple[float, ...]) -> float:
    before = state.reaction[:, :3]
    return float(np.abs(_carry(knit, state, np.array(rotation), np.array(shift)) - before).max() / np.abs(before).max())


@pytest.mark.parametrize("friction", FRICTIONS)
def test_moving_a_loaded_knit_changes_no_force(bar: Callable[..., None], friction: float) -> None:
    change = _change(*_clamped(friction, 0.2), (0.0, 0.0, 0.0), (30.0, -20.0, 50.0))
    bar(f"loaded knit moved: change of force, mu = {friction}", change, 1e-6, "1", SOURCE)


@pytest.mark.parametrize("friction", FRICTIONS)
def test_turning_a_loaded_knit_changes_no_force(bar: Callable[..., None], friction: float) -> None:
    change = _change(*_clamped(friction, 0.2), (0.2, 0.3, 0.4), (4.0, 2.0, 1.0))
    bar(f"loaded knit turned by 0.54 rad: change of force, mu = {friction}", change, 1e-6, "1", SOURCE)


def test_turning_an_unloaded_knit_makes_no_force(bar: Callable[..., None]) -> None:
    knit, state = _clamped(0.3, 0.0)
    force = _carry(knit, state, np.array([0.2, 0.3, 0.4]), np.array([4.0, 2.0, 1.0]))
    bar("unloaded knit turned by 0.54 rad: largest force", np.abs(force).max(), 1e-9, "E r^2", SOURCE)


@pytest.mark.parametrize("friction", FRICTIONS)
def test_forces_on_all_fixtures_and_loads_sum_to_zero(bar: Callable[..., None], friction: float) -> None:
    knit = make_knit(2, friction=friction)
    _, pulled = pull(knit, [0.3], steps=20)
    work = Workspace(knit.model)
    free = np.setdiff1d(np.arange(len(pulled.q)), knit.held())
    work.dead.loads[free[::7], 0] = 1e-4
    state, _ = advance(work, pulled, pulled.q)
    assert state is not None
    rest = (state.reaction + work.dead.loads)[:, :3].sum(axis=0)
    share = np.abs(rest).max() / np.abs(state.reaction[:, :3]).sum()
    bar(f"action = reaction: forces, mu = {friction}", share, 1e-4, "1", SOURCE + ", solver tolerance")


@pytest.mark.parametrize("friction", FRICTIONS)
def test_moments_on_all_fixtures_sum_to_zero(bar: Callable[..., None], friction: float) -> None:
    knit = make_knit(2, friction=friction)
    _, state = pull(knit, [0.3], steps=20)
    force = state.reaction[:, :3]
    moments = np.cross(state.q[:, :3], force)
    share = np.abs(moments.sum(axis=0)).max() / np.abs(moments).sum()
    bar(f"action = reaction: moments, mu = {friction}", share, 1e-4, "1", SOURCE + ", solver tolerance")


@pytest.mark.parametrize("size", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_loops_stay_knitted(size: int) -> None:
    knit = make_knit(size)
    before = clasp_numbers(knit.specimen, knit.start.q[:, :3])
    assert np.abs(before).min() == 1
    for strains in ([0.4], [0.4, 0.0]):
        _, state = pull(knit, strains, steps=20)
        np.testing.assert_array_equal(clasp_numbers(knit.specimen, state.q[:, :3]), before)

"""Contact forces: none without touch, equal and opposite, infinite energy in the core."""

from __future__ import annotations

import numpy as np
import pytest

from tests.contact_scenes import straight, touch, unit_model

MU = 0.3
LOWER = straight((0, 0, 0), (1, 0, 0), 12.0)


def crossed_at(height: float, friction: float = 0.0) -> tuple[np.ndarray, float, int]:
    """Return the gradient, energy and contacts of two rods crossed at a height."""
    model, state = unit_model([LOWER, straight((0.1, 0.2, height), (0.3, 1, 0), 12.0)], friction=friction)
    scene = touch(model, state)
    return scene.gradient(state.q), scene.energy(state.q), scene.lag(state.q)


def test_no_force_beyond_reach() -> None:
    gradient, energy, contacts = crossed_at(2.0401)
    assert not gradient.any()
    assert energy == 0.0
    assert contacts == 0


@pytest.mark.parametrize("height", [2.039, 2.02, 2.0, 1.96, 1.8, 1.2])
def test_contact_only_pushes(height: float) -> None:
    gradient, energy, contacts = crossed_at(height)
    assert energy > 0.0
    assert contacts > 0
    assert gradient[:7, 2].sum() > 0.0 > gradient[7:, 2].sum()


def test_action_is_reaction() -> None:
    gradient, _, _ = crossed_at(1.9)
    np.testing.assert_allclose(gradient.sum(axis=0), 0.0, atol=1e-14)


def test_core_has_infinite_energy() -> None:
    model, state = unit_model([LOWER, straight((0, 0, 1.8), (0, 1, 0), 12.0)])
    scene = touch(model, state)
    sunk = state.q.copy()
    sunk[7:, 2] -= 0.9
    assert scene.energies(sunk)[0] == np.inf


@pytest.mark.parametrize("way", [0.01, 0.2])
def test_friction_pulls_back_by_at_most_mu_n(way: float) -> None:
    model, state = unit_model([LOWER, straight((0.1, 0, 1.92), (0, 1, 0), 12.0)], friction=MU)
    scene = touch(model, state)
    q = state.q.copy()
    q[7:, 0] += way
    load = scene.pairs.load.sum()
    normal = -touch(model, state, q=q).gradient(q)[7:].sum(axis=0)
    drag = scene.gradient(q)[7:].sum(axis=0)[0] + normal[0]
    assert drag == pytest.approx(MU * load * min(1.0, way / model.law.slip), rel=0.03)
    assert drag <= MU * load


def test_unloaded_pair_has_no_friction() -> None:
    model, state = unit_model([LOWER, straight((0.1, 0, 2.1), (0, 1, 0), 12.0)], friction=MU)
    scene = touch(model, state)
    q = state.q.copy()
    q[7:, 0] += 0.2
    assert not scene.gradient(q).any()

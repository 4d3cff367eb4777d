"""Slip between surfaces: none where strands turn together or roll, the way where one slides, and its slope."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from knitlab_core.contact.slip import add_slip_slope, opened
from knitlab_core.rods.vectors import row
from tests.contact_scenes import Touch, straight, touch, unit_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray
    from knitlab_core.rods.vectors import Vector

HEIGHT: Final = 1.9
"""Distance of the two centrelines [r]."""

UPPER: Final = slice(7, 14)
SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-1.5, 1.5)
ALONG: Final = (1.0, 0.0, 0.0)
ACROSS: Final = (0.0, 1.0, 0.0)
SKEW: Final = (0.6, 0.8, 0.0)


def pressed(way: Sequence[float]) -> tuple[Touch, FloatArray]:
    """Return a rod along x with another pressed on it from above, and where they are."""
    strands = [straight((0, 0, 0), ALONG, 12.0), straight((0.07, 0, HEIGHT), way, 12.0)]
    model, state = unit_model(strands, friction=0.3)
    scene = touch(model, state)
    assert scene.candidates.a.size > 100
    # The upper rod is b of every pair: what opens is the lower's place less the upper's.
    assert scene.candidates.b.min() >= UPPER.start * len(model.samples.weights) > scene.candidates.a.max()
    return scene, state.q.copy()


def apart(scene: Touch) -> FloatArray:
    """Return the lines (P, 3) between the centrelines at the last equilibrium."""
    return scene.base[scene.candidates.a] - scene.base[scene.candidates.b]


def carried(scene: Touch, q: FloatArray, turn: Rotation, shift: FloatArray) -> FloatArray:
    """Return where both rods are when they turn about the origin and move as one body, material frames included."""
    moved = q.copy()
    moved[:, :3] = turn.apply(q[:, :3]) + shift
    frames = scene.follow(moved)
    for i in np.flatnonzero(scene.model.rods.has_edge):
        wanted, t, d = turn.apply(scene.base_frames[i, :, 1]), frames.tangent[i], frames.director[i]
        moved[i, 3] = np.arctan2(wanted @ np.cross(t, d), wanted @ d)
    return moved


@given(seed=SEEDS, angle=st.floats(0.0, 2.8))
@settings(deadline=None, max_examples=20)
def test_strands_that_turn_and_move_together_do_not_slip(seed: int, angle: float) -> None:
    rng = np.random.default_rng(seed)
    scene, q = pressed(SKEW)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    moved = carried(scene, q, turn, rng.uniform(-20.0, 20.0, 3))
    np.testing.assert_allclose(scene.openings(moved), 0.0, atol=1e-13)
    before = scene.gradient(q)[:, :3]
    scene.lag(moved)
    np.testing.assert_allclose(scene.gradient(moved)[:, :3], turn.apply(before), atol=1e-13)


@given(seed=SEEDS, angle=st.floats(0.0, 2.8))
@settings(deadline=None, max_examples=20)
def test_anchors_carry_the_elastic_slip_turned_along(seed: int, angle: float) -> None:
    rng = np.random.default_rng(seed)
    scene, q = pressed(SKEW)
    slip = rng.normal(0.0, 0.01, (scene.candidates.a.size, 3))
    slip -= (slip * scene.pairs.normal).sum(axis=1, keepdims=True) * scene.pairs.normal
    scene.pairs.anchor[:] -= slip
    rubbing = scene.pairs.load > 0.0
    np.testing.assert_allclose(scene.slips(q)[rubbing], slip[rubbing], atol=1e-15)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    moved = carried(scene, q, turn, rng.uniform(-20.0, 20.0, 3))
    scene.lag(moved)
    np.testing.assert_allclose(scene.slips(moved)[rubbing], turn.apply(slip)[rubbing], atol=1e-13)


@given(lower=ANGLES, upper=ANGLES, more=st.floats(-0.5, 0.5))
@settings(deadline=None, max_examples=30)
def test_parallel_rods_that_roll_on_each_other_do_not_slip(lower: float, upper: float, more: float) -> None:
    scene, q = pressed(ALONG)
    # Like wheels roll while the line between them turns by the mean of their turns; `more` is slid.
    orbit = 0.5 * (lower + upper) + more
    radial, round_about = np.array([0.0, -np.sin(orbit), np.cos(orbit)]), np.array([0.0, np.cos(orbit), np.sin(orbit)])
    q[UPPER, 1:3] = HEIGHT * radial[1:]
    q[:6, 3], q[7:13, 3] = lower, upper
    scene.lag(q)
    slid = HEIGHT * np.cos(0.5 * (lower - upper)) * np.sin(more)
    rubbing = scene.pairs.load > 0.0
    np.testing.assert_allclose((scene.slips(q) @ round_about)[rubbing], slid, atol=1e-13)
    # Nor does anything open along the rods; across them only the arcs' height, of second order.
    opening = scene.openings(q)
    np.testing.assert_allclose(opening[:, 0], 0.0, atol=1e-13)
    height = HEIGHT * (1.0 - np.cos(0.5 * (lower - upper)) * np.cos(more))
    np.testing.assert_allclose(opening @ radial, -height, atol=1e-13)


@given(angle=ANGLES)
@settings(deadline=None, max_examples=20)
def test_rod_that_rolls_along_another_opens_as_a_wheel_leaves_its_track(angle: float) -> None:
    scene, q = pressed(ACROSS)
    # Spin about y by an angle carries the middle by the angle times half the distance along x.
    q[UPPER, 0] += 0.5 * HEIGHT * angle
    q[7:13, 3] = angle
    r0 = apart(scene)
    # A point of the rim runs on a cycloid; the pair's own offset turns half along.
    x = -0.5 * HEIGHT * (angle - np.sin(angle)) + 0.5 * r0[:, 0] * (1.0 - np.cos(angle))
    z = -0.5 * HEIGHT * (1.0 - np.cos(angle)) + 0.5 * r0[:, 0] * np.sin(angle)
    np.testing.assert_allclose(scene.openings(q), np.column_stack([x, 0.0 * x, z]), atol=1e-13)


def test_rolling_is_free_of_slip_to_third_order_and_sliding_is_not() -> None:
    scene, q = pressed(ACROSS)
    above = int(np.argmin(np.hypot(*apart(scene)[:, :2].T)))
    angle = 0.05
    q[UPPER, 0] += 0.5 * HEIGHT * angle
    assert abs(scene.slips(q)[above, 0]) == pytest.approx(0.5 * HEIGHT * angle, rel=0.01)
    q[7:13, 3] = angle
    # The pair that was opposite within a quarter of a sample spacing.
    assert abs(scene.slips(q)[above, 0]) < HEIGHT * angle**3


@pytest.mark.parametrize("rods", [ALONG, ACROSS, SKEW], ids=["parallel", "crossed", "skew"])
@pytest.mark.parametrize("way", [ALONG, ACROSS, SKEW], ids=["x", "y", "skew"])
def test_rod_that_slides_slips_by_its_way(rods: tuple[float, ...], way: tuple[float, ...]) -> None:
    scene, q = pressed(rods)
    q[UPPER, :3] += 0.3 * np.array(way)
    np.testing.assert_allclose(scene.openings(q), np.tile(-0.3 * np.array(way), (len(scene.pairs.load), 1)), atol=1e-14)
    slip, n = scene.slips(q), scene.pairs.normal
    rubbing = scene.pairs.load > 0.0
    expected = -0.3 * (np.array(way) - (n @ way)[:, None] * n)
    np.testing.assert_allclose(slip[rubbing], expected[rubbing], atol=1e-14)


def test_rod_that_spins_in_place_rubs_by_its_surface() -> None:
    scene, q = pressed(ACROSS)
    q[7:13, 3] = 0.2
    above = int(np.argmin(np.hypot(*apart(scene)[:, :2].T)))
    assert abs(scene.slips(q)[above, 0]) == pytest.approx(0.5 * HEIGHT * np.sin(0.2), rel=0.01)


@given(seed=SEEDS, way=st.sampled_from([ALONG, ACROSS, SKEW]))
@settings(deadline=None, max_examples=12)
def test_slope_against_differences_in_all_unknowns(seed: int, way: tuple[float, ...]) -> None:
    rng = np.random.default_rng(seed)
    scene, q = pressed(way)
    scene.pairs.anchor[:] += rng.normal(0.0, 0.05, scene.pairs.anchor.shape)
    # Bent, stretched and spun since the last equilibrium.
    q += rng.normal(0.0, 0.2, q.shape)
    frames = scene.follow(q)
    placed, w = scene.placed(q), scene.model.samples.weights
    m = len(w)
    units = np.eye(q.size).reshape(-1, *q.shape)
    for p in rng.choice(scene.candidates.a.size, 3):
        a, b = int(scene.candidates.a[p]), int(scene.candidates.b[p])
        direction, anchor = rng.normal(size=3), row(scene.pairs.anchor, p)
        slope = np.zeros_like(q)
        for sign, sample in ((1.0, a), (-1.0, b)):
            i, k = divmod(sample, m)
            add_slip_slope(tuple(direction), sign, i, k, w, placed, anchor, slope, i - 1)
        touched = {*range(a // m - 1, a // m + 2), *range(b // m - 1, b // m + 2)}
        assert set(np.flatnonzero(slope.any(axis=1))) == touched

        def along(x: FloatArray, a: int = a, b: int = b, e: FloatArray = direction, c: Vector = anchor) -> float:
            return float(np.dot(opened(a, b, m, scene.placed(x, frames), c), e))

        differences = [(along(q + 1e-5 * unit) - along(q - 1e-5 * unit)) / 2e-5 for unit in units]
        np.testing.assert_allclose(slope.ravel(), differences, rtol=0.0, atol=1e-9)

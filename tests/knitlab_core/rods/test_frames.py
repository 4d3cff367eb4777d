"""Transport of directors, reference twist and curvature."""

from __future__ import annotations

from math import atan2, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

from knitlab_core.rods.frames import (
    Frames,
    curvature_binormal,
    follow,
    initial_directors,
    material_curvature,
    material_directors,
    transport,
)
from knitlab_core.rods.rod import edges_of, make_rods

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def test_transport_is_the_smallest_rotation() -> None:
    # From x to y about z: x goes to y, y to -x, z stays.
    assert transport(X, X, Y) == pytest.approx(Y)
    assert transport(Y, X, Y) == pytest.approx((-1.0, 0.0, 0.0))
    assert transport(Z, X, Y) == pytest.approx(Z)
    assert transport((0.3, 0.4, 0.5), Z, Z) == (0.3, 0.4, 0.5)


def test_transport_round_an_octant_turns_by_its_solid_angle() -> None:
    assert transport(transport(transport(Y, X, Y), Y, Z), Z, X) == pytest.approx(Z)


def test_curvature_binormal_is_the_turning_angle_of_a_spline() -> None:
    angle = 0.3
    found = curvature_binormal(X, (cos(angle), sin(angle), 0.0))
    assert found == pytest.approx((0.0, 0.0, 3.0 * sin(angle) / (2.0 + cos(angle))))
    assert found[2] == pytest.approx(angle - angle**5 / 180.0, rel=1e-6)


def test_material_frame_turns_with_the_edge() -> None:
    half = sqrt(0.5)
    assert material_directors(X, Y, 0.0) == (Y, Z)
    m1, m2 = material_directors(X, Y, 0.25 * pi)
    assert m1 == pytest.approx((0.0, half, half))
    assert m2 == pytest.approx((0.0, -half, half))


def test_material_curvature_is_positive_about_the_second_director() -> None:
    # A bend about z, with m1 = y and m2 = z at both edges.
    assert material_curvature((0.0, 0.0, 0.2), Y, Z, Y, Z) == (0.2, 0.0)
    assert material_curvature((0.0, 0.2, 0.0), Y, Z, Y, Z) == (0.0, -0.2)


@pytest.mark.parametrize("along", [X, Y, Z])
def test_a_straight_rod_begins_with_parallel_directors(along: tuple[float, float, float]) -> None:
    x = np.outer(np.arange(4.0) * 2.0, along)
    frames = Frames.zeros(4)
    initial_directors(x, edges_of((4,)), frames.tangent, frames.director, frames.length)
    np.testing.assert_array_equal(frames.length, [2.0, 2.0, 2.0, 0.0])
    np.testing.assert_allclose(frames.tangent[:3], [along] * 3)
    np.testing.assert_allclose(frames.director[:3], [frames.director[0]] * 3)
    assert frames.director[0] @ along == 0.0


@pytest.mark.parametrize("degrees", [30.0, 60.0, 100.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_reference_twist_keeps_whole_turns(degrees: float, sign: float) -> None:
    """Lead one edge round a cone: each round adds the solid angle of its polygon to the twist."""
    angle, corners, rounds = radians(degrees), 36, 5
    q = np.zeros((3, 4))
    q[1, 2] = 1.0
    edges = edges_of((3,))

    def lead(turn: float) -> None:
        q[2, :3] = [sin(angle) * cos(turn), sin(angle) * sin(turn), 1.0 + cos(angle)]

    lead(0.0)
    _, frames = make_rods(q[:, :3], (3,), poisson_ratio=0.3)
    start = frames.reference_twist[1]
    for k in range(1, rounds * corners + 1):
        lead(sign * 2.0 * pi * k / corners)
        follow(q, edges, frames.copy(), frames)
    # Interior angle of a regular spherical polygon: twice that at the foot of its slices from the axis.
    foot = atan2(1.0, cos(angle) * tan(pi / corners))
    solid = 2.0 * pi - corners * (pi - 2.0 * foot)
    assert frames.reference_twist[1] - start == pytest.approx(sign * rounds * solid, abs=1e-11)


def test_follow_leaves_the_gap_between_rods_alone() -> None:
    x = np.array([[0.0, 0, 0], [1, 0, 0], [2, 1, 0], [9, 0, 0], [9, 1, 0], [9, 2, 1]])
    _, frames = make_rods(x, (3, 3), poisson_ratio=0.3)
    for array in frames:
        np.testing.assert_array_equal(array[2], 0.0)
        np.testing.assert_array_equal(array[5], 0.0)
    assert frames.reference_twist[3] == 0.0

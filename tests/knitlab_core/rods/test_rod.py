"""Rest shapes and stiffnesses of rods, and energies known in closed form."""

from __future__ import annotations

from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import follow
from knitlab_core.rods.rod import edges_of, make_rods, measure_strains
from knitlab_core.rods.rupture import axial_strain, cut_rods

if TYPE_CHECKING:
    from numpy.typing import NDArray

EA, EI = pi, pi / 4.0


def line(edges: int, length: float = 10.0) -> NDArray[np.float64]:
    return np.outer(np.linspace(0.0, length, edges + 1), [1.0, 0.0, 0.0])


def arc(edges: int, angle: float, radius: float = 10.0) -> NDArray[np.float64]:
    turn = np.linspace(0.0, angle, edges + 1)
    return radius * np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])


def test_edges_leave_every_node_but_the_last_of_a_rod() -> None:
    np.testing.assert_array_equal(edges_of((3, 2)), [True, True, False, True, False])


def test_stiffness_is_that_of_a_round_rod_of_unit_radius_and_modulus() -> None:
    rods, _ = make_rods(line(4), (5,), poisson_ratio=0.25)
    np.testing.assert_allclose(rods.stretch_stiffness, [EA] * 5)
    np.testing.assert_allclose(rods.bend_stiffness, [0.0, EI, EI, EI, 0.0])
    # GJ = E / 2(1 + ν) · π/2
    np.testing.assert_allclose(rods.twist_stiffness, np.array([0.0, 1, 1, 1, 0]) * pi / 5.0)


def test_inner_nodes_stand_for_half_of_both_edges() -> None:
    x = np.array([[0.0, 0, 0], [1, 0, 0], [4, 0, 0], [9, 0, 0]])
    rods, _ = make_rods(x, (4,), poisson_ratio=0.3)
    np.testing.assert_array_equal(rods.rest_length, [1.0, 3.0, 5.0, 0.0])
    np.testing.assert_allclose(rods.span, [0.0, 2.0, 4.0, 0.0])
    # The first and the last node have what is left of their edges.
    np.testing.assert_allclose(rods.stretched, [0.5, 2.0, 4.0, 2.5])
    np.testing.assert_array_equal(rods.is_inner, [False, True, True, False])


def test_a_span_is_as_long_as_the_spline_between_two_edges() -> None:
    angle, u = 0.4, (np.arange(100_000) + 0.5) / 100_000
    e, f = 1.3 * np.array([1.0, 0.0, 0.0]), 1.1 * np.array([cos(angle), sin(angle), 0.0])
    rods, _ = make_rods(np.cumsum([0.0 * e, e, f], axis=0), (3,), poisson_ratio=0.3)
    length = np.linalg.norm(np.outer(1.0 - u, e) + np.outer(u, f), axis=1).mean()
    # Simpson's rule on the spline's speed; half of both edges would be 2 % too long.
    assert rods.span[1] == pytest.approx(length, rel=1e-4)


def test_a_cut_leaves_rods_that_are_stretched_from_end_to_end() -> None:
    rods, _ = make_rods(line(8), (9,), poisson_ratio=0.3)
    assert rods.stretched.sum() == pytest.approx(10.0)
    cut = cut_rods(rods, 4)
    np.testing.assert_allclose(cut.stretched, 1.25 * np.array([0.5, 1, 1, 1, 0.5, 0.5, 1, 1, 0.5]))
    # One edge alone is a bar; a node without edges has nothing.
    stub = cut_rods(cut_rods(cut, 2), 3)
    np.testing.assert_allclose(stub.stretched, 1.25 * np.array([0.5, 1, 0.5, 0, 0, 0.5, 1, 1, 0.5]))
    np.testing.assert_array_equal(stub.stretch_stiffness == 0.0, stub.stretched == 0.0)


def test_a_straight_rod_has_the_energy_of_its_edges() -> None:
    # Bars end to end, however uneven their lengths and strains are.
    rest, now = np.array([1.0, 1.5, 2.0, 0.7, 1.0]), np.array([1.01, 1.46, 2.1, 0.7, 0.98])
    # The last edge is a rod of its own after a cut.
    rods, frames = make_rods(np.outer(np.append(0.0, np.cumsum(rest)), [1.0, 0.0, 0.0]), (6,), poisson_ratio=0.3)
    q = np.outer(np.append(0.0, np.cumsum(now)), [1.0, 0.0, 0.0, 0.0])
    follow(q, rods.has_edge, frames.copy(), frames)
    strain = now / rest - 1.0
    for rod, edges in ((rods, [0, 1, 2, 3, 4]), (cut_rods(rods, 3), [0, 1, 2, 4])):
        theory = 0.5 * EA * (rest * strain**2)[edges].sum()
        assert rod_energy(q, rod, frames) == pytest.approx((theory, 0.0, 0.0))
        gradient = np.zeros_like(q)
        rod_gradient(q, rod, frames, gradient)
        force = np.zeros(7)
        force[1:-1][edges] = EA * strain[edges]
        np.testing.assert_allclose(gradient[:, 0], force[:-1] - force[1:], atol=1e-13)
        np.testing.assert_allclose(axial_strain(q, rod, frames)[edges], strain[edges], atol=1e-15)


def test_two_rods_are_those_made_alone() -> None:
    first, second = arc(4, 1.0), line(3) + 7.0
    both, frames = make_rods(np.concatenate([first, second]), (5, 4), poisson_ratio=0.3)
    for part, x in ((slice(0, 5), first), (slice(5, 9), second)):
        alone, its_frames = make_rods(x, (len(x),), poisson_ratio=0.3)
        for together, single in zip((*both, *frames), (*alone, *its_frames), strict=True):
            np.testing.assert_array_equal(together[part], single)


@pytest.mark.parametrize("straight", [False, True])
def test_rest_shape_as_printed_or_straight(*, straight: bool) -> None:
    edges, angle, radius = 50, 2.0, 10.0
    x = arc(edges, angle, radius)
    rods, frames = make_rods(x, (edges + 1,), poisson_ratio=0.3, straight=straight)
    stretch, bend, twist = rod_energy(np.column_stack([x, np.zeros(edges + 1)]), rods, frames)
    assert stretch == pytest.approx(0.0, abs=1e-25)
    assert twist == pytest.approx(0.0, abs=1e-25)
    # Half an edge at either end does not bend.
    theory = 0.5 * EI / radius**2 * radius * angle * (edges - 1) / edges if straight else 0.0
    assert bend == pytest.approx(theory, rel=1e-3, abs=1e-25)


def test_a_printed_helix_keeps_its_torsion_only_where_asked() -> None:
    turn = np.linspace(0.0, 6.0, 61)
    x = np.column_stack([10.0 * np.cos(turn), 10.0 * np.sin(turn), 5.0 * turn])
    printed, frames = make_rods(x, (61,), poisson_ratio=0.3)
    assert np.hypot(*printed.rest_curvature[30]) == pytest.approx(
        np.hypot(10.0, 5.0) * 0.1 * 10.0 / (10.0**2 + 5.0**2), rel=1e-2
    )
    straight, _ = make_rods(x, (61,), poisson_ratio=0.3, straight=True)
    assert not straight.rest_curvature.any()
    assert not straight.rest_twist.any()
    curvature, twist = np.zeros((61, 2)), np.zeros(61)
    measure_strains(np.column_stack([x, np.zeros(61)]), printed.is_inner, frames, curvature, twist)
    np.testing.assert_array_equal(curvature, printed.rest_curvature)
    np.testing.assert_array_equal(twist, printed.rest_twist)


def test_stretching_energy_and_end_force() -> None:
    x = line(5)
    rods, frames = make_rods(x, (6,), poisson_ratio=0.3)
    q = np.column_stack([1.02 * x, np.zeros(6)])
    follow(q, rods.has_edge, frames.copy(), frames)
    assert rod_energy(q, rods, frames) == pytest.approx((0.5 * EA * 0.02**2 * 10.0, 0.0, 0.0))
    gradient = np.zeros((6, 4))
    rod_gradient(q, rods, frames, gradient)
    np.testing.assert_allclose(gradient[[0, -1], 0], [-EA * 0.02, EA * 0.02])
    np.testing.assert_allclose(gradient[1:-1], 0.0, atol=1e-14)


def test_twisting_energy_and_end_moment() -> None:
    edges, angle = 5, 9.0
    rods, frames = make_rods(line(edges), (edges + 1,), poisson_ratio=0.3)
    q = np.column_stack([line(edges), np.append(np.linspace(0.0, angle, edges), 0.0)])
    gj = EI / 1.3
    # Twist runs from the middle of the first edge to that of the last.
    length = 10.0 * (edges - 1) / edges
    assert rod_energy(q, rods, frames) == pytest.approx((0.0, 0.0, 0.5 * gj * angle**2 / length))
    gradient = np.zeros_like(q)
    rod_gradient(q, rods, frames, gradient)
    np.testing.assert_allclose(gradient[[0, edges - 1], 3], [-gj * angle / length, gj * angle / length])
    np.testing.assert_allclose(gradient[1 : edges - 1, 3], 0.0, atol=1e-14)


@pytest.mark.parametrize("roll", [0.0, 0.4, 2.5])
def test_bending_is_the_same_about_every_axis(roll: float) -> None:
    angle = 0.3
    x = np.array([[0.0, 0, 0], [1, 0, 0], [1 + cos(angle), sin(angle), 0]])
    rods, frames = make_rods(x, (3,), poisson_ratio=0.3, straight=True)
    q = np.column_stack([x, [roll, roll, 0.0]])
    # The span of the spline turns by 3 sin φ / (2 + cos φ), the angle itself up to its fifth power.
    turn, span = 3.0 * sin(angle) / (2.0 + cos(angle)), (1.0 + 2.0 * cos(0.5 * angle)) / 3.0
    assert turn == pytest.approx(angle, rel=1e-4)
    theory = 0.5 * EI * turn**2 / span
    assert rod_energy(q, rods, frames) == pytest.approx((0.0, theory, 0.0))

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.printing import fibres, require_extra
from app.printing.checks import smooth_length
from app.printing.fibres import MOST_TRIANGLES, make_fibres, ring_arcs, specimen_fibres
from app.printing.gap import mesh_gap
from app.printing.surface import bend_radii, frames, sides_for, tangents, tube_mesh
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Specimen, closest_approach, knit_specimen

if TYPE_CHECKING:
    from rigs.axes import FloatArray


@cache
def knit(loop_width: float = 8e-3) -> Specimen:
    return knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=2, loop_width=loop_width)


def helix(turns: float, radius: float, rise: float, count: int) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi * turns, count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), rise * angle], axis=-1)


@pytest.mark.parametrize("tolerance", [0.05, 0.01, 1e-4])
def test_sides_are_as_few_as_the_chord_error_allows(tolerance: float) -> None:
    sides = sides_for(1.0, tolerance)
    assert 1.0 - math.cos(math.pi / sides) <= tolerance
    assert 1.0 - math.cos(math.pi / (sides - 1)) > tolerance


def test_a_tube_never_has_fewer_than_eight_sides() -> None:
    assert sides_for(1.0, 0.5) == sides_for(1.0, 7.0) == 8


def test_a_straight_tube_is_a_prism() -> None:
    mesh = tube_mesh(np.outer([0.0, 1.0, 3.0], [2.0, 1.0, 2.0]), 0.5, 6)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 2
    assert len(mesh.faces) == 2 * 3 * 6
    assert mesh.volume == pytest.approx(0.5 * 6 * math.sin(math.pi / 3) * 0.5**2 * 9.0)


def test_two_points_make_a_tube() -> None:
    mesh = tube_mesh(np.array([[0.0, 0, 0], [0, 0, 2]]), 1.0, 4)
    assert mesh.volume == pytest.approx(2.0 * 2.0)
    assert mesh.bounds[:, 2].tolist() == [0.0, 2.0]


def test_frames_turn_against_a_helix_as_fast_as_it_winds() -> None:
    # A normal that does not turn about the curve falls behind Frenet's by the torsion, c/(a² + c²), per length.
    radius, rise, turns = 2.0, 0.7, 3.0
    points = helix(turns, radius, rise, 2001)
    along = tangents(points)
    first, second = frames(points, along)
    inward = np.stack([-points[:, 0], -points[:, 1], np.zeros(len(points))], axis=-1) / radius
    angle = np.unwrap(np.arctan2(np.sum(inward * second, axis=-1), np.sum(inward * first, axis=-1)))
    torsion = rise / (radius**2 + rise**2)
    length = 2.0 * np.pi * turns * math.hypot(radius, rise)
    assert angle[-1] - angle[0] == pytest.approx(torsion * length, rel=1e-4)
    for one, other, product in ((first, first, 1.0), (first, second, 0.0), (first, along, 0.0), (second, along, 0.0)):
        assert np.sum(one * other, axis=-1) == pytest.approx(product, abs=1e-12)


def test_rings_do_not_flip_where_the_bend_changes_sides() -> None:
    x = np.linspace(-3.0, 3.0, 301)
    points = np.stack([x, x**3 / 10.0, np.zeros_like(x)], axis=-1)
    first, _ = frames(points, tangents(points))
    assert np.sum(first[1:] * first[:-1], axis=-1).min() > 0.99


def test_bends_of_a_circle_and_of_a_line() -> None:
    assert bend_radii(helix(0.7, 3.0, 0.0, 50)) == pytest.approx(3.0)
    assert np.isinf(bend_radii(np.outer(np.arange(4.0), [1.0, 0, 0]))).all()
    assert bend_radii(np.eye(3)[:2]).size == 0


def test_smooth_length_of_an_arc_is_fourth_order() -> None:
    errors = [abs(smooth_length(helix(0.5, 1.0, 0.0, n + 1)) - np.pi) for n in (16, 32)]
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


@pytest.mark.parametrize("chord_error", [40e-6, 10e-6])
def test_the_mesh_of_a_knit_keeps_its_chord_error(chord_error: float) -> None:
    specimen = knit()
    radius, scale = specimen.radius / specimen.loop_width, specimen.loop_width
    curve = specimen.centreline
    arcs = ring_arcs(lambda s: [curve.position(s)], curve.length, radius, chord_error / scale)
    points = curve.position(arcs)
    sides = sides_for(radius, 0.5 * chord_error / scale)
    mesh = tube_mesh(points, radius, sides)
    some = mesh.faces[: -2 * sides : 7]
    shares = np.array([[1, 1, 1], [2, 1, 1], [1, 2, 1], [1, 1, 2], [0, 1, 1], [1, 0, 1], [1, 1, 0]])
    weights = shares / shares.sum(axis=1, keepdims=True)
    probes = np.einsum("ij,kjl->kil", weights, np.asarray(mesh.vertices)[some]).reshape(-1, 3)
    s = np.repeat(arcs[some // sides].mean(axis=1), len(shares))
    for _ in range(6):
        away = probes - curve.position(s)
        s = np.clip(s + np.sum(away * curve.tangent(s), axis=-1), 0.0, arcs[-1])
    depth = scale * (radius - np.linalg.norm(probes - curve.position(s), axis=-1))
    assert 0.6 * chord_error < depth.max() <= 1.02 * chord_error
    assert 0.2 * chord_error < -depth.min() <= 0.52 * chord_error


def test_a_knit_stands_on_the_tray_at_its_real_size() -> None:
    (fibre,) = specimen_fibres(knit(), 10e-6)
    assert fibre.mesh.bounds[0] == pytest.approx(0.0, abs=1e-12)
    # Loop depth and fibre diameter; the outermost corner stays within the chord error.
    assert fibre.mesh.bounds[1, 2] == pytest.approx(2 * 0.25 * 8 + 0.8, abs=0.02)
    assert fibre.points[:, 2].min() == pytest.approx(0.4, abs=0.01)
    assert fibre.mesh.is_watertight


def test_surfaces_scale_with_the_loop() -> None:
    (large,), (small,) = specimen_fibres(knit(), 10e-6), specimen_fibres(knit(50e-6), 10e-6 * 50e-6 / 8e-3)
    assert len(large.mesh.faces) == len(small.mesh.faces)
    assert np.asarray(small.mesh.vertices) * 160.0 == pytest.approx(np.asarray(large.mesh.vertices), abs=1e-9)


def test_several_fibres_keep_their_places() -> None:
    line = np.outer(np.linspace(0.0, 5.0, 6), [1.0, 0, 0])
    low, high = make_fibres([line, line + np.array([0.0, 0.0, 2.0])], 0.5, 0.01)
    assert high.points - low.points == pytest.approx(np.tile([0.0, 0.0, 2.0], (6, 1)))
    assert min(low.mesh.bounds[0, 2], high.mesh.bounds[0, 2]) == pytest.approx(0.0)


def test_rings_follow_the_fibre_that_bends_most() -> None:
    def lay(s: FloatArray) -> list[FloatArray]:
        straight = np.stack([s, 0.0 * s, 0.0 * s], axis=-1)
        coil = np.stack([s, 0.3 * np.cos(4.0 * s), 0.3 * np.sin(4.0 * s)], axis=-1)
        return [straight, coil]

    arcs = ring_arcs(lay, 10.0, 0.1, 1e-3)
    # Of a coil: the bend R w²/(1 + R² w²) and its length, sqrt(1 + R² w²) per length of yarn.
    stretch = 1.0 + (0.3 * 4.0) ** 2
    bend = 0.3 * 4.0**2 / stretch
    step = math.sqrt(4.0 * 1e-3 / (bend * (1.0 + bend * 0.1)))
    assert np.diff(arcs) == pytest.approx(step / math.sqrt(stretch), rel=0.01)
    ply = make_fibres(lay(arcs), 0.1, 1e-3)
    assert [fibre.mesh.is_watertight for fibre in ply] == [True, True]
    assert mesh_gap(ply) == pytest.approx(0.3 - 0.2, abs=3e-3)


def test_too_many_triangles_are_refused_before_they_are_made() -> None:
    specimen = knit()
    with pytest.raises(SpecificationError, match=r"surface: found '\d+ triangles', allowed at most"):
        specimen_fibres(specimen, 1e-12)
    curve = specimen.centreline
    few = ring_arcs(lambda s: [curve.position(s)], curve.length, 0.05, 1e-3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fibres, "MOST_TRIANGLES", 2 * len(few) * sides_for(0.05, 5e-4) - 1)
        with pytest.raises(SpecificationError, match="triangles"):
            ring_arcs(lambda s: [curve.position(s)], curve.length, 0.05, 1e-3)
    assert MOST_TRIANGLES == 5_000_000


@pytest.mark.parametrize(
    ("points", "radius", "sides", "field"),
    [
        (np.zeros((1, 3)), 1.0, 8, "points"),
        (np.zeros((4, 2)), 1.0, 8, "points"),
        (np.zeros((4, 3)), 1.0, 8, "points"),
        (np.array([[0.0, 0, 0], [np.nan, 0, 0]]), 1.0, 8, "points"),
        (np.eye(3)[[0, 1, 0]], 1.0, 8, "points"),
        (np.eye(3)[:2], 0.0, 8, "tube"),
        (np.eye(3)[:2], 1.0, 2, "tube"),
    ],
)
def test_what_cannot_be_swept_is_refused(points: FloatArray, radius: float, sides: int, field: str) -> None:
    with pytest.raises(SpecificationError) as raised:
        tube_mesh(points, radius, sides)
    assert raised.value.field == field


@pytest.mark.parametrize("error", [0.0, -1.0, math.inf, math.nan])
def test_a_chord_error_is_a_length(error: float) -> None:
    with pytest.raises(SpecificationError, match="chord_error"):
        specimen_fibres(knit(), error)


def test_the_extra_is_named_when_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.printing.find_spec", lambda name: None if name == "lxml" else name)
    with pytest.raises(SpecificationError, match=r"without lxml', .* pip install 'knitlab\[printing\]'"):
        require_extra()


@given(
    waves=st.lists(st.tuples(*[st.floats(-0.15, 0.15)] * 3), min_size=3, max_size=3),
    sides=st.integers(3, 12),
)
def test_any_gentle_curve_becomes_one_closed_tube_of_area_times_length(
    waves: list[tuple[float, float, float]], sides: int
) -> None:
    x = np.linspace(0.0, 6.0, 400)
    points = np.stack([x, 0 * x, 0 * x], axis=-1)
    for order, wave in enumerate(waves, start=1):
        points += np.array(wave) * np.sin(order * x)[:, None]
    mesh = tube_mesh(points, 0.05, sides)
    area = 0.5 * sides * math.sin(2.0 * math.pi / sides) * 0.05**2
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.euler_number == 2
    assert mesh.volume == pytest.approx(area * smooth_length(points), rel=2e-3)


def test_the_closest_places_of_the_yarn_are_the_specimens() -> None:
    # What the gap of the checks rests on: the specimen's clearance is the whole knit's.
    specimen = knit()
    bend = 1.0 / bend_radii(specimen.centreline.position(np.linspace(0, specimen.centreline.length, 20001))).min()
    found = closest_approach(specimen.centreline, largest_curvature=bend)
    assert (found.distance - 0.1) * specimen.loop_width == pytest.approx(specimen.clearance, rel=1e-6)

from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.arrays import FloatArray
from knitlab_core.knits import (
    NAMED_STITCHES,
    Stitch,
    VolumetricStitch,
    clasp_numbers,
    knit_specimen,
    locking_strain,
    planar_line,
    volumetric,
    yarn_per_loop,
)
from knitlab_core.knits.arclength import tightest_bend
from knitlab_core.knits.volumetric import volumetric_middle

numbers = st.floats
any_stitch = st.builds(
    Stitch,
    curvature=numbers(0.1, 3.0),
    height=numbers(0.1, 3.0),
    depth=numbers(0.02, 1.0),
    row_spacing=numbers(0.1, 3.0),
    fibre_radius=numbers(0.01, 0.4),
)
# Near the default every draw is a knit that exists.
sound_stitch = st.builds(
    Stitch,
    curvature=numbers(1.3, 1.65),
    height=numbers(0.75, 0.85),
    depth=numbers(0.22, 0.3),
    row_spacing=numbers(0.83, 0.92),
    fibre_radius=numbers(0.01, 0.05),
)
counts = st.integers(1, 4)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, rows=counts, loops=counts)
def test_the_yarn_is_c1(stitch: Stitch, rows: int, loops: int) -> None:
    pieces = planar_line(stitch, rows=rows, loops=loops).pieces
    for before, after in pairwise(pieces):
        end, start = np.array([before.length]), np.zeros(1)
        np.testing.assert_allclose(before.position(end), after.position(start), atol=1e-9)
        np.testing.assert_allclose(before.tangent(end), after.tangent(start), atol=1e-8)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, rows=counts, loops=counts)
def test_arc_length_is_arc_length(stitch: Stitch, rows: int, loops: int) -> None:
    yarn = planar_line(stitch, rows=rows, loops=loops)
    bend = max(tightest_bend(stitch)[0], 2.0 / stitch.row_spacing)
    step = 1e-3 / bend
    s = np.linspace(step, yarn.length - step, 301)
    np.testing.assert_allclose(np.linalg.norm(yarn.tangent(s), axis=-1), 1.0, rtol=1e-14)
    difference = (yarn.position(s + step) - yarn.position(s - step)) / (2.0 * step)
    np.testing.assert_allclose(difference, yarn.tangent(s), atol=2e-3)
    # A chord is shorter than its arc by (kappa s)^2 / 24 at most.
    lengths = np.linalg.norm(difference, axis=-1)
    assert np.all(lengths <= 1.0 + 1e-8)
    assert np.all(lengths >= 1.0 - (2e-3) ** 2 / 24.0 - 1e-8)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, loops=counts, fraction=numbers(0.01, 0.99))
def test_curvature_is_the_tangent_s_derivative(stitch: Stitch, loops: int, fraction: float) -> None:
    yarn = planar_line(stitch, rows=1, loops=loops)
    bend = tightest_bend(stitch)[0]
    step = 1e-4 / bend
    s = np.array([fraction * yarn.length])
    difference = (yarn.tangent(s + step) - yarn.tangent(s - step)) / (2.0 * step)
    np.testing.assert_allclose(difference, yarn.curvature(s), atol=1e-3 * bend)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, rows=counts, loops=counts)
def test_rows_are_one_row_lifted(stitch: Stitch, rows: int, loops: int) -> None:
    yarn = planar_line(stitch, rows=rows, loops=loops)
    first = yarn.pieces[0]
    s = np.linspace(0.0, first.length, 57)
    for row in range(rows):
        along = s if row % 2 == 0 else first.length - s
        lifted = first.position(s) + np.array([0.0, row * stitch.row_spacing, 0.0])
        np.testing.assert_allclose(yarn.pieces[2 * row].position(along), lifted, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, rows=counts, loops=counts)
def test_sites_mirror_about_the_knit_s_middle(stitch: Stitch, rows: int, loops: int) -> None:
    yarn = planar_line(stitch, rows=rows, loops=loops)
    middle = np.array([0.5 * (loops - 1), 0.5 * (rows - 1) * stitch.row_spacing])

    def at(edge: str) -> FloatArray:
        arcs = np.array([site.arc_length for site in yarn.sites if site.set == edge])
        in_plane: FloatArray = yarn.position(arcs)[:, :2] - middle
        return in_plane

    for edge in ("wale+", "wale-"):
        np.testing.assert_allclose(at(edge)[::-1], at(edge) * [-1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(at("course+"), at("course-") * [-1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(at("wale+")[:, 1], -at("wale-")[:, 1], atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(stitch=sound_stitch, rows=st.integers(1, 4), loops=counts, nodes_per_loop=st.integers(24, 96))
def test_meshes_have_every_site_and_edges_near_the_nominal(
    stitch: Stitch, rows: int, loops: int, nodes_per_loop: int
) -> None:
    knit = knit_specimen(stitch, rows=rows, loops=loops, loop_width=1.0, nodes_per_loop=nodes_per_loop)
    on_yarn = {edge: [s.arc_length for s in knit.centreline.sites if s.set == edge] for edge in knit.sites}
    for edge, arcs in on_yarn.items():
        np.testing.assert_allclose(knit.arc_lengths[knit.sites[edge]], arcs, rtol=1e-12)
    nominal = yarn_per_loop(stitch) / nodes_per_loop
    edges = np.diff(knit.arc_lengths)
    shortest = np.diff(sorted(arc for arcs in on_yarn.values() for arc in arcs)).min()
    # A stretch of n edges is off by half an edge in n at the most.
    assert np.all(np.abs(edges / nominal - 1.0) <= 0.75 / max(np.floor(shortest / nominal), 1.0))
    assert np.all(np.abs(clasp_numbers(knit, knit.nodes)) == 1)


@settings(max_examples=15, deadline=None)
@given(stitch=sound_stitch, power=st.integers(-20, 20))
def test_the_loop_width_scales_everything_exactly(stitch: Stitch, power: int) -> None:
    unit = knit_specimen(stitch, rows=2, loops=2, loop_width=1.0)
    scaled = knit_specimen(stitch, rows=2, loops=2, loop_width=2.0**power)
    assert np.array_equal(scaled.nodes, unit.nodes * 2.0**power)
    assert scaled.clearance == unit.clearance * 2.0**power
    assert scaled.radius == unit.radius * 2.0**power
    assert all(np.array_equal(scaled.sites[edge], unit.sites[edge]) for edge in unit.sites)


@settings(max_examples=40, deadline=None)
@given(stitch=any_stitch, more=numbers(1e-3, 0.4))
def test_more_yarn_in_a_loop_locks_later_and_thicker_yarn_sooner(stitch: Stitch, more: float) -> None:
    length = yarn_per_loop(stitch)
    assert locking_strain(stitch, length + more) > locking_strain(stitch, length)
    thicker = replace(stitch, fibre_radius=stitch.fibre_radius + more / 10.0)
    assert locking_strain(thicker, length) < locking_strain(stitch, length)


@settings(max_examples=10, deadline=None)
@given(loops=st.integers(1, 5))
def test_named_stitches_have_room_for_their_yarn(loops: int) -> None:
    for stitch in NAMED_STITCHES.values():
        assert knit_specimen(stitch, rows=3, loops=loops, loop_width=8e-3).clearance > 0.0


sound_volumetric = st.builds(
    VolumetricStitch,
    curvature=numbers(1.4, 1.6),
    wale_height=numbers(1.55, 1.7),
    pile_height=numbers(1.55, 1.7),
    depth=numbers(0.23, 0.28),
    row_spacing=numbers(1.05, 1.15),
    layer_spacing=numbers(1.18, 1.3),
    fibre_radius=numbers(0.01, 0.03),
)


@settings(max_examples=10, deadline=None)
@given(stitch=sound_volumetric, rows=st.integers(1, 3), loops=st.integers(1, 2), layers=st.integers(1, 3))
def test_volumetric_knits_are_one_c1_yarn_that_holds_everywhere(
    stitch: VolumetricStitch, rows: int, loops: int, layers: int
) -> None:
    knit = knit_specimen(stitch, rows=rows, loops=loops, layers=layers, loop_width=1.0, nodes_per_loop=36)
    for before, after in pairwise(knit.centreline.pieces):
        end, start = np.array([before.length]), np.zeros(1)
        np.testing.assert_allclose(before.position(end), after.position(start), atol=1e-9)
        np.testing.assert_allclose(before.tangent(end), after.tangent(start), atol=1e-8)
    assert knit.clearance > 0.0
    numbers_of = clasp_numbers(knit, knit.nodes)
    assert numbers_of.shape == ((layers * (rows - 1) + (layers - 1) * rows) * loops, 2)
    assert np.all(np.abs(numbers_of) == 1)
    assert np.all(numbers_of[:, 0] == -numbers_of[:, 1])


@settings(max_examples=20, deadline=None)
@given(stitch=sound_volumetric, rows=counts, loops=counts, layers=counts)
def test_volumetric_arc_length_is_arc_length_and_curvature_its_second_derivative(
    stitch: VolumetricStitch, rows: int, loops: int, layers: int
) -> None:
    yarn = volumetric(stitch, rows=rows, loops=loops, layers=layers)
    step = 1e-4
    s = np.linspace(step, yarn.length - step, 401)
    np.testing.assert_allclose(np.linalg.norm(yarn.tangent(s), axis=-1), 1.0, rtol=1e-14)
    difference = (yarn.position(s + step) - yarn.position(s - step)) / (2.0 * step)
    np.testing.assert_allclose(difference, yarn.tangent(s), atol=1e-3)
    bend = (yarn.tangent(s + step) - yarn.tangent(s - step)) / (2.0 * step)
    # Curvature jumps at feet and turn-arounds; a difference across a jump is neither side's value.
    smooth = np.linalg.norm(yarn.curvature(s + step) - yarn.curvature(s - step), axis=-1) < 0.1
    assert smooth.mean() > 0.95
    np.testing.assert_allclose(bend[smooth], yarn.curvature(s)[smooth], atol=1e-2)


@settings(max_examples=20, deadline=None)
@given(stitch=sound_volumetric, rows=counts, loops=counts, layers=counts)
def test_opposite_faces_have_opposite_means_about_the_middle(
    stitch: VolumetricStitch, rows: int, loops: int, layers: int
) -> None:
    yarn = volumetric(stitch, rows=rows, loops=loops, layers=layers)
    middle = volumetric_middle(stitch, rows, loops, layers)
    for axis, name in enumerate(("course", "wale", "pile")):
        plus, minus = (
            yarn.position(np.array([site.arc_length for site in yarn.sites if site.set == f"{name}{sign}"]))
            for sign in "+-"
        )
        np.testing.assert_allclose(plus.mean(axis=0)[axis] + minus.mean(axis=0)[axis], 2.0 * middle[axis], atol=1e-9)
        assert plus[:, axis].mean() > minus[:, axis].mean()

"""Rib 1x1, garter and seed: one C1 yarn each, whose loops hold each other from the right side."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.distance import cdist

from knitlab_core.errors import GeometryError
from knitlab_core.knits import NAMED_STITCHES, Counts, Stitch, clasp_numbers, fabric_named, knit_specimen, planar_line
from knitlab_core.knits.garter import NAMED_GARTERS
from knitlab_core.knits.rib import NAMED_RIBS
from knitlab_core.knits.seed import NAMED_SEEDS

RIB, GARTER, SEED = NAMED_RIBS["rib-1x1"], NAMED_GARTERS["garter"], NAMED_SEEDS["seed"]
NAMES = ["rib", "garter", "seed"]
ALL = pytest.mark.parametrize("stitch", [RIB, GARTER, SEED], ids=NAMES)
SIZES = pytest.mark.parametrize(("rows", "loops"), [(1, 1), (2, 1), (2, 3), (3, 4)])


@ALL
@SIZES
def test_the_yarn_is_c1_and_by_its_arc_length(stitch: Stitch, rows: int, loops: int) -> None:
    yarn = planar_line(stitch, rows=rows, loops=loops)
    for before, after in pairwise(yarn.pieces):
        end, start = np.array([before.length]), np.zeros(1)
        np.testing.assert_allclose(before.position(end), after.position(start), atol=1e-12)
        np.testing.assert_allclose(before.tangent(end), after.tangent(start), atol=1e-12)
    step = 1e-5
    s = np.linspace(step, yarn.length - step, 1501)
    moved = (yarn.position(s + step) - yarn.position(s - step)) / (2.0 * step)
    turned = (yarn.tangent(s + step) - yarn.tangent(s - step)) / (2.0 * step)
    # Curvature jumps where pieces join, and in rib and seed at the first and last head.
    smooth = np.linalg.norm(turned - yarn.curvature(s), axis=-1) < 1e-4
    assert np.count_nonzero(~smooth) <= 4 * rows
    np.testing.assert_allclose(moved[smooth], yarn.tangent(s)[smooth], atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(yarn.tangent(s), axis=-1), 1.0, rtol=1e-12)


@ALL
def test_rows_give_back_the_parameter_s_place(stitch: Stitch) -> None:
    t = np.linspace(-np.pi, 5.0 * np.pi, 301)
    for number in (0, 1):
        row = stitch.row(number, 3)
        at = row.position(row.arc_length(t))
        np.testing.assert_allclose(at[:, 0], (t + stitch.curvature * np.sin(2.0 * t)) / (2.0 * np.pi), atol=1e-9)
        np.testing.assert_allclose(at[:, 1], stitch.height * np.cos(t) + number * stitch.row_spacing, atol=1e-9)


def test_wales_of_a_rib_and_rows_of_garter_are_mirrored() -> None:
    t = np.linspace(-0.9 * np.pi, 0.9 * np.pi, 101)
    rib, knit, purl = RIB.row(0, 4), GARTER.row(0, 2), GARTER.row(1, 2)
    middle = [rib.position(rib.arc_length(t + 2.0 * np.pi * loop)) for loop in (1, 2)]
    np.testing.assert_allclose(middle[1] - middle[0], [1.0, 0.0, 0.0] - 2.0 * middle[0] * [0.0, 0.0, 1.0], atol=1e-12)
    rows = [row.position(row.arc_length(t)) for row in (knit, purl)]
    lifted = rows[0] * [1.0, 1.0, -1.0] + [0.0, GARTER.row_spacing, 0.0]
    np.testing.assert_allclose(rows[1], lifted, atol=1e-12)


def test_rows_and_wales_of_seed_are_mirrored() -> None:
    t = np.linspace(-0.9 * np.pi, 0.9 * np.pi, 101)
    even, odd = SEED.row(0, 4), SEED.row(1, 4)
    first = even.position(even.arc_length(t + 2.0 * np.pi)) * [1.0, 1.0, -1.0]
    beside = even.position(even.arc_length(t + 4.0 * np.pi))
    np.testing.assert_allclose(beside, first + np.array([1.0, 0.0, 0.0]), atol=1e-12)
    above = odd.position(odd.arc_length(t + 2.0 * np.pi))
    np.testing.assert_allclose(above, first + np.array([0.0, SEED.row_spacing, 0.0]), atol=1e-12)


@pytest.mark.parametrize("loops", [1, 2, 4])
def test_loops_of_a_rib_are_held_from_front_and_back_in_turn(loops: int) -> None:
    numbers = clasp_numbers(knit := knit_specimen(RIB, rows=3, loops=loops, loop_width=1.0), knit.nodes)
    stockinette = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=1, loop_width=1.0)
    first = clasp_numbers(stockinette, stockinette.nodes)[0, 0]
    assert numbers.tolist() == [[((-1) ** loop * first).tolist() for loop in range(loops)]] * 2


def test_rows_of_garter_are_held_from_front_and_back_in_turn() -> None:
    numbers = clasp_numbers(knit := knit_specimen(GARTER, rows=4, loops=2, loop_width=1.0), knit.nodes)
    assert numbers[:, 0].tolist() == [[1, -1], [-1, 1], [1, -1]]
    assert np.array_equal(numbers[:, 0], numbers[:, 1])


@pytest.mark.parametrize("loops", [1, 2, 3])
def test_loops_of_seed_are_held_from_front_and_back_in_turn_both_ways(loops: int) -> None:
    numbers = clasp_numbers(knit := knit_specimen(SEED, rows=4, loops=loops, loop_width=1.0), knit.nodes)
    sides = [[(-1) ** (row + loop) for loop in range(loops)] for row in range(3)]
    assert numbers[..., 0].tolist() == sides
    assert np.array_equal(numbers[..., 1], -numbers[..., 0])


@ALL
def test_rows_too_far_apart_do_not_hold_each_other(stitch: Stitch) -> None:
    with pytest.raises(GeometryError, match="rows that do not hold each other"):
        knit_specimen(replace(stitch, row_spacing=2.2 * stitch.height), rows=2, loops=2, loop_width=1.0)


@pytest.mark.parametrize(("stitch", "least"), [(RIB, 0.05), (GARTER, 0.12), (SEED, 0.07)], ids=NAMES)
def test_strands_of_the_defaults_are_clear_of_each_other(stitch: Stitch, least: float) -> None:
    knit = knit_specimen(stitch, rows=3, loops=3, loop_width=1.0)
    assert knit.clearance > least
    arcs = np.linspace(0.0, knit.centreline.length, 1201)
    points = knit.centreline.position(arcs)
    apart = cdist(points, points)
    far_along = np.abs(arcs[:, None] - arcs[None]) > 0.6
    spacing = arcs[1]
    assert knit.clearance + 2.0 * stitch.fibre_radius == pytest.approx(apart[far_along].min(), abs=spacing)


@pytest.mark.parametrize(("stitch", "radius"), [(RIB, 0.125), (GARTER, 0.125), (SEED, 0.095)], ids=NAMES)
def test_strands_that_overlap_are_named(stitch: Stitch, radius: float) -> None:
    with pytest.raises(GeometryError, match=r"strands .* mm apart at row \d, loop \d .* and row \d, loop \d"):
        knit_specimen(replace(stitch, fibre_radius=radius), rows=2, loops=2, loop_width=8e-3)


@pytest.mark.parametrize(("stitch", "wave"), [(RIB, 2.5), (GARTER, 3.0), (SEED, 3.5)], ids=NAMES)
def test_the_locking_strain_is_that_of_the_yarn_of_a_loop(stitch: Stitch, wave: float) -> None:
    a, h, d, w, r = (getattr(stitch, name) for name in ("curvature", "height", "depth", "row_spacing", "fibre_radius"))

    def speed(t: float) -> float:
        course = (1.0 + 2.0 * a * np.cos(2.0 * t)) / (2.0 * np.pi)
        return float(np.sqrt(course**2 + (h * np.sin(t)) ** 2 + (wave * d * np.sin(wave * t)) ** 2))

    yarn = 2.0 * quad(speed, 0.0, np.pi, epsrel=1e-12)[0]
    assert stitch.loop_length(Counts(2, 2)) == pytest.approx(yarn, rel=1e-10)
    crossings = 11.67 * r + 1.076 * d * wave / 2.0 - 0.179 * (a - 1.5) - 0.075
    found = stitch.budgets(r)["W"]
    assert found.locking == pytest.approx((1.005 * yarn - crossings) / (1.0 + 2.0 * w) - 1.0, rel=1e-9)
    assert stitch.budgets(2.0 * r)["W"].locking < found.locking
    # Changing sides takes yarn: with its rows as far apart, stockinette locks earlier.
    plain = Stitch(curvature=a, height=h, depth=d, row_spacing=w, fibre_radius=r)
    assert plain.budgets(r)["W"].locking < found.locking


def test_they_have_names() -> None:
    assert fabric_named("rib-1x1") == RIB
    assert fabric_named("garter") == GARTER
    assert fabric_named("seed") == SEED

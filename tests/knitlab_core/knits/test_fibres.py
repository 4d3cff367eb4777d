import math
from dataclasses import replace

import numpy as np
import pytest

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import NAMED_STITCHES, planar_line
from knitlab_core.knits.fibres import (
    LARGEST_TURN,
    PRINTED_GAP,
    Yarn,
    check_turn,
    fibre_sites,
    fibre_strands,
    same_area,
)
from tests.curves import Straight, yarn_of

KNIT = planar_line(NAMED_STITCHES["stockinette-default"], rows=2, loops=2)
THREE = Yarn(fibres=3, fibre_radius=0.03, winding_radius=0.04, twist=3.0)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("fibres", 0),
        ("fibres", 65),
        ("fibres", 2.0),
        ("fibres", True),
        ("fibre_radius", 0.0),
        ("fibre_radius", 0.51),
        ("fibre_radius", math.nan),
        ("winding_radius", -0.01),
        ("winding_radius", math.inf),
        ("twist", 201.0),
        ("twist", math.nan),
        ("twist", "3"),
        ("phase", 7.0),
        ("bonding", 1.1),
        ("bonding", -0.1),
        ("model", "rope"),
    ],
)
def test_bad_numbers_are_refused_by_name(field: str, value: object) -> None:
    with pytest.raises(SpecificationError) as caught:
        replace(THREE, **{field: value})  # type: ignore[arg-type]
    assert caught.value.field == f"yarn.{field}"
    assert "\n" not in str(caught.value)


def test_one_fibre_that_winds_is_no_rod() -> None:
    with pytest.raises(SpecificationError, match="spring"):
        Yarn(fibre_radius=0.02, winding_radius=0.1)
    assert Yarn(fibre_radius=0.02, winding_radius=0.1, model="bundle").contact_radius == 0.02


@pytest.mark.parametrize("fibres", [2, 3, 4, 7])
def test_fibres_overlap_from_r_sin_pi_over_n_on(fibres: int) -> None:
    touching = 0.03 / math.sin(math.pi / fibres)
    Yarn(fibres=fibres, fibre_radius=0.03, winding_radius=touching * (1.0 + 1e-9))
    with pytest.raises(GeometryError, match=r"yarn\.winding_radius"):
        Yarn(fibres=fibres, fibre_radius=0.03, winding_radius=touching * (1.0 - 1e-9))


@pytest.mark.parametrize(("fibres", "twist"), [(2, 3.0), (2, 60.0), (3, 12.0), (4, -8.0), (1, 90.0)])
def test_the_gap_of_a_wound_yarn_is_that_of_dense_points(fibres: int, twist: float) -> None:
    yarn = Yarn(fibres=fibres, fibre_radius=0.005, winding_radius=0.05, twist=twist, model="bundle")
    s = np.linspace(-0.2, 0.2, 8001)
    angle = 2.0 * np.pi / fibres + twist * s
    squared = (0.05 * np.cos(angle) - 0.05) ** 2 + (0.05 * np.sin(angle)) ** 2 + s**2
    # Of one fibre alone: its next turn, not itself.
    away = np.abs(s) > (np.pi / abs(twist) if fibres == 1 else -1.0)
    assert yarn.straight_gap == pytest.approx(math.sqrt(squared[away].min()) - 0.01, abs=1e-6)


def test_twist_alone_can_make_fibres_overlap() -> None:
    yarn = Yarn(fibres=4, fibre_radius=0.025, winding_radius=0.0371)
    assert yarn.straight_gap > 0.0
    with pytest.raises(GeometryError, match="less twist"):
        replace(yarn, twist=15.0)


def test_fibres_lie_around_the_centreline_evenly_spread() -> None:
    s = np.linspace(0.0, KNIT.length, 301)
    middle = KNIT.position(s)
    strands = fibre_strands(KNIT, s, THREE)
    assert [points.shape for points in strands] == [(301, 3)] * 3
    np.testing.assert_allclose(np.mean(strands, axis=0), middle, atol=1e-14)
    for points in strands:
        np.testing.assert_allclose(np.linalg.norm(points - middle, axis=-1), 0.04, rtol=1e-12)
        np.testing.assert_allclose(np.sum((points - middle) * KNIT.tangent(s), axis=-1), 0.0, atol=1e-14)


def test_a_single_fibre_is_the_centreline() -> None:
    s = np.linspace(0.0, KNIT.length, 50)
    (only,) = fibre_strands(KNIT, s, Yarn(fibre_radius=0.05))
    np.testing.assert_array_equal(only, KNIT.position(s))


def test_positive_twist_is_a_right_handed_helix_from_its_phase() -> None:
    yarn = yarn_of(Straight(length=2.0))
    s = np.linspace(0.0, 2.0, 41)
    (fibre,) = fibre_strands(yarn, s, Yarn(fibre_radius=0.01, winding_radius=0.1, twist=2.0, phase=0.5, model="bundle"))
    # Along x, e2 is z and e3 = x cross z = -y.
    angle = 2.0 * s + 0.5
    np.testing.assert_allclose(
        fibre, np.column_stack([s, -0.1 * np.sin(angle), 0.1 * np.cos(angle)]), rtol=0.0, atol=1e-13
    )
    first, second = fibre[0] - [s[0], 0.0, 0.0], fibre[1] - [s[1], 0.0, 0.0]
    assert np.cross(first, second)[0] > 0.0


@pytest.mark.parametrize("fibres", [1, 2, 3, 7])
def test_dividing_a_fibre_keeps_its_area_and_leaves_the_gap(fibres: int) -> None:
    yarn = same_area(0.05, fibres)
    assert yarn.fibres * yarn.fibre_radius**2 == pytest.approx(0.05**2)
    gap = PRINTED_GAP * yarn.fibre_radius if fibres > 1 else math.inf
    assert yarn.straight_gap == pytest.approx(gap)


def test_a_loose_yarn_touches_where_it_is_packed_and_a_glued_one_at_its_outside() -> None:
    loose = same_area(0.05, 4)
    assert loose.contact_radius == pytest.approx(0.05)
    assert replace(loose, bonding=1.0).contact_radius == pytest.approx(loose.outer_radius)
    assert replace(loose, model="bundle").contact_radius == loose.fibre_radius
    assert same_area(0.05, 1).contact_radius == 0.05


def test_a_hook_holds_a_node_of_every_fibre() -> None:
    np.testing.assert_array_equal(fibre_sites(np.array([2, 7]), nodes=10, fibres=3), [[2, 12, 22], [7, 17, 27]])


def test_nodes_too_few_for_the_twist_are_refused() -> None:
    arcs = np.linspace(0.0, 1.0, 11)
    bundle = replace(THREE, model="bundle")
    check_turn(replace(bundle, twist=9.99 * LARGEST_TURN), arcs)
    with pytest.raises(SpecificationError, match=r"1\.2 times as many nodes"):
        check_turn(replace(bundle, twist=-12.0 * LARGEST_TURN), arcs)
    check_turn(replace(THREE, twist=12.0 * LARGEST_TURN), arcs)

from dataclasses import replace

import numpy as np
import pytest

from knitlab_core.errors import GeometryError
from knitlab_core.knits import (
    NAMED_STITCHES,
    Specimen,
    clasp_nodes,
    clasp_numbers,
    clasps_hold,
    knit_specimen,
    parted_at,
)
from knitlab_core.knits.planar import stitch_clasp
from tests.linking import linking_number

DEFAULT = NAMED_STITCHES["stockinette-default"]


def ring(corners: int, centre: tuple[float, float, float], *, upright: bool) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    flat, zero = np.stack([np.cos(angle), np.sin(angle)]), np.zeros(corners)
    points = [flat[0], zero, flat[1]] if upright else [flat[0], flat[1], zero]
    return np.stack(points, axis=-1) + centre


@pytest.mark.parametrize("corners", [3, 4, 50])
def test_two_links_of_a_chain_have_linking_number_one_to_rounding(corners: int) -> None:
    link = linking_number(ring(corners, (0, 0, 0), upright=False), ring(corners + 1, (1, 0, 0.01), upright=True))
    assert abs(link) == pytest.approx(1.0, abs=1e-12)


def test_rings_apart_and_a_ring_through_which_another_goes_twice() -> None:
    flat = ring(30, (0, 0, 0), upright=False)
    assert linking_number(flat, ring(30, (2.5, 0, 0.01), upright=True)) == pytest.approx(0.0, abs=1e-12)
    once = ring(30, (1, 0, 0.01), upright=True)
    twice = np.concatenate([once, 0.9 * (once - [1, 0, 0.01]) + [1, 0, 0.01]])
    assert abs(linking_number(flat, twice)) == pytest.approx(2.0, abs=1e-12)


def test_reversing_one_curve_changes_the_sign() -> None:
    flat, through = ring(7, (0, 0, 0), upright=False), ring(9, (1, 0, 0.01), upright=True)
    assert linking_number(flat, through) == pytest.approx(-linking_number(flat, through[::-1]))


def specimen(name: str = "stockinette-default", rows: int = 3, loops: int = 2) -> Specimen:
    return knit_specimen(NAMED_STITCHES[name], rows=rows, loops=loops, loop_width=1.0)


def row_nodes(knit: Specimen, row: int) -> slice:
    starts = knit.centreline.starts
    return slice(*np.searchsorted(knit.arc_lengths, [starts[2 * row] - 1e-9, starts[2 * row + 1] + 1e-9]))


@pytest.mark.parametrize("name", NAMED_STITCHES)
def test_every_head_holds_the_sinkers_on_both_sides(name: str) -> None:
    knit = specimen(name, rows=4, loops=3)
    numbers = clasp_numbers(knit, knit.nodes)
    assert numbers.shape == (3, 3, 2)
    assert np.all(np.abs(numbers) == 1)
    assert np.all(numbers[..., 0] == -numbers[..., 1])
    assert np.all(numbers[..., 1] == stitch_clasp(NAMED_STITCHES[name]))


def test_one_loop_is_held_by_the_half_sinkers_of_the_row_s_ends() -> None:
    knit = specimen(loops=1)
    assert np.all(np.abs(clasp_numbers(knit, knit.nodes)) == 1)


def test_a_knit_of_one_row_has_no_clasps() -> None:
    assert clasp_numbers(specimen(rows=1), specimen(rows=1).nodes).shape == (0, 2, 2)


def test_a_row_with_its_depth_flipped_is_held_by_neither_neighbour() -> None:
    knit = specimen()
    nodes = knit.nodes.copy()
    nodes[row_nodes(knit, 1), 2] *= -1.0
    assert not clasp_numbers(knit, nodes).any()


@pytest.mark.parametrize("lift", [0.8, -0.8])
def test_a_row_lifted_out_of_the_plane_is_held_by_neither_neighbour(lift: float) -> None:
    knit = specimen()
    nodes = knit.nodes.copy()
    nodes[row_nodes(knit, 1), 2] += lift
    assert not clasp_numbers(knit, nodes).any()


def test_only_the_clasps_of_a_lifted_row_are_lost() -> None:
    knit = specimen(rows=4)
    nodes = knit.nodes.copy()
    nodes[row_nodes(knit, 0), 2] += 0.8
    numbers = clasp_numbers(knit, nodes)
    assert not numbers[0].any()
    assert np.all(np.abs(numbers[1:]) == 1)


@pytest.mark.parametrize("beyond", [1.05, 1.5])
def test_rows_farther_apart_than_two_heights_do_not_hold_each_other_and_are_refused(beyond: float) -> None:
    loose = replace(DEFAULT, row_spacing=2.0 * beyond * DEFAULT.height)
    assert stitch_clasp(loose) == 0
    with pytest.raises(GeometryError, match="do not hold"):
        knit_specimen(loose, rows=2, loops=2, loop_width=1.0)


def test_a_row_pulled_away_in_the_plane_is_let_go() -> None:
    knit = specimen(rows=2)
    nodes = knit.nodes.copy()
    nodes[row_nodes(knit, 1), 1] += 2.0 * DEFAULT.height
    assert not clasp_numbers(knit, nodes).any()


def test_stretching_and_turning_the_knit_s_plane_keeps_its_clasps() -> None:
    knit = specimen()
    stretched = knit.nodes * [1.4, 1.3, 0.6]
    assert np.array_equal(clasp_numbers(knit, stretched), clasp_numbers(knit, knit.nodes))


def test_rows_that_no_clasp_holds_together_are_named() -> None:
    whole = {"rows": np.ones((3, 4), dtype=np.bool_)}
    assert parted_at(whole) == ""
    torn = np.ones((3, 4), dtype=np.bool_)
    torn[1, :3] = False
    assert parted_at({"rows": torn}) == ""
    torn[1, 3] = False
    assert parted_at({"rows": torn}) == "rows 1 and 2"


def test_rows_of_a_volumetric_knit_are_held_while_one_layer_holds_them() -> None:
    rows, layers = np.ones((2, 3, 4), dtype=np.bool_), np.ones((1, 4, 4), dtype=np.bool_)
    rows[0, 2] = False
    assert parted_at({"rows": rows, "layers": layers}) == ""
    rows[1, 2] = False
    assert parted_at({"rows": rows, "layers": layers}) == "rows 2 and 3"
    layers[0] = False
    assert parted_at({"layers": layers}) == "layers 0 and 1"


def test_a_knit_as_built_is_held_everywhere_and_one_drawn_apart_nowhere_between_its_rows() -> None:
    made = knit_specimen(NAMED_STITCHES["stockinette-default"], loop_width=8e-3, rows=3, loops=3, nodes_per_loop=24)
    clasps = clasp_nodes(made)
    assert all(held.all() for held in clasps_hold(made.nodes, clasps).values())
    # The last row is lifted out of the heads that hold it.
    moved = made.nodes.copy()
    moved[made.arc_lengths > 0.68 * made.yarn_length, 1] += 0.1
    hold = clasps_hold(moved, clasps)["rows"]
    assert hold[0].all()
    assert not hold[1].any()
    assert parted_at({"rows": hold}) == "rows 1 and 2"

from collections import Counter
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, Centreline, Site, volumetric, yarn_per_loop
from knitlab_core.knits.pieces import Turn
from knitlab_core.knits.volumetric_row import VolumetricRow

DEFAULT = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
UNEVEN = replace(DEFAULT, wale_height=1.7, pile_height=1.45, depth=0.3)
ROWS, LOOPS, LAYERS = 4, 3, 3
KNIT = volumetric(UNEVEN, rows=ROWS, loops=LOOPS, layers=LAYERS)
SIZES = [(4, 4, 2), (3, 2, 3), (1, 1, 4), (5, 1, 2), (2, 3, 1), (6, 6, 6)]


def loop_points(t: np.ndarray, row: int, layer: int, stitch: int, *, pile: bool) -> np.ndarray:
    """Write the design's formula out."""
    a, d = UNEVEN.curvature, UNEVEN.depth
    course = 2.0 * stitch + (t + a * np.sin(2.0 * t)) / (2.0 * np.pi)
    aside = d * (np.cos(2.0 * t) - 1.0)
    base = [0.0, row * UNEVEN.row_spacing, layer * UNEVEN.layer_spacing]
    if pile:
        return np.stack([course + 1.0, aside, 0.5 * UNEVEN.pile_height * (1.0 + np.cos(t))], axis=-1) + base
    way = 1.0 if layer in {0, 2} else -1.0
    return np.stack([course, way * 0.5 * UNEVEN.wale_height * (1.0 + np.cos(t)), aside], axis=-1) + base


def row_piece(row: int, layer: int) -> tuple[int, VolumetricRow]:
    for number, piece in enumerate(KNIT.pieces):
        if isinstance(piece, VolumetricRow) and (piece.row, piece.layer) == (row, layer):
            return number, piece
    raise LookupError


def sites_of(face: str, yarn: Centreline = KNIT) -> list[Site]:
    return [site for site in yarn.sites if site.set == face]


def at(sites: list[Site], yarn: Centreline = KNIT) -> np.ndarray:
    return yarn.position(np.array([site.arc_length for site in sites]))


@pytest.mark.parametrize("pile", [False, True], ids=["wale", "pile"])
@pytest.mark.parametrize(("row", "layer"), [(0, 0), (3, 0), (3, 1), (1, 1), (2, 2)])
def test_every_loop_lies_on_the_design_s_formula(row: int, layer: int, *, pile: bool) -> None:
    number, piece = row_piece(row, layer)
    t = np.linspace(-np.pi, np.pi, 201)[1:-1]
    for stitch in range(LOOPS):
        s = KNIT.starts[number] + piece.arc_length(np.full(t.size, stitch), pile=pile, t=t)
        assert KNIT.position(s) == pytest.approx(loop_points(t, row, layer, stitch, pile=pile), abs=1e-11)
        assert (
            KNIT.place(float(s[7])) == f"layer {layer}, row {row}, stitch {stitch}, {'pile' if pile else 'wale'} loop"
        )


def test_one_yarn_takes_every_row_of_every_layer_once_and_turns_between() -> None:
    assert [type(piece) for piece in KNIT.pieces] == [VolumetricRow, Turn] * (ROWS * LAYERS - 1) + [VolumetricRow]
    taken = [(piece.layer, piece.row) for piece in KNIT.pieces if isinstance(piece, VolumetricRow)]
    assert taken == [(0, k) for k in (0, 1, 2, 3)] + [(1, k) for k in (3, 2, 1, 0)] + [(2, k) for k in (0, 1, 2, 3)]
    stitches = ROWS * LOOPS * LAYERS * (yarn_per_loop(UNEVEN.wale_loop) + yarn_per_loop(UNEVEN.pile_loop))
    turns = LAYERS * (ROWS - 1) * UNEVEN.row_spacing + (LAYERS - 1) * UNEVEN.layer_spacing
    assert KNIT.length == pytest.approx(stitches + np.pi / 2.0 * turns, rel=1e-12)


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_pieces_meet_with_position_and_tangent(size: tuple[int, int, int]) -> None:
    rows, loops, layers = size
    yarn = volumetric(UNEVEN, rows=rows, loops=loops, layers=layers)
    assert len(yarn.pieces) == 2 * rows * layers - 1
    for before, after in pairwise(yarn.pieces):
        end, start = np.array([before.length]), np.zeros(1)
        assert before.position(end) == pytest.approx(after.position(start), abs=1e-12)
        assert before.tangent(end) == pytest.approx(after.tangent(start), abs=1e-12)


@pytest.mark.parametrize("row", [0, 2])
def test_loops_of_a_row_meet_with_position_and_tangent_along_the_course(row: int) -> None:
    number, piece = row_piece(row, 1)
    per_stitch = yarn_per_loop(UNEVEN.wale_loop) + yarn_per_loop(UNEVEN.pile_loop)
    wale = np.arange(LOOPS) * per_stitch + yarn_per_loop(UNEVEN.wale_loop)
    joins = KNIT.starts[number] + np.sort(np.concatenate([wale, per_stitch * np.arange(1, LOOPS)]))
    if piece.direction < 0:
        joins = KNIT.starts[number] + KNIT.starts[number + 1] - joins
    for side in (-1e-9, 1e-9):
        expected = np.tile([float(piece.direction), 0.0, 0.0], (joins.size, 1))
        assert KNIT.tangent(joins + side) == pytest.approx(expected, abs=1e-6)
    feet = np.array([[x, row * UNEVEN.row_spacing, UNEVEN.layer_spacing] for x in np.arange(0.5, 2.0 * LOOPS - 1.0)])
    assert np.sort(KNIT.position(joins), axis=0) == pytest.approx(feet, abs=1e-11)


def test_turn_arounds_are_semicircles_outside_the_knit_no_longer_than_one_spacing() -> None:
    for number, piece in enumerate(KNIT.pieces):
        if not isinstance(piece, Turn):
            continue
        points = KNIT.position(np.linspace(KNIT.starts[number], KNIT.starts[number + 1], 51))
        ends = points[-1] - points[0]
        rises = KNIT.pieces[number - 1].place(0.1)[:7] != KNIT.pieces[number + 1].place(0.1)[:7]
        assert np.abs(ends) == pytest.approx([0, 0, UNEVEN.layer_spacing] if rises else [0, UNEVEN.row_spacing, 0])
        radii = np.linalg.norm(points - 0.5 * (points[0] + points[-1]), axis=-1)
        assert radii == pytest.approx(np.full(51, 0.5 * np.linalg.norm(ends)))
        assert np.all((points[:, 0] >= 2.0 * LOOPS - 0.5 - 1e-12) | (points[:, 0] <= -0.5 + 1e-12))
        assert np.ptp(points[:, 1 if rises else 2]) == pytest.approx(0.0, abs=1e-12)


def test_turn_arounds_are_named_by_what_they_join() -> None:
    middle = 0.5 * (KNIT.starts[:-1] + KNIT.starts[1:])
    assert KNIT.place(middle[1] - 0.1) == "turn-around from row 0 to row 1 of layer 0, first half"
    assert KNIT.place(middle[7] + 0.1) == "turn-around from layer 0 to layer 1 at row 3, second half"
    assert KNIT.place(middle[9] - 0.1) == "turn-around from row 3 to row 2 of layer 1, first half"


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_each_face_has_two_hooks_per_boundary_loop_and_one_per_row_end(size: tuple[int, int, int]) -> None:
    rows, loops, layers = size
    yarn = volumetric(DEFAULT, rows=rows, loops=loops, layers=layers)
    assert Counter(site.set for site in yarn.sites) == {
        "wale+": 2 * loops * layers,
        "wale-": 2 * loops * layers,
        "pile+": 2 * loops * rows,
        "pile-": 2 * loops * rows,
        "course+": rows * layers,
        "course-": rows * layers,
    }
    for face in ("wale+", "wale-", "pile+", "pile-", "course+", "course-"):
        spots = at(sites_of(face, yarn), yarn)
        row_of_hooks = [(site.layer, site.row) for site in sites_of(face, yarn)]
        assert row_of_hooks == sorted(row_of_hooks)
        for (one, first), (two, second) in pairwise(zip(row_of_hooks, spots, strict=True)):
            assert one != two or first[0] < second[0]


@pytest.mark.parametrize("face", ["wale+", "wale-", "pile+", "pile-"])
def test_hooks_are_at_the_hook_angle_on_free_heads_and_feet(face: str) -> None:
    head, feet = [-0.35, 0.35], [0.35 - np.pi, np.pi - 0.35]
    pile = face.startswith("pile")
    for site, hook in zip(sites_of(face), [0, 1] * 1000, strict=False):
        at_head = {"pile+": True, "pile-": False, "wale+": site.layer != 1, "wale-": site.layer == 1}[face]
        t = np.array([(head if at_head else feet)[hook]])
        assert at([site]) == pytest.approx(loop_points(t, site.row, site.layer, site.loop, pile=pile), abs=1e-11)
    rows = {"wale+": {3}, "wale-": {0}, "pile+": {0, 1, 2, 3}, "pile-": {0, 1, 2, 3}}
    layers = {"wale+": {0, 1, 2}, "wale-": {0, 1, 2}, "pile+": {2}, "pile-": {0}}
    assert {site.row for site in sites_of(face)} == rows[face]
    assert {site.layer for site in sites_of(face)} == layers[face]


def yarn_of_layer(layer: int, *, pile: bool) -> np.ndarray:
    t = np.linspace(-np.pi, np.pi, 101)
    return np.concatenate(
        [loop_points(t, row, layer, stitch, pile=pile) for row in range(ROWS) for stitch in range(LOOPS)]
    )


@pytest.mark.parametrize(("face", "outward"), [("wale+", 1.0), ("wale-", -1.0)])
def test_sites_of_a_wale_face_are_the_outermost_of_their_layer_s_wale_loops(face: str, outward: float) -> None:
    reach = 0.5 * UNEVEN.wale_height * (1.0 - np.cos(0.35))
    for layer in range(LAYERS):
        spots = at([site for site in sites_of(face) if site.layer == layer])
        farthest = (outward * yarn_of_layer(layer, pile=False)[:, 1]).max()
        assert outward * spots[:, 1] == pytest.approx(np.full(2 * LOOPS, farthest - reach), abs=1e-12)
        # Only flanks of pile loops, which lean to -y, stand farther out than feet.
        beyond = (outward * yarn_of_layer(layer, pile=True)[:, 1]).max() - farthest
        assert beyond <= (2.0 * UNEVEN.depth + 1e-12 if face == "wale-" else 0.0)


def test_sites_of_a_pile_face_are_the_outermost_of_all_pile_loops() -> None:
    reach = 0.5 * UNEVEN.pile_height * (1.0 - np.cos(0.35))
    z = np.concatenate([yarn_of_layer(layer, pile=True)[:, 2] for layer in range(LAYERS)])
    assert at(sites_of("pile+"))[:, 2] == pytest.approx(np.full(2 * LOOPS * ROWS, z.max() - reach), abs=1e-12)
    assert at(sites_of("pile-"))[:, 2] == pytest.approx(np.full(2 * LOOPS * ROWS, z.min() + reach), abs=1e-12)
    wale = np.concatenate([yarn_of_layer(layer, pile=False)[:, 2] for layer in range(LAYERS)])
    assert wale.max() < z.max() - reach
    # Flanks of the bottom layer's wale loops hang below the feet.
    assert wale.min() == pytest.approx(-2.0 * UNEVEN.depth, abs=1e-3)


def test_course_sites_are_where_turn_arounds_and_the_yarn_begin_and_end() -> None:
    arcs = sorted(site.arc_length for face in ("course+", "course-") for site in sites_of(face))
    assert arcs == pytest.approx(KNIT.starts, abs=1e-11)
    for face, x in (("course+", 2.0 * LOOPS - 0.5), ("course-", -0.5)):
        base = [[x, k * UNEVEN.row_spacing, m * UNEVEN.layer_spacing] for m in range(LAYERS) for k in range(ROWS)]
        assert at(sites_of(face)) == pytest.approx(np.array(base), abs=1e-11)


@pytest.mark.parametrize("count", [0, -1, 201, 2.0, True, None])
@pytest.mark.parametrize("field", ["rows", "loops", "layers"])
def test_counts_are_bounded_whole_numbers(field: str, count: int) -> None:
    with pytest.raises(SpecificationError) as caught:
        volumetric(DEFAULT, **{"rows": 2, "loops": 2, "layers": 2, field: count})
    assert caught.value.field == f"specimen.{field}"


def test_a_knit_of_too_many_stitches_is_refused_before_it_is_made() -> None:
    with pytest.raises(SpecificationError, match="at most 125000 stitches"):
        volumetric(DEFAULT, rows=200, loops=200, layers=200)

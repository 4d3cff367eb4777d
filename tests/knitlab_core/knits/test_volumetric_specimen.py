import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, Specimen, VolumetricStitch, knit_specimen, yarn_per_loop
from knitlab_core.knits.clasp import clasp_numbers, joined_clasps
from knitlab_core.knits.planar import stitch_clasp
from tests.volumetric_knit import Places, places

DEFAULT = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
L = 8e-3


@cache
def knit(rows: int = 3, loops: int = 2, layers: int = 3) -> Specimen:
    return knit_specimen(DEFAULT, rows=rows, loops=loops, layers=layers, loop_width=L)


@cache
def loops_of_nodes() -> Places:
    return places(knit())


def face_means(specimen: Specimen) -> dict[str, np.ndarray]:
    """Return the mean of each face's spots on the yarn about the origin [m]."""
    middle = specimen.nodes[0] - L * specimen.centreline.position(np.zeros(1))[0]
    yarn = L * specimen.centreline.position(specimen.arc_lengths / L) + middle
    return {str(face): yarn[nodes].mean(axis=0) for face, nodes in specimen.sites.items()}


def test_every_site_is_a_node() -> None:
    for face, nodes in knit().sites.items():
        arcs = [site.arc_length * L for site in knit().centreline.sites if site.set == face]
        assert knit().arc_lengths[nodes] == pytest.approx(arcs, rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("size", [(3, 2, 3), (4, 4, 2), (1, 1, 1)], ids=str)
def test_the_knit_is_centred_and_its_gauge_lengths_are_the_design_s(size: tuple[int, int, int]) -> None:
    rows, loops, layers = size
    means = face_means(knit(*size))
    reach = 2.0 * 0.8 * (1.0 - np.cos(0.35))
    lengths = {
        "course": 2.0 * loops,
        "wale": (rows - 1) * 1.10 + 1.6 - reach,
        "pile": (layers - 1) * 1.25 + 1.6 - reach,
    }
    for axis, (name, length) in enumerate(lengths.items()):
        assert means[f"{name}+"][axis] == pytest.approx(0.5 * L * length, rel=1e-9)
        assert means[f"{name}-"][axis] == pytest.approx(-0.5 * L * length, rel=1e-9)


def test_all_layers_are_equally_long_from_hook_to_hook_along_the_wale() -> None:
    at = {face: knit().nodes[nodes, 1].reshape(3, -1).mean(axis=1) for face, nodes in knit().sites.items()}
    lengths = at["wale+"] - at["wale-"]
    assert lengths == pytest.approx(np.full(3, lengths[0]), rel=1e-3)
    assert at["wale+"][0] - at["wale+"][1] == pytest.approx(1.6 * L, rel=0.1)


def test_edges_are_even_and_nodes_control_the_yarn() -> None:
    nominal = L * yarn_per_loop(DEFAULT.wale_loop) / 48
    assert np.diff(knit().arc_lengths) == pytest.approx(np.full(len(knit().nodes) - 1, nominal), rel=0.3)
    nodes = knit().nodes
    middle = (nodes[:-2] + 6.0 * nodes[1:-1] + nodes[2:]) / 8.0
    yarn = L * knit().centreline.position(knit().arc_lengths / L)
    yarn += nodes[0] - yarn[0]
    assert middle == pytest.approx(yarn[1:-1], abs=1e-15)


def test_the_nodes_are_one_chain_without_a_float() -> None:
    edges = np.linalg.norm(np.diff(knit().nodes, axis=0), axis=-1)
    assert edges / np.diff(knit().arc_lengths) == pytest.approx(np.ones(edges.size), abs=0.06)
    assert knit().arc_lengths[[0, -1]] == pytest.approx([0.0, knit().yarn_length])


@pytest.mark.parametrize("size", [(4, 4, 2), pytest.param((6, 6, 6), marks=pytest.mark.slow)], ids=str)
def test_the_paper_s_sizes_are_clear_of_themselves_and_hold_at_every_interlooping(size: tuple[int, int, int]) -> None:
    rows, loops, layers = size
    specimen = knit_specimen(DEFAULT, rows=rows, loops=loops, layers=layers, loop_width=L)
    between_centrelines = (specimen.clearance + 2.0 * specimen.radius) / L
    # The design's .148 is that of a polygon on the yarn; the curve's own is .0027 more.
    assert between_centrelines == pytest.approx(0.148, abs=3e-3)
    assert between_centrelines == pytest.approx(least_of_samples(specimen), abs=5e-4)
    wale, pile = joined_clasps(specimen, specimen.nodes)["rows"], joined_clasps(specimen, specimen.nodes)["layers"]
    assert wale.shape == (layers, rows - 1, loops, 2)
    assert pile.shape == (layers - 1, rows, loops, 2)
    assert np.all(np.abs(wale) == 1)
    assert np.all(np.abs(pile) == 1)
    both = clasp_numbers(specimen, specimen.nodes)
    assert np.array_equal(both, np.concatenate([wale.reshape(-1, 2), pile.reshape(-1, 2)]))
    assert np.all(both[:, 0] == -both[:, 1])
    # Mirrored layers have mirrored clasps.
    assert np.all(wale[0::2, ..., 1] == stitch_clasp(DEFAULT.wale_loop))
    assert np.all(wale[1::2, ..., 1] == -stitch_clasp(DEFAULT.wale_loop))


def least_of_samples(specimen: Specimen) -> float:
    """Search all pairs of samples 0.01 l apart with 1.3 l of yarn between them."""
    s = np.linspace(0.0, specimen.centreline.length, round(specimen.centreline.length / 0.01))
    points = specimen.centreline.position(s)
    pairs = cKDTree(points).query_pairs(0.16, output_type="ndarray")
    pairs = pairs[s[pairs[:, 1]] - s[pairs[:, 0]] > 1.3]
    return float(np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=-1).min())


def held(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return whether wale heads (layers, rows - 1) and pile heads (layers - 1, rows) are held, all or none of a row."""
    both = [np.abs(numbers) for numbers in joined_clasps(knit(), nodes).values()]
    for numbers in both:
        assert np.all(numbers.min(axis=(2, 3)) == numbers.max(axis=(2, 3)))
    return both[0].min(axis=(2, 3)), both[1].min(axis=(2, 3))


def base_line(axis: int, row: int, layer: int) -> float:
    nodes = loops_of_nodes()
    feet = (nodes.row == row) & (nodes.layer == layer) & (np.abs(np.abs(nodes.t) - np.pi) < 0.02)
    return float(knit().nodes[feet, axis].mean())


def test_pile_loops_with_their_depth_flipped_hold_neither_layer_beside_them() -> None:
    at, nodes = loops_of_nodes(), knit().nodes.copy()
    for row in range(3):
        flipped = (at.layer == 1) & (at.row == row) & at.pile
        nodes[flipped, 1] = 2.0 * base_line(1, row, 1) - nodes[flipped, 1]
    wale, pile = held(nodes)
    assert wale.all()
    assert not pile.any()


def test_wale_loops_with_their_depth_flipped_hold_neither_row_beside_them() -> None:
    at, nodes = loops_of_nodes(), knit().nodes.copy()
    flipped = (at.layer == 1) & (at.row == 1) & ~at.pile
    nodes[flipped, 2] = 2.0 * base_line(2, 1, 1) - nodes[flipped, 2]
    wale, pile = held(nodes)
    assert wale.tolist() == [[1, 1], [0, 0], [1, 1]]
    assert pile.all()


@pytest.mark.parametrize("lift", [0.8, -0.8])
def test_a_row_lifted_out_of_its_layer_is_held_by_neither_neighbour(lift: float) -> None:
    at, nodes = loops_of_nodes(), knit().nodes.copy()
    nodes[(at.layer == 1) & (at.row == 1), 2] += lift * L
    wale, pile = held(nodes)
    assert wale.tolist() == [[1, 1], [0, 0], [1, 1]]
    # It leaves the layer it moves away from, too.
    let_go = pile[0, 1] if lift > 0 else pile[1, 1]
    assert let_go == 0
    assert pile.sum() == 5


@pytest.mark.parametrize(("lift", "holds"), [(0.0, 1), (0.2, 1), (0.4, 0), (1.7, 0)])
def test_layers_lifted_past_the_pile_heads_are_let_go(lift: float, holds: int) -> None:
    at, nodes = loops_of_nodes(), knit().nodes.copy()
    nodes[at.layer >= 1, 2] += lift * L
    wale, pile = held(nodes)
    assert wale.all()
    assert pile.tolist() == [[holds] * 3, [1] * 3]


def test_rows_pulled_past_the_wale_heads_are_let_go() -> None:
    at, nodes = loops_of_nodes(), knit().nodes.copy()
    nodes[at.row == 2, 1] += (1.6 - 1.1 + 0.05) * L
    wale, pile = held(nodes)
    assert wale.tolist() == [[1, 0]] * 3
    assert pile.all()


def test_a_single_layer_has_no_pile_clasps_and_a_single_row_no_wale_clasps() -> None:
    flat, tower = knit(2, 2, 1), knit(1, 2, 3)
    assert joined_clasps(flat, flat.nodes)["layers"].shape == (0, 2, 2, 2)
    assert np.all(np.abs(joined_clasps(flat, flat.nodes)["rows"]) == 1)
    assert joined_clasps(tower, tower.nodes)["rows"].shape == (3, 0, 2, 2)
    assert np.all(np.abs(joined_clasps(tower, tower.nodes)["layers"]) == 1)


def test_free_heads_and_feet_are_those_that_no_other_loop_holds() -> None:
    specimen = knit()
    sites = specimen.centreline.sites
    # Wale heads that hold: of each layer all rows but the last along the way its heads point, and so for pile.
    holding = {(m, k) for m in range(3) for k in (range(2) if m != 1 else range(1, 3))}
    heads = {(s.layer, s.row) for s in sites if s.set == ("wale-" if s.layer == 1 else "wale+")}
    assert heads == {(m, k) for m in range(3) for k in range(3)} - holding
    held_rows = {(m, k + (1 if m != 1 else -1)) for m, k in holding}
    feet = {(s.layer, s.row) for s in sites if s.set == ("wale+" if s.layer == 1 else "wale-")}
    assert feet == {(m, k) for m in range(3) for k in range(3)} - held_rows


def build(stitch: VolumetricStitch) -> Specimen:
    return knit_specimen(stitch, rows=2, loops=1, layers=2, loop_width=L)


def test_a_yarn_thicker_than_the_gap_is_refused_and_both_places_are_named() -> None:
    with pytest.raises(GeometryError) as caught:
        build(replace(DEFAULT, fibre_radius=0.08))
    line = str(caught.value)
    assert re.search(r"strands 1\.205 mm apart at layer 0, row 0, stitch 0, pile loop \(arc length", line)
    assert "and layer 1, row 0, stitch 0, pile loop (arc length" in line
    assert "more than 2 r = 1.28 mm apart" in line
    assert "\n" not in line


@pytest.mark.parametrize(("change", "joined"), [("row_spacing", "rows"), ("layer_spacing", "layers")])
def test_loops_that_reach_over_the_spacing_but_do_not_hold_are_refused(change: str, joined: str) -> None:
    # A head is round: it must reach some way past the spacing to take in the legs of the next loop.
    loose = replace(DEFAULT, **{change: 1.55})
    assert stitch_clasp(loose.wale_loop if joined == "rows" else loose.pile_loop) == 0
    with pytest.raises(GeometryError, match=f"{joined} that do not hold"):
        build(loose)


def test_a_bend_tighter_than_the_yarn_is_refused() -> None:
    with pytest.raises(GeometryError, match="a bend of radius"):
        build(replace(DEFAULT, fibre_radius=0.33))


@pytest.mark.parametrize(
    ("field", "value"),
    [("loop_width", 0.0), ("loop_width", "8 mm"), ("nodes_per_loop", 7), ("layers", 0), ("rows", 1.5)],
)
def test_bad_sizes_are_refused_by_name(field: str, value: float) -> None:
    sizes = {"rows": 2, "loops": 1, "layers": 2, "loop_width": L, field: value}
    with pytest.raises(SpecificationError) as caught:
        knit_specimen(DEFAULT, **sizes)  # type: ignore[arg-type]
    assert caught.value.field == f"specimen.{field}"


def test_scale_changes_nothing_but_the_size() -> None:
    small = knit_specimen(DEFAULT, rows=3, loops=2, layers=3, loop_width=L / 128.0)
    assert np.array_equal(small.nodes * 128.0, knit().nodes)
    assert small.radius * 128.0 == knit().radius
    assert all(np.array_equal(small.sites[face], knit().sites[face]) for face in small.sites)

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, check_clearance, knit_specimen, yarn_per_loop

DEFAULT = NAMED_STITCHES["stockinette-default"]
KNIT = knit_specimen(DEFAULT, rows=6, loops=6, loop_width=8e-3)


def test_the_demo_specimen_has_the_design_s_sizes() -> None:
    assert KNIT.radius == pytest.approx(0.40e-3)
    assert KNIT.yarn_length == pytest.approx(36 * 8e-3 * yarn_per_loop(DEFAULT) + 5 * np.pi * 6.88e-3 / 2.0)
    between_centrelines = check_clearance(DEFAULT, rows=6, loops=6, loop_width=8e-3).distance
    assert KNIT.clearance == pytest.approx(8e-3 * between_centrelines - 2.0 * 0.40e-3)
    assert {edge: nodes.size for edge, nodes in KNIT.sites.items()} == {
        "wale+": 12,
        "wale-": 12,
        "course+": 6,
        "course-": 6,
    }


def test_every_site_is_a_node() -> None:
    for edge, nodes in KNIT.sites.items():
        arcs = [site.arc_length * 8e-3 for site in KNIT.centreline.sites if site.set == edge]
        assert KNIT.arc_lengths[nodes] == pytest.approx(arcs, rel=1e-13, abs=1e-15)


def test_sites_run_along_their_edge_and_lie_opposite_each_other() -> None:
    at = {str(edge): KNIT.nodes[nodes] for edge, nodes in KNIT.sites.items()}
    for edge, axis in (("wale+", 0), ("wale-", 0), ("course+", 1), ("course-", 1)):
        assert np.all(np.diff(at[edge][:, axis]) > 0.0)
    span = 8e-3 * (5 * DEFAULT.row_spacing + 2.0 * DEFAULT.height * np.cos(0.35))
    for upper, lower, axis, length in (("wale+", "wale-", 1, span), ("course+", "course-", 0, 6 * 8e-3)):
        apart = at[upper][:, axis] - at[lower][:, axis]
        # The nodes of a head lie outside its bend, by a little that depends on the edges beside them.
        assert apart == pytest.approx(np.full(apart.size, length), rel=1e-3)
        assert at[upper][:, axis] == pytest.approx(np.full(apart.size, length / 2.0), rel=1e-3)


@pytest.mark.parametrize("nodes_per_loop", [8, 24, 48, 96])
def test_edges_are_equal_between_sites_and_nearest_to_the_nominal_length(nodes_per_loop: int) -> None:
    knit = knit_specimen(DEFAULT, rows=2, loops=3, loop_width=1.0, nodes_per_loop=nodes_per_loop)
    nominal = yarn_per_loop(DEFAULT) / nodes_per_loop
    edges, at_sites = np.diff(knit.arc_lengths), np.sort(np.concatenate(list(knit.sites.values())))
    for first, last in pairwise(at_sites):
        stretch = knit.arc_lengths[last] - knit.arc_lengths[first]
        assert edges[first:last] == pytest.approx(np.full(last - first, stretch / (last - first)), rel=1e-10)
        choices = stretch / np.arange(1, 400)
        assert abs(edges[first] - nominal) <= np.abs(choices - nominal).min() + 1e-12


def test_the_spline_controlled_by_the_nodes_passes_through_the_yarn() -> None:
    nodes = KNIT.nodes
    middle = (nodes[:-2] + 6.0 * nodes[1:-1] + nodes[2:]) / 8.0
    yarn = 8e-3 * KNIT.centreline.position(KNIT.arc_lengths / 8e-3)
    yarn += nodes[0] - yarn[0]
    assert middle == pytest.approx(yarn[1:-1], abs=1e-15)


def test_edges_of_the_nodes_are_little_longer_than_the_yarn() -> None:
    edges = np.linalg.norm(np.diff(KNIT.nodes, axis=0), axis=-1)
    # Most where edges of two lengths meet, and nodes shift along the yarn.
    assert np.abs(edges / np.diff(KNIT.arc_lengths) - 1.0).max() < 0.05
    assert edges.sum() == pytest.approx(KNIT.yarn_length, rel=5e-3)


def test_a_row_of_loops_repeats_node_by_node_inside_the_knit() -> None:
    starts = 8e-3 * KNIT.centreline.starts
    first = np.searchsorted(KNIT.arc_lengths, starts[4] - 1e-9)
    loops = KNIT.nodes[first : first + 6 * 48].reshape(6, 48, 3)
    # What the ends of the row change dies out by a factor of 6 from node to node.
    assert np.diff(loops[1:5], axis=0) == pytest.approx(np.tile([8e-3, 0.0, 0.0], (3, 48, 1)), abs=1e-15)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("loop_width", 0.0),
        ("loop_width", -8e-3),
        ("loop_width", np.nan),
        ("loop_width", np.inf),
        ("loop_width", "8 mm"),
        ("loop_width", True),
        ("nodes_per_loop", 7),
        ("nodes_per_loop", 1001),
        ("nodes_per_loop", 48.0),
        ("rows", 0),
        ("loops", 201),
    ],
)
def test_bad_sizes_are_refused_by_name(field: str, value: float) -> None:
    with pytest.raises(SpecificationError) as caught:
        knit_specimen(DEFAULT, **{"rows": 2, "loops": 2, "loop_width": 8e-3, field: value})  # type: ignore[arg-type]
    assert caught.value.field == f"specimen.{field}"


def test_a_mesh_too_large_is_refused_before_it_is_made() -> None:
    with pytest.raises(SpecificationError, match="at most 2000000 nodes"):
        knit_specimen(DEFAULT, rows=200, loops=200, loop_width=8e-3, nodes_per_loop=60)


def test_a_flatter_stitch_needs_less_yarn() -> None:
    flat = knit_specimen(replace(DEFAULT, depth=0.2), rows=2, loops=2, loop_width=8e-3)
    assert flat.yarn_length < knit_specimen(DEFAULT, rows=2, loops=2, loop_width=8e-3).yarn_length

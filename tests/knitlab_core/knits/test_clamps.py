from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Fabric, Specimen, clamp_nodes, fabric_named, knit_specimen

LOOP = 8e-3


def knit(name: str = "stockinette-default", rows: int = 5, loops: int = 4, layers: int = 1) -> Specimen:
    fabric: Fabric = fabric_named(name)
    return knit_specimen(fabric, loop_width=LOOP, rows=rows, loops=loops, layers=layers, nodes_per_loop=24)


@pytest.mark.parametrize("name", ["stockinette-default", "rib-1x1", "garter"])
def test_jaws_hold_all_yarn_of_the_outermost_rows_up_to_where_the_next_begins(name: str) -> None:
    made = knit(name)
    clamps = clamp_nodes(made, "W")
    low, high = made.fabric.clamp_faces(made.counts)["W"]
    assert clamps.gap == pytest.approx(LOOP * (high - low))
    inside = np.zeros(len(made.nodes), dtype=bool)
    inside[np.concatenate([clamps.lower, clamps.upper])] = True
    # Nodes are beside the yarn by less than a tenth of a loop width.
    y = made.nodes[:, 1]
    assert np.all(np.abs(y[inside]) > 0.5 * clamps.gap - 0.1 * LOOP)
    assert np.all(np.abs(y[~inside]) < 0.5 * clamps.gap + 0.1 * LOOP)
    assert set(made.sites["wale-"]) <= set(clamps.lower.tolist())
    assert set(made.sites["wale+"]) <= set(clamps.upper.tolist())


def test_jaws_of_the_course_hold_the_edge_stitch_of_every_row_and_its_turn() -> None:
    made = knit()
    clamps = clamp_nodes(made, "C")
    assert clamps.gap == pytest.approx(2 * LOOP)
    lower = made.nodes[clamps.lower]
    assert lower[:, 0].min() == pytest.approx(made.nodes[:, 0].min())
    for row in range(5):
        # The head of the first stitch of every row is in the jaws.
        at = LOOP * np.array([-1.5, (row - 2) * 0.86 + 0.8])
        assert np.linalg.norm(lower[:, :2] - at, axis=1).min() < 0.1 * LOOP


def test_where_clamps_of_both_axes_cross_they_hold_nothing() -> None:
    made = knit()
    course, wale = (clamp_nodes(made, axis, ("C", "W")) for axis in ("C", "W"))
    held = np.concatenate([course.lower, course.upper, wale.lower, wale.upper])
    assert len(np.unique(held)) == len(held)
    corner = np.all(np.abs(made.nodes[:, :2]) > [0.6 * course.gap, 0.6 * wale.gap], axis=1)
    assert corner.any()
    assert not np.isin(np.flatnonzero(corner), held).any()


@pytest.mark.parametrize("counts", [(2, 4), (4, 2)])
def test_clamps_that_would_leave_no_stitch_free_are_refused(counts: tuple[int, int]) -> None:
    made = knit(rows=counts[0], loops=counts[1])
    with pytest.raises(SpecificationError, match="3 or more along each axis"):
        clamp_nodes(made, "W" if counts[0] == 2 else "C")


def test_knits_whose_edge_stitches_are_not_in_a_plane_are_refused() -> None:
    with pytest.raises(SpecificationError, match="planar knit"):
        clamp_nodes(knit("volumetric-default", 3, 2, 2), "W")

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import (
    NAMED_STITCHES,
    NAMED_VOLUMETRIC_STITCHES,
    knit_specimen,
    plate_nodes,
)
from tests.volumetric_knit import places

L = 50e-6
DEFAULT = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
KNIT = knit_specimen(DEFAULT, rows=3, loops=2, layers=3, loop_width=L)
HEIGHT = L * (2 * 1.25 + 1.6)


def test_the_plates_hold_every_hook_s_spot_of_the_pile_faces_and_no_inner_layer() -> None:
    plates, at = plate_nodes(KNIT), places(KNIT)
    assert np.isin(KNIT.sites["pile-"], plates.lower).all()
    assert np.isin(KNIT.sites["pile+"], plates.upper).all()
    assert set(at.layer[plates.lower]) <= {0, -1}
    assert set(at.layer[plates.upper]) == {2}
    assert np.intersect1d(plates.lower, plates.upper).size == 0


def test_the_upper_plate_holds_the_heads_of_pile_loops_alone() -> None:
    upper, at = plate_nodes(KNIT).upper, places(KNIT)
    assert at.pile[upper].all()
    runs = np.split(upper, np.flatnonzero(np.diff(upper) > 1) + 1)
    assert {(at.row[run[0]], at.stitch[run[0]]) for run in runs} == {(k, j) for k in range(3) for j in range(2)}
    assert len(runs) == 6
    for run in runs:
        # cos t = 1 - 2 depth/H_p at the plate's inner face.
        edge = np.arccos(1.0 - 2.0 * (0.05 + 0.8 * (1.0 - np.cos(0.35))) / 1.6)
        assert np.abs(at.t[run]).max() < edge < np.abs(at.t[[run[0] - 1, run[-1] + 1]]).min()


def test_the_lower_plate_holds_the_bottom_layer_s_feet_wale_loops_and_turn_arounds_whole() -> None:
    lower, at = plate_nodes(KNIT).lower, places(KNIT)
    assert np.isin(np.flatnonzero((at.layer == 0) & ~at.pile), lower).all()
    assert not np.isin(np.flatnonzero((at.layer == 0) & at.pile & (np.abs(at.t) < 2.5)), lower).any()
    s, starts = KNIT.arc_lengths / L, KNIT.centreline.starts
    assert np.isin(np.flatnonzero((s > starts[1]) & (s < starts[2])), lower).all()


def test_deeper_plates_hold_more_and_stand_nearer() -> None:
    shallow, deep = plate_nodes(KNIT, depth=0.2 * L), plate_nodes(KNIT, depth=0.6 * L)
    assert shallow.gap == pytest.approx(HEIGHT - 0.4 * L)
    assert deep.gap == pytest.approx(HEIGHT - 1.2 * L)
    for less, more in ((shallow.lower, deep.lower), (shallow.upper, deep.upper)):
        assert np.isin(less, more).all()
        assert more.size > less.size


def test_the_mesh_does_not_move_the_plates() -> None:
    fine = knit_specimen(DEFAULT, rows=3, loops=2, layers=3, loop_width=L, nodes_per_loop=96)
    assert plate_nodes(fine).gap == plate_nodes(KNIT).gap
    for coarse_nodes, fine_nodes in zip(plate_nodes(KNIT)[:2], plate_nodes(fine)[:2], strict=True):
        # A run of nodes may end up to an edge sooner on either mesh.
        runs = 1 + np.count_nonzero(np.diff(coarse_nodes) > 1)
        assert abs(fine_nodes.size - 2 * coarse_nodes.size) <= 3 * runs


@pytest.mark.parametrize("depth", [0.0, -1e-6, np.nan, 0.5 * HEIGHT, "thin"])
def test_a_depth_that_leaves_no_knit_between_is_refused(depth: float) -> None:
    with pytest.raises(SpecificationError, match=r"plates\.depth"):
        plate_nodes(KNIT, depth=depth)


def test_a_planar_knit_has_no_plates() -> None:
    planar = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=2, loop_width=L)
    with pytest.raises(SpecificationError, match="volumetric"):
        plate_nodes(planar)

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from knitlab_core.errors import GeometryError
from knitlab_core.knits import NAMED_STITCHES, check_clearance, planar_line
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import Yarn, fibre_strands, same_area
from tests.curves import Straight, double_bend, yarn_of

DEFAULT = NAMED_STITCHES["stockinette-default"]
KNIT = planar_line(DEFAULT, rows=2, loops=1)
LOOP_WIDTH = 8e-3
# Their gap closes by 0.05 of a radius on the inside of a straight yarn, and by more where it bends.
WOUND = replace(same_area(0.05, 4), twist=9.0)


@pytest.mark.parametrize("yarn", [WOUND, same_area(0.05, 3), replace(same_area(0.05, 2), twist=-9.0)])
def test_the_gap_inside_the_yarn_is_that_of_dense_points(yarn: Yarn) -> None:
    s = np.linspace(0.0, KNIT.length, 6001)
    strands = fibre_strands(KNIT, s, yarn)
    least = min(cKDTree(first).query(second)[0].min() for first, second in zip(strands[1:], strands[:-1], strict=True))
    found = check_fibres(KNIT, yarn, loop_width=LOOP_WIDTH).inside
    assert found == pytest.approx(least - 2.0 * yarn.fibre_radius, abs=5e-3 * yarn.fibre_radius)


def test_bends_close_the_gap_of_a_wound_yarn() -> None:
    assert check_fibres(KNIT, WOUND, loop_width=LOOP_WIDTH).inside < 0.9 * WOUND.straight_gap
    straight = check_fibres(yarn_of(Straight(length=3.0)), WOUND, loop_width=LOOP_WIDTH)
    assert straight.inside == pytest.approx(WOUND.straight_gap, abs=1e-3 * WOUND.fibre_radius)
    assert straight.between == np.inf


def test_yarns_are_as_far_apart_as_their_tubes() -> None:
    yarn = same_area(0.05, 3)
    distance = check_clearance(DEFAULT, rows=2, loops=1, loop_width=LOOP_WIDTH).distance
    found = check_fibres(KNIT, yarn, loop_width=LOOP_WIDTH)
    assert found.between == pytest.approx(distance - 2.0 * yarn.outer_radius, abs=1e-9)
    single = check_fibres(KNIT, Yarn(fibre_radius=0.05), loop_width=LOOP_WIDTH)
    assert single.between == pytest.approx(distance - 0.1, abs=1e-9)
    assert single.inside == np.inf


def test_tubes_that_overlap_are_refused_and_both_places_named() -> None:
    with pytest.raises(GeometryError) as caught:
        check_fibres(KNIT, same_area(0.1, 3), loop_width=LOOP_WIDTH)
    line = str(caught.value)
    assert caught.value.field == "specimen.yarn"
    assert re.search(r"yarns [0-9.]+ mm apart at row 0, loop 0 .* and row \d, loop 0", line)
    assert line.count("arc length") == 2
    assert "\n" not in line


def test_fibres_that_overlap_in_a_bend_alone_are_refused_and_the_place_named() -> None:
    yarn = replace(WOUND, twist=10.8)
    assert yarn.straight_gap > 0.0
    with pytest.raises(GeometryError, match=r"fibres 0\.\d+ mm apart at row \d, loop 0 \(arc length"):
        check_fibres(KNIT, yarn, loop_width=LOOP_WIDTH)


def test_a_bend_tighter_than_the_bundle_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"bend of radius 0\.8 mm at bend"):
        check_fibres(double_bend(0.1), same_area(0.09, 2), loop_width=LOOP_WIDTH)

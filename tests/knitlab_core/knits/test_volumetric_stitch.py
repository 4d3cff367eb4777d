import math
from dataclasses import replace

import pytest

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, Stitch

DEFAULT = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
FIELDS = ["curvature", "wale_height", "pile_height", "depth", "row_spacing", "layer_spacing", "fibre_radius"]


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 21.0, True, "0.5", None])
def test_a_stitch_refuses_what_is_no_positive_bounded_number(field: str, value: float) -> None:
    with pytest.raises(SpecificationError) as caught:
        replace(DEFAULT, **{field: value})
    assert caught.value.field == f"stitch.{field}"
    assert caught.value.found is value
    assert "above 0" in caught.value.expected


@pytest.mark.parametrize(
    ("spacing", "height"), [("row_spacing", "wale_height"), ("layer_spacing", "pile_height")], ids=["wale", "pile"]
)
@pytest.mark.parametrize("found", [1.6, 1.7])
def test_a_loop_that_cannot_reach_over_the_spacing_is_refused_by_both_names(
    spacing: str, height: str, found: float
) -> None:
    with pytest.raises(GeometryError) as caught:
        replace(DEFAULT, **{spacing: found})
    assert str(caught.value).startswith(f"stitch.{spacing}: found {found}, allowed less than stitch.{height}")
    assert "1.6" in caught.value.expected


def test_its_two_loops_are_planar_stitches_of_half_their_heights() -> None:
    uneven = replace(DEFAULT, wale_height=1.8, pile_height=1.5)
    assert uneven.wale_loop == Stitch(curvature=1.5, height=0.9, depth=0.25, row_spacing=1.10, fibre_radius=0.05)
    assert uneven.pile_loop == Stitch(curvature=1.5, height=0.75, depth=0.25, row_spacing=1.25, fibre_radius=0.05)

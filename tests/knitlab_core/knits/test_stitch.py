import math
from dataclasses import replace

import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Stitch, locking_strain

DEFAULT = NAMED_STITCHES["stockinette-default"]


@pytest.mark.parametrize("field", ["curvature", "height", "depth", "row_spacing", "fibre_radius"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, 11.0, True, "0.5", None])
def test_a_stitch_refuses_what_is_no_positive_bounded_number(field: str, value: float) -> None:
    with pytest.raises(SpecificationError) as caught:
        replace(DEFAULT, **{field: value})
    assert caught.value.field == f"stitch.{field}"
    assert caught.value.found is value
    assert "above 0" in caught.value.expected


def test_the_named_stitches_are_the_design_s() -> None:
    assert set(NAMED_STITCHES) == {"stockinette-default", "plain-knit", "G_B", "paper-fit"}
    assert (
        Stitch(curvature=1.55, height=0.61, depth=0.25, row_spacing=0.67, fibre_radius=0.0395)
        == (NAMED_STITCHES["paper-fit"])
    )


def test_locking_strain_is_the_published_fit_worked_by_hand() -> None:
    # 1.005 * 4.777 = 4.800885; 0.5835 + 0.269 - 0 - 0.075 = 0.7775; / 2.72
    assert locking_strain(DEFAULT, 4.777) == pytest.approx(4.023385 / 2.72 - 1.0, rel=1e-12)


def test_a_more_curved_loop_of_equal_yarn_locks_later() -> None:
    assert locking_strain(replace(DEFAULT, curvature=1.6), 4.777) - locking_strain(DEFAULT, 4.777) == pytest.approx(
        0.0179 / 2.72
    )

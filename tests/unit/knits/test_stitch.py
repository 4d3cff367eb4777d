import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Stitch, locking_strain, neighbour_gap

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
        Stitch(curvature=1.72, height=0.70, depth=0.303, row_spacing=0.885, fibre_radius=0.044)
        == (NAMED_STITCHES["paper-fit"])
    )


@pytest.mark.parametrize("name", NAMED_STITCHES)
def test_neighbour_gap_is_what_a_search_for_the_widest_spot_finds(name: str) -> None:
    a = NAMED_STITCHES[name].curvature
    widest = minimize_scalar(lambda t: -(t + a * np.sin(2.0 * t)), bounds=(0.0, np.pi / 2.0), method="bounded")
    half_width = -widest.fun / (2.0 * np.pi)
    assert neighbour_gap(NAMED_STITCHES[name]) == pytest.approx(1.0 - 2.0 * half_width, abs=1e-9)


def test_a_stitch_without_neck_has_half_a_loop_of_gap() -> None:
    assert neighbour_gap(replace(DEFAULT, curvature=0.4)) == pytest.approx(0.5)


def test_locking_strain_is_the_published_fit_worked_by_hand() -> None:
    # 1.005 * 4.777 = 4.800885; 0.5835 + 0.269 - 0 - 0.075 = 0.7775; / 2.72
    assert locking_strain(DEFAULT, 4.777) == pytest.approx(4.023385 / 2.72 - 1.0, rel=1e-12)


def test_a_more_curved_loop_of_equal_yarn_locks_later() -> None:
    assert locking_strain(replace(DEFAULT, curvature=1.6), 4.777) - locking_strain(DEFAULT, 4.777) == pytest.approx(
        0.0179 / 2.72
    )

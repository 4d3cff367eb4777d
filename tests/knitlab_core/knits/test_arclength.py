from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from knitlab_core.knits import NAMED_STITCHES, Stitch, yarn_per_loop
from knitlab_core.knits.arclength import arc_table, tightest_bend
from knitlab_core.knits.pieces import Row

EXTREME = Stitch(curvature=0.5, height=0.01, depth=10.0, row_spacing=1.0, fibre_radius=1e-4)
STITCHES = [*NAMED_STITCHES.values(), EXTREME]


def speed(t: float, stitch: Stitch) -> float:
    a, h, d = stitch.curvature, stitch.height, stitch.depth
    course = (1.0 + 2.0 * a * np.cos(2.0 * t)) / (2.0 * np.pi)
    return float(np.sqrt(course**2 + (h * np.sin(t)) ** 2 + (2.0 * d * np.sin(2.0 * t)) ** 2))


@pytest.mark.parametrize("stitch", STITCHES)
@pytest.mark.parametrize("t", [0.3, 1.5, 3.0, 4.7, 6.2])
def test_arc_length_agrees_with_adaptive_quadrature_to_ten_digits(stitch: Stitch, t: float) -> None:
    breaks = [*np.arange(0.0, t, np.pi / 4.0), t]
    parts = [quad(speed, low, high, args=(stitch,), epsabs=0.0, epsrel=1e-11)[0] for low, high in pairwise(breaks)]
    expected = sum(parts)
    assert arc_table(stitch).arc_length(np.array([t]))[0] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("stitch", STITCHES)
def test_the_parameter_is_the_inverse_of_the_arc_length(stitch: Stitch) -> None:
    table = arc_table(stitch)
    s = np.linspace(0.0, 5.0 * table.loop_length, 1234)
    assert table.arc_length(table.parameter(s)) == pytest.approx(s, rel=1e-10, abs=1e-11 * table.loop_length)


# Three decimals as the design notes print them; plain-knit is 3.9275, printed as 3.927.
@pytest.mark.parametrize(
    ("name", "length"), [("stockinette-default", 4.777), ("plain-knit", 3.927), ("G_B", 5.417), ("paper-fit", 4.252)]
)
def test_yarn_per_loop_is_the_design_s_and_leaves_turn_arounds_out(name: str, length: float) -> None:
    assert yarn_per_loop(NAMED_STITCHES[name]) == pytest.approx(length, abs=6e-4)


def test_the_bend_at_a_head_is_the_closed_form() -> None:
    stitch = NAMED_STITCHES["stockinette-default"]
    # At t = 0: gamma' along x, gamma'' across it.
    expected = np.hypot(stitch.height, 4.0 * stitch.depth) / ((1.0 + 2.0 * stitch.curvature) / (2.0 * np.pi)) ** 2
    assert tightest_bend(stitch) == pytest.approx((expected, 0.0))


@pytest.mark.parametrize("name", NAMED_STITCHES)
def test_the_tightest_bend_bounds_the_curvature_along_the_row(name: str) -> None:
    row = Row(stitch=NAMED_STITCHES[name], row=0, loops=1)
    along = np.linalg.norm(row.curvature(np.linspace(0.0, row.length, 20001)), axis=-1)
    assert along.max() == pytest.approx(tightest_bend(NAMED_STITCHES[name])[0], rel=1e-5)

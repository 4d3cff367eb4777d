import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Site, planar_line, yarn_per_loop
from knitlab_core.knits.pieces import Row, Turn

DEFAULT = NAMED_STITCHES["stockinette-default"]
ROWS, LOOPS = 4, 3
KNIT = planar_line(DEFAULT, rows=ROWS, loops=LOOPS)


def equation_one(t: np.ndarray, row: int) -> np.ndarray:
    a, h, d, w = DEFAULT.curvature, DEFAULT.height, DEFAULT.depth, DEFAULT.row_spacing
    course = (t + a * np.sin(2.0 * t)) / (2.0 * np.pi)
    return np.stack([course, h * np.cos(t) + row * w, d * np.cos(2.0 * t)], axis=-1)


def at(sites: list[Site]) -> np.ndarray:
    return KNIT.position(np.array([site.arc_length for site in sites]))


def sites_of(edge: str) -> list[Site]:
    return [site for site in KNIT.sites if site.set == edge]


def test_the_yarn_is_its_rows_and_its_turn_arounds() -> None:
    assert [type(piece) for piece in KNIT.pieces] == [Row, Turn, Row, Turn, Row, Turn, Row]
    turns = (ROWS - 1) * np.pi * DEFAULT.row_spacing / 2.0
    assert KNIT.length == pytest.approx(ROWS * LOOPS * yarn_per_loop(DEFAULT) + turns, rel=1e-12)


@pytest.mark.parametrize("row", range(ROWS))
def test_a_row_lies_on_equation_one(row: int) -> None:
    piece = Row(stitch=DEFAULT, row=row, loops=LOOPS)
    t = np.linspace(-np.pi, (2 * LOOPS - 1) * np.pi, 501)
    assert piece.position(piece.arc_length(t)) == pytest.approx(equation_one(t, row), abs=1e-11)


def test_odd_rows_run_back() -> None:
    middles = KNIT.starts[:-1] + 0.5 * np.diff(KNIT.starts)
    assert np.sign(KNIT.tangent(middles[::2])[:, 0]) == pytest.approx([1, -1, 1, -1])


@pytest.mark.parametrize("joint", range(1, 2 * ROWS - 1))
def test_pieces_meet_with_position_and_tangent(joint: int) -> None:
    before, after = KNIT.pieces[joint - 1], KNIT.pieces[joint]
    end, start = np.array([before.length]), np.zeros(1)
    assert before.position(end) == pytest.approx(after.position(start), abs=1e-12)
    assert before.tangent(end) == pytest.approx(after.tangent(start), abs=1e-12)


def test_a_turn_around_is_a_semicircle_outside_the_knit_in_the_plane_of_the_feet() -> None:
    s = np.linspace(KNIT.starts[1], KNIT.starts[2], 101)
    points = KNIT.position(s)
    centre = [LOOPS - 0.5, -DEFAULT.height + 0.5 * DEFAULT.row_spacing, DEFAULT.depth]
    assert np.linalg.norm(points - centre, axis=-1) == pytest.approx(np.full(101, 0.5 * DEFAULT.row_spacing))
    assert points[:, 2] == pytest.approx(np.full(101, DEFAULT.depth))
    assert points[:, 0].min() >= LOOPS - 0.5 - 1e-12


def test_wale_sites_are_at_the_hook_angle_about_heads_and_sinkers() -> None:
    heads = np.array([2.0 * np.pi * loop + sign * 0.35 for loop in range(LOOPS) for sign in (-1, 1)])
    sinkers = np.array([2.0 * np.pi * loop + sign * (np.pi - 0.35) for loop in range(LOOPS) for sign in (-1, 1)])
    assert at(sites_of("wale+")) == pytest.approx(equation_one(heads, ROWS - 1), abs=1e-11)
    assert at(sites_of("wale-")) == pytest.approx(equation_one(sinkers, 0), abs=1e-11)
    assert [site.loop for site in sites_of("wale-")] == [0, 0, 1, 1, 2, 2]


def test_course_sites_are_where_turn_arounds_and_the_yarn_begin_and_end() -> None:
    arcs = sorted(site.arc_length for edge in ("course+", "course-") for site in sites_of(edge))
    assert arcs == pytest.approx(KNIT.starts, abs=1e-11)
    for edge, x in (("course+", LOOPS - 0.5), ("course-", -0.5)):
        assert [site.row for site in sites_of(edge)] == list(range(ROWS))
        assert at(sites_of(edge))[:, 0] == pytest.approx(np.full(ROWS, x), abs=1e-11)


def test_points_come_back_in_the_order_they_were_asked_for() -> None:
    s = np.array([KNIT.length, 0.0, 20.0, 3.0])
    assert KNIT.position(s)[::-1] == pytest.approx(KNIT.position(s[::-1]))
    assert KNIT.position(np.array([])).shape == (0, 3)


@pytest.mark.parametrize("s", [-0.1, 1e6, np.nan])
def test_a_spot_off_the_yarn_is_refused(s: float) -> None:
    with pytest.raises(SpecificationError, match="arc_length"):
        KNIT.position(np.array([1.0, s]))


@pytest.mark.parametrize("count", [0, -1, 201, 2.0, True, None])
@pytest.mark.parametrize("field", ["rows", "loops"])
def test_counts_are_bounded_whole_numbers(field: str, count: int) -> None:
    with pytest.raises(SpecificationError) as caught:
        planar_line(DEFAULT, **{"rows": 2, "loops": 2, field: count})
    assert caught.value.field == f"specimen.{field}"

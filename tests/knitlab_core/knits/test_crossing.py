"""Passages of a curve through the surface between a loop's legs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.knits import Stitch
from knitlab_core.knits.crossing import crossing_number
from knitlab_core.knits.pieces import Row
from knitlab_core.knits.planar import stitch_clasp
from tests.linking import linking_number

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray


def arch(corners: int, *, height: float = 2.0) -> FloatArray:
    """Return an arch in the x-y plane, its feet at y = 0 and x = -1 and 1, its normal along -z."""
    angle = np.linspace(np.pi, 0.0, corners)
    return np.column_stack([np.cos(angle), height * np.sin(angle), 0.0 * angle])


def needle(x: float, y: float) -> FloatArray:
    """Return a straight polygon through the x-y plane along +z."""
    return np.array([[x, y, -1.0], [x, y, -0.3], [x, y, 0.4], [x, y, 1.0]])


@pytest.mark.parametrize("corners", [3, 4, 5, 30, 31])
@pytest.mark.parametrize("x", [-0.3, 0.0, 0.123])
def test_a_needle_through_the_loop_is_one_passage_against_its_normal(corners: int, x: float) -> None:
    assert crossing_number(arch(corners), needle(x, 0.4)) == -1
    assert crossing_number(arch(corners)[::-1], needle(x, 0.4)) == 1
    assert crossing_number(arch(corners), needle(x, 0.4)[::-1]) == 1


@pytest.mark.parametrize(("x", "y"), [(0.0, 2.1), (1.2, 0.4), (-1.2, 0.4), (0.0, -0.1)])
def test_a_needle_outside_the_loop_or_past_its_feet_is_none(x: float, y: float) -> None:
    assert crossing_number(arch(30), needle(x, y)) == 0


@pytest.mark.parametrize("corners", [8, 9])
def test_a_needle_through_rungs_and_diagonals_is_counted_once(corners: int) -> None:
    loop = arch(corners)
    for k in range(1, len(loop) // 2 - 1):
        for a, b in ((loop[k], loop[-1 - k]), (loop[k], loop[-k])):
            for share in (0.25, 0.5):
                x, y, _ = a + share * (b - a)
                assert crossing_number(loop, needle(x, y)) == -1
    # A corner of the needle in the surface itself is one passage too.
    through = needle(0.1, 0.5)
    through[1, 2] = 0.0
    assert crossing_number(loop, through) == -1


def test_there_and_back_is_none_and_round_about_is_twice() -> None:
    loop = arch(30)
    there = needle(0.1, 0.5)
    assert crossing_number(loop, np.concatenate([there, needle(0.2, 0.6)[::-1]])) == 0
    outside = np.array([[3.0, 0.0, 1.0], [3.0, 0.0, -1.0]])
    assert crossing_number(loop, np.concatenate([there, outside, there])) == -2


@settings(max_examples=30, deadline=None)
@given(stretch=st.floats(0.2, 8.0), turn=st.floats(-3.0, 3.0), lean=st.floats(-2.0, 2.0))
def test_no_bend_turn_or_stretch_of_both_changes_the_number(stretch: float, turn: float, lean: float) -> None:
    def moved(x: FloatArray) -> FloatArray:
        # Twisted about the wale by `turn` a unit, leaning out of plane, drawn out: none brings strands through others.
        angle = turn * x[:, 1]
        c, s = np.cos(angle), np.sin(angle)
        y = np.column_stack([c * x[:, 0] - s * x[:, 2], x[:, 1], s * x[:, 0] + c * x[:, 2]])
        y[:, 2] += lean * y[:, 1] ** 2
        return y * [1.0, stretch, 1.0]

    fine = np.column_stack([np.full(20, 0.2), np.full(20, 1.0), np.linspace(-0.5, 0.5, 20)])
    assert crossing_number(moved(arch(60)), moved(fine)) == -1


@settings(max_examples=40, deadline=None)
@given(
    curvature=st.floats(0.1, 3.0),
    height=st.floats(0.1, 3.0),
    depth=st.floats(0.02, 1.0),
    row_spacing=st.floats(0.1, 3.0),
)
def test_printed_heads_hold_where_closed_far_away_they_are_linked(
    curvature: float, height: float, depth: float, row_spacing: float
) -> None:
    stitch = Stitch(curvature=curvature, height=height, depth=depth, row_spacing=row_spacing, fibre_radius=0.01)
    head, held = (
        row.position(row.arc_length(np.linspace(*span, 65)))
        for row, span in (
            (Row(stitch=stitch, row=0, loops=2), (-np.pi, np.pi)),
            (Row(stitch=stitch, row=1, loops=2), (0.0, 2.0 * np.pi)),
        )
    )
    far = np.array([0.0, 100.0, 0.0])
    closed = [np.concatenate([arc, [arc[-1] + way, arc[0] + way]]) for arc, way in ((head, -far), (held, far))]
    assert stitch_clasp(stitch) == round(linking_number(*closed))

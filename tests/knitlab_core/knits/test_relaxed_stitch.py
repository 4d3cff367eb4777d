"""Stockinette of relaxed loops: of a cell that is as drawn it is the stitch that was drawn."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.knits import (
    BoundEdges,
    Counts,
    RelaxedStitch,
    clasp_numbers,
    knit_cell,
    knit_specimen,
    relaxed_stitch,
)
from knitlab_core.knits.stitch import NAMED_STITCHES

PLAIN = NAMED_STITCHES["stockinette-default"]
COUNTS = Counts(3, 4)
WIDTH = 8e-3


def as_drawn(scale: tuple[float, float] = (1.0, 1.0)) -> tuple[RelaxedStitch, float]:
    """Return the stitch of a cell as drawn, stretched by two factors."""
    cell = knit_cell(PLAIN, rows=2, loops=2, loop_width=WIDTH, nodes_per_loop=96)
    assert cell.cell is not None
    stretch = np.array([*scale, 1.0])
    return relaxed_stitch(PLAIN, cell.nodes * stretch, cell.cell.vectors * stretch, cell.counts, cell.radius)


def test_a_cell_that_did_not_move_gives_the_stitch_that_was_drawn() -> None:
    stitch, width = as_drawn()
    assert width == pytest.approx(WIDTH)
    for name in ("height", "depth", "row_spacing", "fibre_radius", "front"):
        assert getattr(stitch, name) == pytest.approx(getattr(PLAIN, name), abs=2e-5), name
    line, drawn = stitch.centreline(COUNTS), PLAIN.centreline(COUNTS)
    assert line.length == pytest.approx(drawn.length, rel=1e-5)
    share = np.linspace(0.0, 1.0, 500)
    apart = line.position(share * line.length) - drawn.position(share * drawn.length)
    assert np.abs(apart).max() < 2e-4
    along = (line.tangent(share * line.length) * drawn.tangent(share * drawn.length)).sum(axis=1)
    assert along.min() > 1.0 - 1e-5
    assert np.array_equal(stitch.middle(COUNTS), PLAIN.middle(COUNTS))
    clear = stitch.clearance(line, COUNTS, loop_width=WIDTH)
    assert clear == pytest.approx(PLAIN.clearance(drawn, COUNTS, loop_width=WIDTH), abs=1e-3)


def test_a_cell_that_grew_gives_its_pitch_and_keeps_its_rows_together() -> None:
    stitch, width = as_drawn((1.2, 1.1))
    assert width == pytest.approx(1.2 * WIDTH)
    assert stitch.row_spacing * width == pytest.approx(1.1 * PLAIN.row_spacing * WIDTH)
    specimen = knit_specimen(stitch, loop_width=width, rows=3, loops=4, nodes_per_loop=24)
    assert (np.abs(clasp_numbers(specimen, specimen.nodes)) == 1).all()
    at = specimen.centreline.position(np.array([site.arc_length for site in specimen.centreline.sites]))
    course = np.array([site.set == "course+" for site in specimen.centreline.sites])
    assert at[course, 0] == pytest.approx(np.full(3, 3.5), abs=1e-6)


def test_strands_that_press_on_each_other_are_no_fault() -> None:
    cell = knit_cell(PLAIN, rows=2, loops=2, loop_width=WIDTH, nodes_per_loop=32, contact_radius=1e-3)
    assert cell.cell is not None
    stitch, width = relaxed_stitch(PLAIN, cell.nodes, cell.cell.vectors, cell.counts, cell.radius)
    specimen = knit_specimen(stitch, loop_width=width, rows=4, loops=4, nodes_per_loop=16)
    assert specimen.radius == pytest.approx(1e-3)
    assert specimen.clearance == pytest.approx(cell.clearance, abs=2e-5)


def test_its_rows_can_be_bound_off_and_cast_on() -> None:
    stitch, width = as_drawn()
    bound = BoundEdges(knit=stitch, top=True, bottom=True)
    specimen = knit_specimen(bound, loop_width=width, rows=3, loops=3, nodes_per_loop=16)
    assert (np.abs(clasp_numbers(specimen, specimen.nodes)) == 1).all()
    below, above = (
        bound.chained(np.array([0.0, 0.5 * specimen.centreline.length, specimen.centreline.length]), specimen.counts)[k]
        for k in (0, 2)
    )
    assert below
    assert above

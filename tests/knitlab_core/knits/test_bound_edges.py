"""Chained edges: who passes through whom, clear of each other, and everything of the knit where it was."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import BoundEdges, Counts, Pin, fabric_named, knit_specimen
from knitlab_core.knits.chain import Chain
from knitlab_core.knits.clasp import clasp_nodes, clasp_place, clasps_hold, parted_at
from knitlab_core.knits.crossing import crossing_number
from knitlab_core.knits.stitch import NAMED_STITCHES, Stitch

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

PLAIN = NAMED_STITCHES["stockinette-default"]
BOTH = BoundEdges(knit=PLAIN, top=True, bottom=True)


def chains(counts: Counts) -> tuple[Chain, Chain]:
    """Return the chains below and above a knit."""
    first, *_, last = BOTH.centreline(counts).pieces
    assert isinstance(first, Chain)
    assert isinstance(last, Chain)
    return first, last


@pytest.mark.parametrize("counts", [Counts(2, 2), Counts(3, 4), Counts(4, 3)])
@pytest.mark.parametrize("nodes", [16, 48])
@pytest.mark.parametrize("slack", [0.0, 0.1])
def test_every_loop_of_an_edge_and_every_loop_of_its_chain_holds_one(counts: Counts, nodes: int, slack: float) -> None:
    specimen = knit_specimen(
        replace(BOTH, slack=slack), loop_width=8e-3, rows=counts.rows, loops=counts.loops, nodes_per_loop=nodes
    )
    hold = clasps_hold(specimen.nodes, clasp_nodes(specimen))
    assert hold["rows"].shape == (counts.rows - 1, counts.loops)
    assert hold["bound_off"].shape == (2 * counts.loops - 1,)
    # Between the first row's loops is one sinker fewer.
    assert hold["cast_on"].shape == (2 * counts.loops - 3,)
    assert all(held.all() for held in hold.values())


@pytest.mark.parametrize("name", ["stockinette-default", "plain-knit", "G_B"])
@pytest.mark.parametrize("slack", [0.0, 0.1, 0.3])
def test_strands_of_an_edge_are_clear_of_all_others(name: str, slack: float) -> None:
    knit = fabric_named(name)
    assert isinstance(knit, Stitch)
    counts = Counts(3, 3)
    fabric = BoundEdges(knit=knit, top=True, bottom=True, slack=slack)
    clear = fabric.clearance(fabric.centreline(counts), counts, loop_width=8e-3)
    assert 0.02 < clear <= knit.clearance(knit.centreline(counts), counts, loop_width=8e-3)


@pytest.mark.parametrize("slack", [0.05, 0.2])
def test_a_slack_chain_has_so_much_more_yarn_in_each_stitch(slack: float) -> None:
    counts = Counts(2, 4)

    def stitches(fabric: BoundEdges) -> FloatArray:
        first, *_, last = fabric.centreline(counts).pieces
        assert isinstance(first, Chain)
        assert isinstance(last, Chain)
        return np.array([np.abs(np.diff(chain.marks[:, 0])).mean() for chain in (first, last)])

    ratio = stitches(replace(BOTH, slack=slack)) / stitches(BOTH)
    assert ratio == pytest.approx(1.0 + slack, rel=1e-3)


def test_a_chain_wider_than_it_can_be_is_refused() -> None:
    with pytest.raises(SpecificationError, match=r"edges\.slack: found '0\.6', allowed from 0 to \d+%"):
        replace(BOTH, slack=0.6).centreline(Counts(2, 2))


def test_a_yarn_too_thick_for_the_chain_is_refused_with_the_distance_it_has() -> None:
    thick = Stitch(curvature=1.5, height=0.8, depth=0.25, row_spacing=0.86, fibre_radius=0.09)
    knit_specimen(thick, loop_width=8e-3, rows=2, loops=2)
    with pytest.raises(
        GeometryError, match=r"edges: found 'strands of a bound edge 1\.\d+ mm apart', allowed .* 1.44 mm"
    ):
        knit_specimen(BoundEdges(knit=thick, top=True, bottom=False), loop_width=8e-3, rows=2, loops=2)


def test_one_yarn_goes_on_from_the_cast_on_through_the_rows_to_the_bound_off_edge() -> None:
    line = BOTH.centreline(Counts(3, 4))
    for start, piece, after in zip(line.starts[1:-1], line.pieces[:-1], line.pieces[1:], strict=True):
        end, begin = piece.position(np.array([piece.length])), after.position(np.zeros(1))
        assert end == pytest.approx(begin, abs=1e-9), line.place(start)
        along, on = piece.tangent(np.array([piece.length])), after.tangent(np.zeros(1))
        # A chain's curve begins with the tangent of a quartic through points of its half circle.
        assert float((along * on).sum()) > 0.999, line.place(start)


@pytest.mark.parametrize("edge", [0, 1])
def test_the_end_of_the_yarn_is_drawn_through_the_last_loop_and_ends_there(edge: int) -> None:
    chain = chains(Counts(3, 4))[edge]
    (_, first, _, last), (begin, _, end, _) = chain.marks[-2], chain.marks[-1]
    loop, tail = (chain.position(np.linspace(*span, 400)) for span in ((first, last), (begin, end)))
    assert abs(crossing_number(loop, tail)) == 1
    assert end == pytest.approx((chain.length, 0.0)[1 - edge])


def test_a_chain_follows_the_edge_whichever_way_its_row_ran() -> None:
    for rows in (2, 3):
        _, above = chains(Counts(rows, 4))
        heads = above.position(above.marks[:-1, 2])[:, 0]
        assert np.diff(heads) == pytest.approx(np.full(3, 1.0 if rows % 2 == 0 else -1.0))


def test_sites_pins_and_jaws_are_those_of_the_knit() -> None:
    counts, pin = Counts(4, 3), Pin(row=2, loop=1)
    plain, bound = PLAIN.centreline(counts), BOTH.centreline(counts)
    for one, other in zip(plain.sites, bound.sites, strict=True):
        places = (line.position(np.array([site.arc_length])) for line, site in ((plain, one), (bound, other)))
        assert next(places) == pytest.approx(next(places))
        assert (one.set, one.row, one.loop) == (other.set, other.row, other.loop)
    legs = [fabric.leg(line, counts, pin) for fabric, line in ((PLAIN, plain), (BOTH, bound))]
    first, second = (
        line.position(np.array([leg])) for line, leg in zip((plain, bound), legs, strict=True) if leg is not None
    )
    assert first == pytest.approx(second)
    assert BOTH.clamp_faces(counts) == PLAIN.clamp_faces(counts)
    assert np.array_equal(BOTH.middle(counts), PLAIN.middle(counts))


def test_each_edge_is_chained_by_itself() -> None:
    counts = Counts(3, 3)
    whole = BOTH.centreline(counts).length - PLAIN.centreline(counts).length
    one = [
        BoundEdges(knit=PLAIN, top=top, bottom=not top).centreline(counts).length - PLAIN.centreline(counts).length
        for top in (False, True)
    ]
    assert sum(one) == pytest.approx(whole)
    assert set(BoundEdges(knit=PLAIN, top=True, bottom=False).clasps(BOTH.centreline(counts), counts)) == {
        "rows",
        "bound_off",
    }


def test_places_of_an_edge_are_named() -> None:
    below, above = chains(Counts(3, 4))
    assert above.place(float(above.marks[2, 2])) == "bound-off edge, stitch 2"
    assert below.place(float(below.marks[1, 2])) == "cast-on edge, stitch 1"
    assert clasp_place("bound_off", (4,)) == "clasp 4 of the bound-off edge"
    loose = {"rows": np.ones((2, 3), dtype=bool), "bound_off": np.zeros(5, dtype=bool)}
    assert parted_at(loose) == ""


def test_the_clearance_is_the_least_distance_of_the_whole_yarn() -> None:
    counts = Counts(2, 3)
    line = BOTH.centreline(counts)
    s = np.linspace(0.0, line.length, 1500)
    points = line.position(s)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    near = np.abs(s[:, None] - s[None]) < 0.6
    found = BOTH.clearance(line, counts, loop_width=1.0) + 2.0 * PLAIN.fibre_radius
    assert found == pytest.approx(apart[~near].min(), abs=1e-2)

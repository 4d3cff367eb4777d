"""Fabric of a user's own centreline."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import (
    NAMED_STITCHES,
    Counts,
    OwnCentreline,
    Specimen,
    clasp_numbers,
    knit_specimen,
    wires_through,
)
from knitlab_core.knits.curve import curve_through

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray

STITCH = NAMED_STITCHES["stockinette-default"]
COUNTS = Counts(rows=2, loops=2)


@cache
def traced(per_edge: int) -> tuple[Specimen, OwnCentreline]:
    """Return a stockinette of 2x2 loops, and its yarn as so many points an edge, its nodes and sites among them."""
    knit = knit_specimen(STITCH, rows=2, loops=2, loop_width=1.0, nodes_per_loop=14)
    along = knit.arc_lengths
    arcs = np.append(np.linspace(along[:-1], along[1:], per_edge, endpoint=False).T.ravel(), along[-1])
    at = {int(np.abs(arcs - site.arc_length).argmin()): site.set for site in knit.centreline.sites}
    points = tuple((x, y, z) for x, y, z in knit.centreline.position(arcs).tolist())
    return knit, OwnCentreline(points=points, sites=tuple(at.items()), fibre_radius=STITCH.fibre_radius)


def test_a_traced_stockinette_has_its_nodes_sites_clearance_and_length() -> None:
    knit, own = traced(40)
    found = knit_specimen(own, rows=2, loops=2, loop_width=1.0, nodes_per_loop=15)
    centred, wanted = (nodes - nodes.mean(axis=0) for nodes in (found.nodes, knit.nodes))
    np.testing.assert_allclose(centred, wanted, atol=1e-6)
    assert own.axes == ("C", "W")
    for edge, nodes in knit.sites.items():
        assert found.sites[edge].tolist() == nodes.tolist()
    assert found.clearance == pytest.approx(knit.clearance, rel=1e-6)
    assert found.yarn_length == pytest.approx(knit.yarn_length, rel=1e-6)


def helix(count: int) -> tuple[FloatArray, float, float]:
    """Return points on a helix of radius 1 and pitch pi, its arc length and its curvature."""
    t = np.linspace(0.0, 3.0, count) ** 1.1
    speed = np.hypot(1.0, 0.5)
    return np.stack([np.cos(t), np.sin(t), 0.5 * t], axis=-1), speed * float(t[-1]), 1.0 / speed**2


def test_the_curve_through_points_of_a_helix_has_its_length_tangents_and_curvature() -> None:
    points, length, bend = helix(200)
    curve = curve_through(tuple((x, y, z) for x, y, z in points.tolist()))
    assert curve.length == pytest.approx(length, rel=1e-9)
    s = np.linspace(0.0, curve.length, 997)
    np.testing.assert_allclose(np.hypot(*curve.position(s)[:, :2].T), 1.0, atol=1e-8)
    np.testing.assert_allclose(np.gradient(curve.position(s), s, axis=0)[1:-1], curve.tangent(s)[1:-1], atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(curve.curvature(s), axis=1), bend, rtol=5e-3)


def test_the_error_of_the_curve_is_of_fourth_order() -> None:
    off = []
    for count in (41, 81):
        points, _, _ = helix(count)
        curve = curve_through(tuple((x, y, z) for x, y, z in points.tolist()))
        # The ends have one-sided tangents.
        s = np.linspace(0.2, 0.8, 1001) * curve.length
        off.append(float(np.abs(np.hypot(*curve.position(s)[:, :2].T) - 1.0).max()))
    assert 10.0 < off[0] / off[1] < 24.0


def test_ends_that_are_no_sites_become_nodes_too() -> None:
    _, own = traced(8)
    inner = replace(own, sites=tuple((number, face) for number, face in own.sites if face.startswith("wale")))
    found = knit_specimen(inner, rows=2, loops=2, loop_width=1.0, nodes_per_loop=15)
    np.testing.assert_allclose(found.nodes[[0, -1]], np.array(own.points)[[0, -1]] - inner.middle(COUNTS), atol=1e-12)


def test_what_is_not_known_of_it_is_said() -> None:
    _, own = traced(8)
    found = knit_specimen(own, rows=2, loops=2, loop_width=1.0, nodes_per_loop=15)
    assert clasp_numbers(found, found.nodes).shape == (0, 2)
    assert own.budgets(own.fibre_radius) == {}
    with pytest.raises(SpecificationError, match="wire in a fabric whose loops are not known"):
        wires_through(found, "wale+")


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"points": ((0.0, 0.0, 0.0),) * 9}, "points 1 and 2 in one place"),
        ({"points": ((0.0, 0.0, 0.0),) * 3}, "3 points"),
        ({"points": tuple((float(k), np.nan, 0.0) for k in range(9))}, "point 1 at"),
        ({"sites": ((0, "course-"),)}, r"no site course\+"),
        ({"sites": ()}, "no sites"),
        ({"sites": ((0, "course-"), (0, "course+"))}, "sites that are no points"),
        ({"sites": ((0, "course-"), (4, "top"))}, "site top"),
        ({"fibre_radius": 0.0}, "fibre_radius"),
    ],
)
def test_nonsense_is_refused(change: dict[str, object], match: str) -> None:
    _, own = traced(8)
    with pytest.raises(SpecificationError, match=match):
        replace(own, **change)  # type: ignore[arg-type]


def test_strands_that_overlap_are_named_by_their_points() -> None:
    _, own = traced(8)
    with pytest.raises(GeometryError, match=r"specimen.knit: found .yarns .* apart at points \d+ to \d+"):
        knit_specimen(replace(own, fibre_radius=0.13), rows=2, loops=2, loop_width=1.0, nodes_per_loop=15)


def test_a_yarn_that_nowhere_comes_back_to_itself_can_be_mounted() -> None:
    x = np.linspace(-1.0, 1.0, 17)
    points = tuple(zip(x.tolist(), (0.19 * np.sin(2.0 * np.pi * x)).tolist(), (0.0 * x).tolist(), strict=True))
    wave = OwnCentreline(points=points, sites=((0, "course-"), (16, "course+")), fibre_radius=0.05)
    found = knit_specimen(wave, rows=1, loops=1, loop_width=1.0, nodes_per_loop=16)
    s = np.linspace(0.0, found.centreline.length, 3000)
    half_turn = np.pi / np.linalg.norm(found.centreline.curvature(s), axis=-1).max()
    points_at = found.centreline.position(s)
    apart = np.linalg.norm(points_at[:, None] - points_at[None], axis=-1)
    least = apart[s[None] - s[:, None] >= half_turn].min()
    # Beyond half a turn of its tightest bend the yarn only leaves itself; samples are an eighth of that bend apart.
    assert least - 1e-9 <= found.clearance + 2.0 * 0.05 <= least * 1.2

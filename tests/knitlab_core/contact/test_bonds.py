from math import inf, nan, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.contact.bonds import Bonds
from knitlab_core.equilibrium.model import make_model
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, knit_specimen
from tests.contact_scenes import POISSON_RATIO, straight

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray


def bonds_of(
    strands: "Sequence[FloatArray]", gap: float, *, patch: float = 0.3, radius: float = 1.0, modulus: float = 1.0
) -> Bonds:
    law = BondLaw(fuse_gap=gap * radius, patch_radius=patch * radius, strength=0.03 * modulus)
    strands = [radius * strand for strand in strands]
    model, state = make_model(
        strands, radius=radius, young_modulus=modulus, poisson_ratio=POISSON_RATIO, friction=0.0, bonds=law
    )
    assert model.bonds is not None
    assert state.bonds.whole.all()
    assert state.bonds.whole.size == model.bonds.a.size
    return model.bonds


def crossed(gap: float, edge: float = 2.0, angle: float = pi / 2, shift: float = 0.0) -> "list[FloatArray]":
    lower = straight((0, 0, 0), (1, 0, 0), 16.0, edge)
    return [lower, straight((shift, 0, 2.0 + gap), (np.cos(angle), np.sin(angle), 0), 16.0, edge)]


@pytest.mark.parametrize("field", ["fuse_gap", "patch_radius", "strength", "shear_strength", "locate"])
@pytest.mark.parametrize("value", [0.0, -1.0, inf, nan])
def test_a_law_refuses_what_no_bond_can_have(field: str, value: float) -> None:
    given: dict[str, Any] = {"fuse_gap": 1e-5, "patch_radius": 1e-5, "strength": 1e7, field: value}
    with pytest.raises(SpecificationError, match=rf"bonds\.{field}"):
        BondLaw(**given)


@pytest.mark.parametrize("edge", [1.0, 2.0, 2.5])
@pytest.mark.parametrize("angle", [pi / 2, 0.6])
@pytest.mark.parametrize("shift", [0.0, 0.07, 1.0])
def test_a_crossing_is_one_bond_where_the_strands_are_closest(edge: float, angle: float, shift: float) -> None:
    bonds = bonds_of(crossed(0.3, edge, angle, shift), 0.5)
    assert bonds.a.size == 1
    assert np.linalg.norm(bonds.arms[0, 0]) == pytest.approx(2.3, abs=0.02)


def test_strands_printed_farther_apart_than_the_gap_are_not_fused() -> None:
    assert bonds_of(crossed(0.3), 0.29).a.size == 0
    assert bonds_of(crossed(0.3), 0.31).a.size == 1


def test_a_strand_is_not_fused_with_its_own_course() -> None:
    assert bonds_of([straight((0, 0, 0), (1, 0, 0), 30.0)], 4.0).a.size == 0


def test_strands_side_by_side_are_fused_patch_by_patch() -> None:
    side = [straight((0, y, 0), (1, 0, 0), 20.0) for y in (0.0, 2.2)]
    bonds = bonds_of(side, 0.3, patch=2.0)
    # 18 r of smooth centreline (less half an edge at each end), patches 4 r wide.
    assert bonds.a.size == 5
    np.testing.assert_allclose(np.linalg.norm(bonds.arms[:, 0], axis=1), 2.2)


def test_stiffness_is_that_of_a_neck_between_two_half_spaces() -> None:
    compliance = (1.0 - POISSON_RATIO**2) / 0.3
    for gap in (0.05, 0.3, 2.0):
        bonds = bonds_of(crossed(gap), gap + 0.1)
        own = np.linalg.norm(bonds.arms[0, 0]) - 2.0
        assert bonds.stiffness[0] == pytest.approx(1.0 / (compliance + own / (pi * 0.3**2)), rel=1e-12)


def test_arms_across_are_as_long_as_the_neck_is_wide() -> None:
    arms = bonds_of(crossed(0.3, angle=0.6), 0.5).arms[0]
    inner = arms @ arms.T
    np.testing.assert_allclose(inner, np.diag([inner[0, 0], 0.09, 0.09]), atol=1e-14)


def test_bonds_scale_with_the_specimen_and_its_modulus() -> None:
    one, other = bonds_of(crossed(0.3), 0.5), bonds_of(crossed(0.3), 0.5, radius=1e-3, modulus=3e9)
    np.testing.assert_allclose(other.arms, one.arms, rtol=1e-9)
    np.testing.assert_allclose(other.stiffness, one.stiffness, rtol=1e-9)
    assert other.strength == pytest.approx(one.strength)
    assert one.shear_strength == pytest.approx(one.strength / sqrt(3.0))


def closest_points(centreline: "FloatArray", gap: float) -> int:
    """Count the local minima of the distance between samples (n, 3) of a yarn, every pair looked at, ties once."""
    apart = np.linalg.norm(centreline[:, None] - centreline[None], axis=2)
    inside = apart[1:-1, 1:-1]
    lowest = inside < 2.0 + gap
    for i in (0, 1, 2):
        for j in (0, 1, 2):
            beside = apart[i : i + inside.shape[0], j : j + inside.shape[1]]
            if (i, j) < (1, 1):
                lowest &= inside < beside
            else:
                lowest &= inside <= beside
    return int(np.count_nonzero(np.triu(lowest, 4)))


@pytest.mark.parametrize("gap", [2.75, 3.5])
def test_a_knit_has_a_bond_for_every_crossing(gap: float) -> None:
    stitch = NAMED_STITCHES["stockinette-default"]
    count: dict[tuple[int, int], int] = {}
    for rows, loops in ((2, 2), (2, 3), (3, 2), (3, 3), (6, 6)):
        specimen = knit_specimen(stitch, rows=rows, loops=loops, loop_width=8e-3, nodes_per_loop=48)
        nodes = specimen.nodes / specimen.radius
        found = bonds_of([nodes], gap)
        if rows < 6:
            # Nodes of the printed yarn, four times as dense: what the bonds' samples do not know of.
            fine = knit_specimen(stitch, rows=rows, loops=loops, loop_width=8e-3, nodes_per_loop=251)
            count[rows, loops] = closest_points(fine.nodes / fine.radius, gap)
            assert found.a.size == count[rows, loops]
    # Crossings are so many a loop, a row, a column and an edge: what small knits have tells the large one's.
    more_loops = count[2, 3] - count[2, 2]
    more_rows = count[3, 2] - count[2, 2]
    more_both = count[3, 3] - count[3, 2] - more_loops
    assert found.a.size == count[2, 2] + 4 * more_loops + 4 * more_rows + 16 * more_both
    assert found.a.size > 40

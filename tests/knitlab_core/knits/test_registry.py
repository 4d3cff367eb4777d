"""Fabrics by name."""

from __future__ import annotations

from dataclasses import replace

import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import (
    NAMED_STITCHES,
    Counts,
    Fabric,
    Filament,
    OwnCentreline,
    fabric_named,
    fabric_names,
    register,
    registry,
)
from rigs.protocol.specimen import SpecimenSpec

DEFAULT = NAMED_STITCHES["stockinette-default"]


@pytest.fixture(autouse=True)
def own_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget afterwards what a test registers."""
    monkeypatch.setattr(registry, "_FABRICS", dict(registry._FABRICS))


def test_a_registered_fabric_is_a_knit_like_any_other() -> None:
    wide = replace(DEFAULT, row_spacing=0.9)
    register("wide", wide)
    register("wide", wide)  # twice the same is no other
    assert fabric_names()[-1] == "wide"
    spec = SpecimenSpec(knit="wide", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM")
    assert spec.fabric is wide


@pytest.mark.parametrize(
    ("name", "allowed"),
    [("", "a letter, then"), ("2x2", "a letter, then"), ("a b", "a letter, then"), ("garter", "no other fabric has")],
)
def test_a_name_that_is_none_or_taken_is_refused(name: str, allowed: str) -> None:
    with pytest.raises(SpecificationError, match=allowed):
        register(name, DEFAULT)


def test_an_unknown_name_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(SpecificationError, match=r"found 'gartner', allowed one of stockinette-default, .*garter"):
        fabric_named("gartner")


OWN = OwnCentreline(
    points=tuple((0.1 * k, 0.0, 0.0) for k in range(12)), sites=((0, "course-"), (11, "course+")), fibre_radius=0.01
)
FABRICS = [*map(fabric_named, fabric_names()), Filament(fibre_radius=0.01), OWN]


@pytest.mark.parametrize("fabric", FABRICS, ids=lambda fabric: type(fabric).__name__)
def test_every_fabric_has_sites_on_the_faces_of_its_axes(fabric: Fabric) -> None:
    counts = Counts(1, 1) if fabric.straight else Counts(2, 2, 2 if "P" in fabric.axes else 1)
    line = fabric.centreline(counts)
    names = {"C": "course", "W": "wale", "P": "pile"}
    assert {site.set for site in line.sites} == {names[axis] + side for axis in fabric.axes for side in "-+"}
    assert 0.0 < fabric.loop_length(counts) <= line.length
    assert set(fabric.apex_distances) <= {site.set for site in line.sites}
    assert set(fabric.budgets(fabric.fibre_radius)) <= {"W", "P"}
    for clasps in fabric.clasps(line, counts).values():
        assert clasps.held.shape[:-1] == clasps.heads.shape[:-1]
        assert clasps.held.max() <= line.length
    assert hash(fabric) == hash(replace(fabric))

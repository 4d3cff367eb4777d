from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from app.checks.dry_run import dry_run
from app.checks.specimen_facts import describe
from app.runs.provenance import provenance
from app.schemas import load, loads, to_yaml
from app.schemas.machine_data import machines_of
from app.views.labels import beyond_elastic, yarn_label
from knitlab_core.knits import same_area
from rigs.protocol.made_specimen import make_specimen

if TYPE_CHECKING:
    from rigs.protocol.specimen import SpecimenSpec

EXAMPLES = Path(__file__).parents[3] / "examples"
PLAIN = load(EXAMPLES / "biaxial_small.yaml").protocol


def spec(name: str) -> SpecimenSpec:
    return load(EXAMPLES / f"{name}_small.yaml").protocol.specimen


def test_an_elastic_knit_of_one_fibre_has_nothing_to_declare() -> None:
    assert beyond_elastic(PLAIN.specimen) == {}
    assert yarn_label(PLAIN.specimen) == "one fibre"
    facts = provenance(PLAIN, machines_of(PLAIN))
    assert {facts[name] for name in ("viscoelastic", "fused_points", "rupture")} == {"off"}


@pytest.mark.parametrize(
    ("name", "option", "says"),
    [
        ("creeping", "viscoelastic", "on: 0.25 of the stiffness relaxes, in 1 s, 10 s, 100 s (assumed)"),
        (
            "fused",
            "fused points",
            "on: where printed nearer than 0.4 mm, necks of radius 0.2 mm, strength 20 MPa (assu",
        ),
        ("rupture", "rupture", "stop: a fibre breaks at a strain of 0.05 (assumed)"),
        ("cotton", "rest shape", "straight: the yarn is bent into the knit before the test"),
    ],
)
def test_what_goes_beyond_is_declared_with_its_assumptions(name: str, option: str, says: str) -> None:
    (found,) = beyond_elastic(spec(name)).items()
    assert found[0] == option
    assert found[1].startswith(says)


def test_fused_points_stand_in_the_record_number_by_number() -> None:
    protocol = load(EXAMPLES / "fused_small.yaml").protocol
    facts = provenance(protocol, machines_of(protocol))
    assert facts["fused_points.strength"] == 20e6
    assert facts["fused_points.strength.source"] == "Pa; the protocol; assumed"
    assert "fused_points.shear_strength" not in facts


def test_fibres_are_counted_with_their_size() -> None:
    assert yarn_label(spec("bundle")) == (
        "2 fibres of radius 0.2828 mm, wound at 0.297 mm, twist 0 rad per loop width, each a rod of its own"
    )


def test_a_yarn_of_the_same_area_locks_where_its_single_fibre_does() -> None:
    single = describe(make_specimen(PLAIN.specimen)).locking_strain
    assert single is not None
    radius = PLAIN.specimen.fabric.fibre_radius
    for yarn in (same_area(radius, 3), same_area(radius, 2, model="bundle")):
        found = describe(make_specimen(replace(PLAIN.specimen, yarn=yarn))).locking_strain
        assert found == pytest.approx(single)
    # Glued fibres keep the room between them.
    glued = replace(same_area(radius, 3), bonding=1.0)
    found = describe(make_specimen(replace(PLAIN.specimen, yarn=glued))).locking_strain
    assert found is not None
    assert found < single


@pytest.mark.parametrize(("gap", "warned"), [("0.3 mm", True), ("0.4 mm", False)])
def test_points_that_would_not_fuse_are_warned_of(gap: str, warned: bool) -> None:  # noqa: FBT001 (a table's column)
    text = to_yaml(load(EXAMPLES / "fused_small.yaml").protocol).replace("gap: 0.4 mm", f"gap: {gap}")
    warnings = dry_run(loads(text)).warnings
    assert any("fused points: none below 0.3 mm, the narrowest gap is 0.366 mm" in line for line in warnings) == warned

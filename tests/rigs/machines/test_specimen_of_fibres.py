from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.schemas.machine_data import machines_of
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.equilibrium.march import march
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, same_area
from knitlab_core.materials import MATERIALS
from knitlab_core.rods.section import yarn_section
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.machines.rig import place_of, pose, without_edge
from rigs.machines.shape import axial_strain
from rigs.protocol.made_specimen import gauge_lengths, make_specimen
from rigs.protocol.protocol import Hold, LogSpec, Preload, Protocol, Ramp, SpecimenSpec, Target
from rigs.record import Equilibrium, Outcome
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from knitlab_core.equilibrium.model import State
    from rigs.machines.rig import Rig
    from rigs.protocol.step import Step

RADIUS = NAMED_STITCHES["stockinette-default"].fibre_radius
PULL = Ramp(axes=BOTH, to=Target(kind="strain", value=0.1), rate=2e-4)


def protocol(*steps: Step, **specimen: Any) -> Protocol:  # noqa: ANN401 (whatever a specimen is made of)
    spec = {"knit": "stockinette-default", "rows": 2, "loops": 2, "loop_width": 8e-3, "nodes_per_loop": 24}
    return Protocol(
        specimen=SpecimenSpec(**{**spec, "material": "RGD8530-DM", **specimen}),
        speed_ref="pair",
        others="hold",
        steps=steps or (PULL,),
        log=LogSpec(noise=False),
        max_strain_increment=0.02,
    )


def mounted(test: Protocol) -> tuple[Rig, State]:
    return mount(make_specimen(test.specimen), test, machines_of(test))


def happened(test: Protocol) -> tuple[list[Equilibrium], Outcome]:
    *events, outcome = perform(*mounted(test), test)
    assert isinstance(outcome, Outcome)
    return [event for event in events if isinstance(event, Equilibrium)], outcome


def test_a_hook_holds_every_fibre_of_a_bundle() -> None:
    single, _ = mounted(protocol())
    bundle, state = mounted(protocol(yarn=same_area(RADIUS, 3, model="bundle")))
    count = single.strands[0]
    assert bundle.strands == (count, count, count)
    for axis in BOTH:
        for one, many in zip(single.grips[axis], bundle.grips[axis], strict=True):
            assert many.nodes.reshape(-1, 3).tolist() == [[node + k * count for k in range(3)] for node in one.nodes]
    assert gauge_lengths(bundle.specimen) == pytest.approx(gauge_lengths(single.specimen), rel=1e-12)
    # Every fibre has its edges, and none leads to the next.
    assert axial_strain(bundle, state).shape == (3 * (count - 1),)
    assert np.abs(axial_strain(bundle, state)).max() < 1e-12
    assert place_of(bundle, count + 5) == f"fibre 2 at {place_of(single, 5)}"


def test_a_yarn_seen_as_one_rod_has_the_section_of_its_fibres() -> None:
    yarn = replace(same_area(RADIUS, 4), bonding=0.5)
    single, _ = mounted(protocol())
    rig, _ = mounted(protocol(yarn=yarn))
    assert len(rig.strands) == 1
    section, rods = yarn_section(yarn), rig.work.model.rods
    assert rods.stretch_stiffness[0] == pytest.approx(section.area * np.pi)
    assert rods.bend_stiffness[1] == pytest.approx(section.bend * np.pi / 4.0)
    # A fibre's surface is as far from where it bends as its own radius, and more if fibres are glued together.
    reach = (yarn.fibre_radius + 0.5 * yarn.winding_radius) / yarn.contact_radius
    assert (single.fibre_reach, rig.fibre_reach) == pytest.approx((1.0, reach))


def test_a_broken_edge_has_no_strain() -> None:
    rig, state = mounted(protocol(material="VeroUltraWhite", rupture="go on"))
    gauge = rig.gauges
    *_, (_, pulled, _) = march(
        rig.work, state, lambda share: pose(rig, {axis: 0.1 * share * gauge[axis] for axis in BOTH}), longest=0.25
    )
    edge = 60
    cut, after = without_edge(rig, pulled, edge)
    strain = axial_strain(cut, after)
    assert np.flatnonzero(np.isnan(strain)).tolist() == [edge]
    # The carriages hold what they held, where they held it.
    held = rig.work.model.fixed
    target = pose(cut, {axis: 0.1 * gauge[axis] for axis in BOTH})
    assert target[held] == pytest.approx(after.q[held])
    assert after.fracture_work > 0.0


def test_a_rupture_ends_a_preload_too() -> None:
    brittle = replace(MATERIALS["VeroUltraWhite"], name="glass")
    limit = replace(brittle.elongation_at_break, value=0.02)  # type: ignore[type-var]
    test = protocol(
        Preload(axes=BOTH, force=50.0, rate=2e-4), material=replace(brittle, elongation_at_break=limit), rupture="stop"
    )
    rows, outcome = happened(test)
    assert outcome.end == "rupture"
    assert rows[-1].phase == "Preload"
    *before, peak, drop = rows
    assert peak.fibre_strain == pytest.approx(0.02, rel=1e-3)
    assert all(row.fibre_strain < 0.02 for row in before)
    assert all(one.time < next_one.time for one, next_one in pairwise([*before, peak]))
    assert drop.time == peak.time
    assert drop.fracture_work > peak.fracture_work == 0.0
    assert all(drop.force[axis] < peak.force[axis] for axis in BOTH)


def test_time_stands_still_for_an_elastic_hold() -> None:
    rows, _ = happened(protocol(PULL, Hold(duration=50.0)))
    assert [row.phase for row in rows].count("Hold") == 1
    assert rows[-1].time == rows[-2].time + 50.0
    assert rows[-1].force == rows[-2].force


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            {"material": "cotton-2-ply", "viscoelastic": True},
            "viscoelastic: found 'on', allowed off: nothing is known of the relaxation of cotton-2-ply",
        ),
        (
            {"material": replace(MATERIALS["IP-Dip"], name="x", elongation_at_break=None), "rupture": "stop"},
            "rupture: found 'stop', allowed off: nothing is known of the breaking strain of x",
        ),
        (
            {"rest_shape": "straight", "fused": BondLaw(fuse_gap=1e-3, patch_radius=1e-4, strength=1e7)},
            "fused: found 'fused points', allowed none in a yarn that is straight at rest",
        ),
    ],
)
def test_an_option_needs_its_numbers(options: dict[str, Any], says: str) -> None:
    with pytest.raises(SpecificationError) as raised:
        protocol(**options)
    assert str(raised.value).startswith(says)

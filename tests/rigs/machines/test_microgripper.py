from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.checks.dry_run import dry_run
from app.records.reader import RunReader
from app.runs.provenance import provenance
from app.runs.use_cases import run_protocol
from app.schemas import load, loads
from app.schemas.machine_data import machines_of
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import plate_nodes
from rigs.analysis.stress_strain import stress_strain
from rigs.control.path import AxisPath, follow
from rigs.machines.mounting import mount
from rigs.machines.rig import pose, read
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Protocol, Ramp, SpecimenSpec, Target

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import Axis
    from rigs.control.path import PathPoint
    from rigs.machines.rig import Rig

BALANCE = 1e-3

TEXT = """\
schema: knitlab/protocol@1
name: tiny
rig: sem-microgripper
specimen: {knit: volumetric-default, loops: [2, 1, 2], loop: 50 um, material: IP-Dip, nodes_per_loop: 24}
speed_ref: pair
others: free
log: {rate: 5 Hz, noise: off}
max_strain_increment: 4 %
steps:
  - zero: {channels: [force, displacement]}
  - ramp: {axes: [P], to: {strain: 12 %}, rate: 0.13 um/s}
"""


def protocol(**knit: Any) -> Protocol:  # noqa: ANN401 (whatever a specimen is made of)
    made = {"knit": "volumetric-default", "layers": 2, "loop_width": 5e-5, "material": "IP-Dip", **knit}
    spec = SpecimenSpec(rows=2, loops=1, nodes_per_loop=24, **made)
    ramp = Ramp(axes=("P",), to=Target(kind="strain", value=0.1), rate=1e-7)
    return Protocol(rig="sem-microgripper", specimen=spec, speed_ref="pair", others="free", steps=(ramp,))


def drawn(test: Protocol, strain: float) -> tuple[Rig, PathPoint]:
    rig, state = mount(make_specimen(test.specimen), test, machines_of(test))
    start: dict[Axis, float] = {"P": 0.0}
    goal: dict[Axis, float] = {"P": strain * rig.gauges["P"]}
    *_, step = follow(
        rig, state, AxisPath(start=start, goal=goal, longest=0.25, duration=0.0, options=None, go_on=False)
    )
    return rig, step


@pytest.fixture(scope="module")
def micro() -> tuple[Rig, PathPoint]:
    return drawn(protocol(), 0.12)


def test_plates_clamp_every_node_inside_them(micro: tuple[Rig, PathPoint]) -> None:
    rig, step = micro
    lower, upper = rig.grips["P"]
    plates = plate_nodes(rig.specimen)
    assert (lower.nodes.tolist(), upper.nodes.tolist()) == (plates.lower.tolist(), plates.upper.tolist())
    inside = np.concatenate([lower.nodes, upper.nodes])
    assert np.all(rig.work.model.fixed[inside])
    # Nothing else is held but the dummy angle of the last node.
    last = len(rig.mounted) - 1
    assert rig.work.model.fixed.sum() == 4 * len(inside) + (last not in inside)
    moved = step.state.q - rig.mounted
    assert np.all(moved[lower.nodes] == 0.0)
    assert moved[upper.nodes] == pytest.approx(np.tile(moved[upper.nodes[0]], (len(upper.nodes), 1)), abs=1e-12)


def test_the_gauge_is_the_gap_between_the_plates(micro: tuple[Rig, PathPoint]) -> None:
    rig, _ = micro
    gap = plate_nodes(rig.specimen).gap
    assert rig.gauges == {"P": gap}
    # One spacing and one height of pile loops, less what either plate covers of them.
    covers = 0.05 + 0.8 * (1.0 - np.cos(0.35))
    assert gap == pytest.approx(5e-5 * (1.25 + 1.6 - 2.0 * covers))
    hooks = make_specimen(protocol().specimen)
    assert rig.size.section("P") == rig.size.extents["C"] * rig.size.extents["W"]
    assert rig.size.convention == "specimen"
    assert gap < float(np.ptp(hooks.nodes[:, 2]))


def test_substrate_and_gripper_feel_the_same_pull(micro: tuple[Rig, PathPoint]) -> None:
    rig, step = micro
    reading = read(rig, step.state)
    assert reading.force["P"] > 0.0
    assert abs(reading.imbalance["P"]) <= BALANCE * reading.force["P"]
    assert reading.lateral == 0.0
    # Sides are free: what plates feel across the pull balances as well.
    across = step.state.reaction[:, :2].sum(axis=0) * rig.work.model.scales.force
    assert np.abs(across).max() <= BALANCE * reading.force["P"]


def test_a_micro_knit_is_its_macro_twin_by_modulus() -> None:
    def stress(test: Protocol) -> float:
        rig, step = drawn(test, 0.12)
        return read(rig, step.state).force["P"] / rig.size.section("P") / test.specimen.solid.young_modulus.value

    # The same resin at 160 times the size: no length enters but the knit's own.
    assert stress(protocol()) == pytest.approx(stress(protocol(loop_width=8e-3)), rel=1e-6)


def test_the_lower_plate_stands(micro: tuple[Rig, PathPoint]) -> None:
    rig, _ = micro
    moved = (pose(rig, {"P": 1e-6}) - rig.mounted)[:, 2] * rig.work.model.scales.length
    lower, upper = rig.grips["P"]
    assert np.all(moved[lower.nodes] == 0.0)
    assert moved[upper.nodes] == pytest.approx(1e-6, rel=1e-9)


def test_plates_hold_every_fibre_of_a_bundle() -> None:
    text = TEXT.replace("nodes_per_loop: 24", "nodes_per_loop: 24, yarn: {fibres: 2, model: bundle, twist: 1}")
    specimen = make_specimen(loads(text, "p.yaml").protocol.specimen)
    one, count = make_specimen(loads(TEXT, "p.yaml").protocol.specimen), len(specimen.arc_lengths)
    plates, single = plate_nodes(specimen), plate_nodes(one)
    for held, alone in ((plates.lower, single.lower), (plates.upper, single.upper)):
        assert held.tolist() == [*alone.tolist(), *(alone + count).tolist()]


@pytest.mark.parametrize("knit", ["stockinette-default", "plain-knit"])
def test_a_planar_knit_has_no_faces_for_plates(knit: str) -> None:
    with pytest.raises(SpecificationError, match="knit: found 'a knit with faces across C and W', allowed one with"):
        protocol(knit=knit, layers=1)


def test_gap_and_compliance_are_on_record() -> None:
    test = protocol()
    data = machines_of(test)
    (indenter,) = data.values()
    assert indenter.carriage.gap is not None
    facts = provenance(test, data)
    assert facts["rig.carriage.gap"] == indenter.carriage.gap.value > 0.0
    assert facts["rig.carriage.compliance"] == indenter.carriage.compliance.value > 0.0
    assert "assumed" in str(facts["rig.carriage.gap.source"])
    assert indenter.pole is None


def test_the_gripper_draws_as_planned(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(TEXT, encoding="utf-8")
    plan = dry_run(load(path))
    gap = plan.specimen.gauge_lengths["P"]
    assert not plan.warnings
    assert plan.duration == pytest.approx(0.12 * gap / 1.3e-7)
    result = run_protocol(path, tmp_path / "run", lambda _share, _text: None)
    assert (result.outcome, result.message) == ("target", "")
    run = RunReader(result.folder / "run.h5")
    samples = run.samples["nanoindenter"]
    assert samples.units == {"Displacement": "m", "Force": "N"}
    strain, stress = stress_strain(samples.measured["Displacement"], samples.measured["Force"], "P", run.size)
    assert strain[-1] == pytest.approx(0.12, abs=2e-3)
    assert stress[-1] > 0.0
    assert {path.name for path in result.folder.iterdir()} >= {"run.h5", "tiny_knit.png", "tiny_stress_strain.png"}

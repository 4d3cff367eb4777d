from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.export import export_logs
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.writer import RunWriter
from app.schemas import ProtocolError, loads
from app.schemas.machine_data import machines_of
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import SpecificationError
from rigs.axes import COORDINATE
from rigs.control.experiment import perform
from rigs.control.path import AxisPath, follow
from rigs.instruments.channels import measure
from rigs.instruments.signals import Curve
from rigs.machines.mounting import mount
from rigs.machines.rig import pose, read
from rigs.protocol.catalogue import CATALOGUE
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Protocol, Ramp, SpecimenSpec, Target
from rigs.record import Equilibrium, Outcome
from rigs.trace import trace_of

if TYPE_CHECKING:
    from pathlib import Path

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.machines.rig import Rig

AXES: tuple[Axis, ...] = ("C", "W", "P")

# The solver leaves 1e-4 of the mean force of a held unknown at a free one; over the knit these add up.
BALANCE = 1e-3

PLANAR = """\
schema: knitlab/protocol@1
rig: triaxial
specimen: {knit: stockinette-default, loops: [3, 3], loop: 8 mm, material: RGD8530-DM}
speed_ref: pair
others: hold
steps:
  - ramp: {axes: [P], to: {strain: 0.1}, rate: 0.2 mm/s}
"""


def ramp(strain: float, *axes: Axis) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=strain), rate=2e-4)


def protocol(knit: str = "volumetric-default", layers: int = 2) -> Protocol:
    spec = SpecimenSpec(
        knit=knit, rows=2, loops=1, layers=layers, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=24
    )
    return Protocol(
        rig="triaxial",
        specimen=spec,
        speed_ref="grip",
        others="hold",
        steps=(ramp(0.12, "C", "W"), ramp(0.08, "P")),
        max_strain_increment=0.04,
    )


@pytest.fixture(scope="module")
def pulled() -> tuple[Rig, list[Equilibrium], State]:
    test = protocol()
    rig, state = mount(make_specimen(test.specimen), test, machines_of(test))
    *rows, outcome = [event for event in perform(rig, state, test) if isinstance(event, Equilibrium | Outcome)]
    assert outcome == Outcome(end="target")
    return rig, [row for row in rows if isinstance(row, Equilibrium)], state


def stiffness(rig: Rig, state: State) -> np.ndarray:
    """Return the stiffness of all unknowns (4N, 4N) at a state, fixed or not."""
    work = Workspace(rig.work.model)
    work.start_step(state.q, state.frames, state.memory)
    work.assemble()
    unit = np.eye(state.q.size)
    return np.array([work.stiffness.times(one.reshape(state.q.shape)).ravel() for one in unit])


def test_stage_and_crosshead_pull_together(pulled: tuple[Rig, list[Equilibrium], State], tmp_path: Path) -> None:
    rig, rows, _ = pulled
    gauges, specimen = rig.gauges, rig.specimen
    way = {axis: [row.displacement[axis] / gauges[axis] for row in rows] for axis in AXES}
    # The frame gives way a little: its crosshead stands where it was sent.
    sent = [rows[-1].crosshead[axis] / gauges[axis] for axis in AXES]
    assert sent == pytest.approx([0.12, 0.12, 0.08], abs=2e-6)
    assert all(pile == 0.0 or course == way["C"][-1] for course, pile in zip(way["C"], way["P"], strict=True))
    # Two grips move apart on the stage, one on the frame.
    times = [0.12 * max(gauges["C"], gauges["W"]) / 4e-4, 0.08 * gauges["P"] / 2e-4]
    assert rows[-1].time == pytest.approx(sum(times))
    assert [{channel.name for channel in one.channels} for one in rig.instruments] == [
        {"XDisplacement", "YDisplacement", "XForce", "YForce"},
        {"Displacement", "Force"},
    ]
    with RunWriter(
        make_record(
            tmp_path / "run.h5",
            protocol="",
            size=rig.size,
            axes=AXES,
            strands=[len(specimen.nodes)],
            instruments=rig.instruments,
            provenance={"name": "s", "rig.convention.temperature": 22.0},
        )
    ) as writer:
        for row in rows:
            writer.append(row)
        for instrument in rig.instruments:
            writer.write_samples(measure(instrument, trace_of(rows), seed=1))
    run = RunReader(tmp_path / "run.h5")
    assert run.trace.axes == AXES
    assert {name: set(samples.units.values()) for name, samples in run.samples.items()} == {
        "biaxial-hook": {"m", "N"},
        "uniaxial-frame": {"m", "N"},
    }
    logs = export_logs(run, tmp_path)
    assert [path.name for path in logs] == ["s.csv", "s_1.csv", "s_merged.csv"]
    stage, frame = (run.samples[name] for name in ("biaxial-hook", "uniaxial-frame"))
    # The stage was started 0.3 s before the frame, by its data file.
    assert (stage.time[0], frame.time[0]) == (0.3, 0.0)
    tables = [[line.split(",") for line in path.read_text().splitlines()] for path in logs]
    assert [len(table) for table in tables] == [len(stage.time) + 1, len(frame.time) + 2, len(frame.time) + 2]
    merged = dict(zip(tables[2][0], zip(*tables[2][2:], strict=True), strict=True))
    assert merged["Time"] == tuple(line[0] for line in tables[1][2:])
    assert merged["uniaxial-frame.Force"] == tuple(line[2] for line in tables[1][2:])
    # However late the stage's clock, what is merged is what its encoder felt when the frame was read.
    columns = run.trace.columns
    felt = Curve.through(columns["time"], columns["displacement_C"], run.trace.strokes())(frame.time)
    travel = [1e-3 * float(text) for text in merged["biaxial-hook.XDisplacement"]]
    assert travel == pytest.approx(felt, abs=5e-6)


def test_carriages_of_the_stage_move_evenly_and_the_crosshead_alone(
    pulled: tuple[Rig, list[Equilibrium], State],
) -> None:
    rig, _, _ = pulled
    moved = (pose(rig, dict.fromkeys(AXES, 2e-3)) - rig.mounted)[:, :3] * rig.work.model.scales.length
    for axis, ways in (("C", (-1e-3, 1e-3)), ("W", (-1e-3, 1e-3)), ("P", (0.0, 2e-3))):
        for grip, way in zip(rig.grips[axis], ways, strict=True):  # type: ignore[index]
            assert moved[grip.nodes, COORDINATE[axis]] == pytest.approx(way, abs=1e-15)  # type: ignore[index]


def test_a_hook_holds_the_pull_alone(pulled: tuple[Rig, list[Equilibrium], State]) -> None:
    rig, _, _ = pulled
    fixed, sites = rig.work.model.fixed, rig.specimen.sites
    for axis, name in (("C", "course"), ("W", "wale"), ("P", "pile")):
        for side in "-+":
            held = fixed[sites[f"{name}{side}"]]  # type: ignore[index]
            assert np.all(held[:, COORDINATE[axis]])  # type: ignore[index]
    # No site belongs to two faces; beside them only the dummy angle of the last node is held.
    assert fixed.sum() == sum(len(nodes) for nodes in sites.values()) + 1


def rigid_motions(rig: Rig) -> np.ndarray:
    """Return three translations and three turns of all nodes, (6, N, 4), edge angles left out."""
    at = rig.mounted[:, :3]
    motions = np.zeros((6, len(at), 4))
    for k, unit in enumerate(np.eye(3)):
        motions[k, :, :3] = unit
        motions[3 + k, :, :3] = np.cross(unit, at) / np.abs(at).max()
    return motions


def test_every_rigid_motion_moves_a_hook_and_the_stiffness_is_positive(
    pulled: tuple[Rig, list[Equilibrium], State],
) -> None:
    rig, _, start = pulled
    fixed = rig.work.model.fixed
    assert np.linalg.svd(rigid_motions(rig)[:, fixed], compute_uv=False)[-1] > 0.5
    # A knit free of stress is a rod: what moves it and costs nothing is rigid, and the hooks leave none of that.
    whole = stiffness(rig, start)
    assert np.abs(whole - whole.T).max() <= 1e-12 * np.abs(whole).max()
    free = np.flatnonzero(~fixed.ravel())
    assert np.diag(np.linalg.cholesky(whole[np.ix_(free, free)])).min() > 0.0


def test_on_faces_of_the_pile_alone_it_could_slide_and_turn(pulled: tuple[Rig, list[Equilibrium], State]) -> None:
    rig, _, _ = pulled
    held = np.zeros_like(rig.work.model.fixed)
    for grip in rig.grips["P"]:
        held[grip.nodes, COORDINATE["P"]] = True
    sizes = np.linalg.svd(rigid_motions(rig)[:, held], compute_uv=False)
    assert (sizes > 1e-9).sum() == 3


@pytest.fixture(scope="module")
def apart() -> tuple[Rig, State, State]:
    """Return a knit pulled by 12, 12 and 10 %, and then by 30 % along the pile."""
    test = protocol()
    rig, state = mount(make_specimen(test.specimen), test, machines_of(test))
    found, before = [], dict.fromkeys(AXES, 0.0)
    for pile in (0.1, 0.3):
        strain = {"C": 0.12, "W": 0.12, "P": pile}
        goal = {axis: strain[axis] * rig.gauges[axis] for axis in AXES}
        way = AxisPath(start=before, goal=goal, longest=0.25, duration=0.0, options=None, go_on=False)
        *_, step = follow(rig, state, way)
        state, before = step.state, goal
        found.append(state)
    return rig, found[0], found[1]


def test_forces_on_either_side_of_every_axis_balance(apart: tuple[Rig, State, State]) -> None:
    rig, *states = apart
    for state in states:
        reading = read(rig, state)
        largest = max(reading.force.values())
        assert all(force > 0.02 * largest for force in reading.force.values())
        assert all(abs(left) <= BALANCE * largest for left in reading.imbalance.values())


def test_poles_of_the_stage_follow_the_pile_without_a_force(apart: tuple[Rig, State, State]) -> None:
    rig, before, after = apart
    for axis in ("C", "W"):
        for grip in rig.grips[axis]:
            height = [np.ptp(state.q[grip.nodes, 2]) for state in (before, after)]
            assert height[1] > 1.02 * height[0]
            felt = after.reaction[grip.nodes]
            assert np.all(felt[:, [k for k in range(4) if k != COORDINATE[axis]]] == 0.0)
            assert np.abs(felt).max() > 0.0
    assert read(rig, after).lateral == 0.0


def test_a_planar_knit_has_no_faces_to_pull_along_the_pile() -> None:
    says = "knit: found 'a knit with faces across C and W', allowed one with faces across C, W and P, which triaxial"
    with pytest.raises(SpecificationError, match=says):
        protocol("stockinette-default", layers=1)
    with pytest.raises(ProtocolError) as error:
        loads(PLANAR, "p.yaml")
    assert str(error.value).startswith("p.yaml:3:")
    assert "\n" not in str(error.value)


def test_rigs_are_data_alone() -> None:
    stage, frame, both = (CATALOGUE[name] for name in ("biaxial-hook", "uniaxial-frame", "triaxial"))
    for axis, drive in both.drives.items():
        like = (frame if axis == "P" else stage).drives[axis]
        assert (drive.machine, drive.travel, drive.cell, drive.pole) == (
            like.machine,
            like.travel,
            like.cell,
            like.pole,
        )

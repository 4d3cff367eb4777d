"""Control forces, let axes give way, and let machines do: what a controller asks for, and what a rig then does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.schemas.machine_data import machines_of, read_machine
from knitlab_core.materials import Value, material_named
from rigs.control.checkpoint import Checkpoint, restore
from rigs.control.experiment import perform
from rigs.control.setpoint_search import FINEST_DIGIT, FORCE_TOLERANCE
from rigs.instruments.zeros import Zeroing
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import (
    Cycle,
    ForceRate,
    Hold,
    Image,
    Preload,
    Ramp,
    StrainRate,
    Target,
    Until,
    UntilRupture,
    Zero,
)
from rigs.record import Equilibrium, Frame, Outcome
from rigs.step_record import StepRecord

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigs.axes import Axis
    from rigs.machines.machine import MachineData
    from rigs.machines.rig import Rig
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.step import Step

    Bar = Callable[..., None]

SPEED = 1e-3


class Run:
    """What a test yielded."""

    def __init__(self, rig: Rig, events: list[object]) -> None:
        self.rig, self.events = rig, events
        self.rows = [event for event in events if isinstance(event, Equilibrium)]
        self.pictures = [event.time for event in events if isinstance(event, Frame) and event.image is not None]
        # What is recorded last of a step counts.
        self.steps = list({event.number: event for event in events if isinstance(event, StepRecord)}.values())
        assert isinstance(events[-1], Outcome)
        self.outcome = events[-1]

    def column(self, name: str, axis: Axis) -> np.ndarray:
        return np.array([getattr(row, name)[axis] for row in self.rows])

    def of_step(self, number: int) -> list[Equilibrium]:
        return [row for row in self.rows if row.step == number and row.phase != "Zero"]


@pytest.fixture
def control(mount_knit: Callable[..., Any]) -> Callable[..., Run]:
    def run(*steps: Step, **knit: Any) -> Run:  # noqa: ANN401 (handed through)
        rig, state, protocol = mount_knit(*steps, **knit)
        ran = Run(rig, list(perform(rig, state, protocol)))
        spent = sum(row.iterations for row in ran.rows) + ran.outcome.unfinished.iterations
        assert spent == rig.work.clock.iterations  # of trials and failed searches too
        return ran

    return run


def stretch(strain: float, *axes: Axis, **more: Any) -> Ramp:  # noqa: ANN401 (handed through)
    return Ramp(axes=axes, to=Target(kind="strain", value=strain), **{"rate": SPEED, **more})


def load(force: float, *axes: Axis, rate: float = 0.02, **more: Any) -> Ramp:  # noqa: ANN401 (handed through)
    return Ramp(axes=axes, to=Target(kind="force", value=force), rate=ForceRate(value=rate), **more)


def yielding(machine: MachineName, compliance: float, gap: float | None = None) -> MachineData:
    """Return a machine that gives way [m/N], behind a gripper that closes a gap [m]."""
    data = read_machine(machine)
    given = replace(data.carriage.compliance, value=compliance)
    between = None if gap is None else replace(given, value=gap, unit="m")
    return replace(data, carriage=replace(data.carriage, compliance=given, gap=between))


def test_a_controlled_force_is_reached_and_let_go(control: Callable[..., Run], bar: Bar) -> None:
    ran = control(load(0.05, "C", "W"), load(0.02, "C", "W"), increment=0.03)
    assert ran.outcome.end == "target"
    for number, force in enumerate((0.05, 0.02)):
        last = ran.of_step(number)[-1]
        for axis in ("C", "W"):
            error = last.force[axis] / force - 1.0
            bar(f"force control to {force} N, axis {axis}", error, 1e-3, "1", "the protocol's own target")
    # The forces rise at the rate that was asked for.
    for row in ran.of_step(0):
        force, digit = 0.02 * row.time, ran.rig.trains["C"].digit
        assert row.force["C"] == pytest.approx(force, abs=FORCE_TOLERANCE * force + FINEST_DIGIT * digit)


def test_a_machine_that_gives_way_is_driven_farther(control: Callable[..., Run], bar: Bar) -> None:
    compliance = 2e-3
    cycle = Cycle(axes=("C", "W"), lower=0.0, upper=0.15, rate=SPEED, n=1)
    ran = control(cycle, data=yielding("biaxial-hook", compliance), increment=0.05)
    assert ran.outcome.end == "target"
    for axis, length in ran.rig.gauges.items():
        ways, forces = ran.column("crosshead", axis) - ran.column("displacement", axis), ran.column("force", axis)
        worst = np.abs(ways - compliance * forces).max() / (compliance * forces.max())
        bar(f"crosshead less fixture = C F, axis {axis}", worst, 1e-6, "1", "Hooke")
        peak = int(np.argmax(forces))
        asked = 0.15 * length
        missed = (ran.rows[peak].crosshead[axis] - asked) / (compliance * forces[peak])
        bar(f"crosshead where it was sent, axis {axis}", missed, 2e-3, "1", "the protocol's own target")
        assert ran.rows[peak].displacement[axis] < asked


def test_a_gripper_closes_its_gap_before_it_pulls(control: Callable[..., Run]) -> None:
    gap, compliance = 1e-3, 1e-3
    up, down = (Ramp(axes=("C",), to=Target(kind="displacement", value=way), rate=SPEED) for way in (2.5e-3, 0.0))
    ran = control(up, down, data=yielding("uniaxial-frame", compliance, gap), mount_along="C", increment=0.03)
    crosshead, fixture, force = (ran.column(name, "C") for name in ("crosshead", "displacement", "force"))
    closing = crosshead < gap
    assert closing[1]
    assert closing[-2]
    assert np.abs(force[closing]).max() < 1e-4
    assert np.abs(fixture[closing]).max() < 1e-2 * gap
    pulling = force > 1e-3
    assert crosshead[pulling] == pytest.approx(fixture[pulling] + gap + compliance * force[pulling], abs=1e-12)
    assert crosshead.max() == pytest.approx(2.5e-3, abs=1e-7)
    assert crosshead[-1] == 0.0


def test_others_give_way_hold_or_follow(control: Callable[..., Run]) -> None:
    drawn = {
        others: control(stretch(0.25, "C"), others=others, increment=0.05) for others in ("hold", "free", "follow")
    }
    last = {others: ran.rows[-1] for others, ran in drawn.items()}
    length = drawn["hold"].rig.gauges
    assert last["hold"].displacement["W"] == 0.0
    assert last["follow"].displacement["W"] / length["W"] == pytest.approx(0.25)
    assert abs(last["hold"].force["W"]) > 1e-3
    assert abs(last["free"].force["W"]) < 1e-3 * last["free"].force["C"]
    assert last["free"].displacement["W"] != 0.0


def test_others_follow_an_axis_whose_force_is_controlled(control: Callable[..., Run]) -> None:
    ran = control(load(0.02, "C"), others="follow", increment=0.04)
    strains = [ran.column("displacement", axis) / ran.rig.gauges[axis] for axis in ("C", "W")]
    assert strains[0][-1] > 0.05
    assert strains[0] == pytest.approx(strains[1], abs=1e-5)


@pytest.mark.parametrize(
    ("until", "end", "says"),
    [
        (Until(force=0.01, time=100.0), "limit", "axis C carries 0.01 N"),
        (Until(time=1.25), "timeout", "1.25 s passed"),
        (Until(strain=0.0625), "limit", "axis C is strained by 0.0625"),
        (Until(displacement=0.5e-3), "limit", "axis C is displaced by 0.5 mm"),
    ],
)
def test_what_is_met_first_ends_a_step_and_the_test_goes_on(
    until: Until, end: str, says: str, control: Callable[..., Run]
) -> None:
    ran = control(stretch(0.2, "C", until=until), Hold(duration=1.0), increment=0.04)
    assert [step.end for step in ran.steps] == [end, "target"]
    assert ran.steps[0].message == says
    assert ran.outcome.end == "target"
    last = ran.of_step(0)[-1]
    reached = {
        "force": (last.force["C"], until.force, 5e-3),
        "time": (last.time, until.time, 1e-9),
        "strain": (last.displacement["C"] / ran.rig.gauges["C"], until.strain, 1e-9),
        "displacement": (last.displacement["C"], until.displacement, 1e-9),
    }
    kind = "force" if until.force else next(kind for kind, (_, level, _) in reached.items() if level)
    value, level, tolerance = reached[kind]
    assert level is not None
    assert value == pytest.approx(level, rel=tolerance)


def test_the_controller_sees_what_the_load_cell_shows(control: Callable[..., Run]) -> None:
    clean, noisy = (
        control(stretch(0.1, "C"), Zero(), Preload(axes=("C",), force=0.01, rate=SPEED), noise=noise, increment=0.05)
        for noise in (False, True)
    )
    tare = clean.of_step(0)[-1].force["C"]
    # The load cell was tared: it shows a force on top of the one that was there.
    assert clean.rows[-1].force["C"] - tare == pytest.approx(0.01, rel=6e-3)
    off = abs(noisy.rows[-1].force["C"] - clean.rows[-1].force["C"])
    sigma = read_machine("biaxial-hook").load_cell.noise.value
    assert 0.0 < off < 5.0 * sigma


def test_strain_rate_sets_the_pace(control: Callable[..., Run]) -> None:
    ran = control(stretch(0.05, "W", rate=StrainRate(value=1e-2)), increment=0.05)
    assert ran.rows[-1].time == pytest.approx(5.0)


def test_pictures_are_taken_on_schedule_through_every_kind_of_stroke(control: Callable[..., Run]) -> None:
    ran = control(
        Image(every=0.5, tag="frame"),
        stretch(0.1, "C"),
        load(0.02, "C", rate=0.01),
        Hold(duration=1.2),
        Image(every="off"),
        Hold(duration=3.0),
        Image(),
        increment=0.05,
    )
    scheduled = ran.pictures[:-1]
    assert scheduled == pytest.approx(0.5 * np.arange(len(scheduled)))
    assert scheduled[-1] <= ran.steps[3].time < scheduled[-1] + 0.5
    assert ran.pictures[-1] == ran.rows[-1].time
    frames = {event.time for event in ran.events if isinstance(event, Frame)}
    rows = {row.time for row in ran.rows}
    assert set(ran.pictures) <= frames & rows


def test_a_step_that_an_overload_ends_is_recorded_so(control: Callable[..., Run]) -> None:
    data = read_machine("biaxial-hook")
    cell = replace(data.load_cell, limit=replace(data.load_cell.limit, value=0.02))
    ran = control(load(0.1, "C"), Hold(duration=1.0), data=replace(data, load_cell=cell), increment=0.05)
    assert (ran.outcome.end, [step.end for step in ran.steps]) == ("limit", ["limit"])
    assert ran.outcome.message.startswith("XForce passed its limit of 0.02 N")
    assert ran.rows[-1].force["C"] > 0.02


def test_a_crosshead_has_its_travel(control: Callable[..., Run]) -> None:
    data = yielding("biaxial-hook", 1e-3)
    encoder = replace(data.encoder, limit=replace(data.encoder.limit, value=1e-3))
    ran = control(stretch(0.2, "C"), data=replace(data, encoder=encoder), increment=0.03)
    assert ran.outcome.message.startswith("XDisplacement passed its limit of 0.001 m")
    assert ran.rows[-1].crosshead["C"] > 1e-3 >= ran.rows[-2].crosshead["C"]


def test_a_machine_without_such_a_speed_does_not_move(control: Callable[..., Run]) -> None:
    ran = control(stretch(0.2, "C", rate=0.5))
    assert ran.outcome.end == ran.steps[0].end == "limit"
    assert ran.outcome.message == "speed: axis C would move at 500 mm/s, limit 10 mm/s"
    assert len(ran.rows) == 1


def test_no_rupture_up_to_the_ceiling_is_a_limit_and_the_test_goes_on(control: Callable[..., Run]) -> None:
    step = UntilRupture(axes=("C",), rate=SPEED, to=Target(kind="strain", value=0.05))
    ran = control(step, Hold(duration=1.0), increment=0.05)
    assert [(one.end, one.message) for one in ran.steps] == [("limit", "no rupture on the way"), ("target", "")]


def test_a_force_that_drops_because_a_ramp_lets_go_is_a_limit(control: Callable[..., Run]) -> None:
    # Nothing broke and nothing slipped.
    there, back = stretch(0.2, "C", "W"), stretch(0.0, "C", "W", until=Until(drop=0.5))
    ran = control(there, back, Hold(duration=1.0), increment=0.02)
    assert [step.end for step in ran.steps] == ["target", "limit", "target"]
    assert ran.steps[1].message.startswith("the force on axis ")
    start, *_, before, last = ran.rows[ran.rows.index(ran.of_step(1)[0]) - 1 : ran.rows.index(ran.of_step(1)[-1]) + 1]
    falls = [row.force["W"] / start.force["W"] for row in (before, last)]
    assert min(falls[0], before.force["C"] / start.force["C"]) > 0.5
    assert min(falls[1], last.force["C"] / start.force["C"]) <= 0.5
    assert ran.outcome.end == "target"


def test_a_fibre_that_takes_the_force_with_it_is_a_rupture_and_the_protocol_goes_on(
    control: Callable[..., Run],
) -> None:
    resin = material_named("RGD8530-DM")
    brittle = replace(resin, elongation_at_break=Value(value=0.06, unit="1", source="made up", assumed=True))
    step = UntilRupture(axes=("C", "W"), rate=SPEED, drop=0.4)
    ran = control(step, Image(tag="after"), material=brittle, rupture="go on", increment=0.02)
    assert [one.end for one in ran.steps] == ["rupture", "target"]
    assert ran.outcome == Outcome(end="rupture", message=ran.steps[0].message)
    assert ran.pictures == [ran.rows[-1].time]
    forces = {axis: ran.column("force", axis) for axis in ("C", "W")}
    assert any(force[-1] <= 0.6 * force.max() for force in forces.values())
    # The fibre broke with the carriages where they were.
    assert ran.rows[-1].displacement == ran.rows[-2].displacement


STEPS: tuple[Step, ...] = (
    Zero(),
    Image(every=0.7),
    Preload(axes=("C",), force=0.01, rate=SPEED),
    stretch(0.1, "W", tag="free"),
    load(0.03, "C", until=Until(strain=0.5)),
    Hold(duration=1.0),
    Cycle(axes=("C", "W"), lower=0.0, upper=0.02, rate=ForceRate(value=0.02), n=1, control="force"),
)


@pytest.mark.parametrize("machine", ["rigid", pytest.param("soft", marks=pytest.mark.slow)])
def test_every_kind_of_stroke_goes_on_from_a_checkpoint_to_the_same_rows(
    machine: str, mount_knit: Callable[..., Any]
) -> None:
    knit: dict[str, Any] = {"others": "free", "noise": True, "increment": 0.06}
    if machine == "soft":
        knit["data"] = yielding("biaxial-hook", 1e-3)
    rig, state, protocol = mount_knit(*STEPS, **knit)
    events = list(perform(rig, state, protocol))
    rows = [event for event in events if isinstance(event, Equilibrium)]
    marks = [number for number, event in enumerate(events) if isinstance(event, Checkpoint)]
    assert len({row.step for row in rows}) >= 5
    for mark in marks[2 :: max(1, len(marks) // 3)]:
        checkpoint = events[mark]
        assert isinstance(checkpoint, Checkpoint)
        machines = machines_of(protocol)
        if machine == "soft":
            machines["biaxial-hook"] = knit["data"]
        laid, _ = mount(make_specimen(protocol.specimen), protocol, machines)
        again = list(perform(restore(laid, checkpoint), checkpoint.state, protocol, cursor=checkpoint.cursor))
        done = sum(isinstance(event, Equilibrium) for event in events[:mark])
        going_on = [event for event in again if isinstance(event, Equilibrium)]
        assert [replace(row, seconds=0.0) for row in going_on] == [replace(row, seconds=0.0) for row in rows[done:]]
        pictures = [
            [event.time for event in which if isinstance(event, Frame) and event.image is not None]
            for which in (again, events[mark + 1 :])
        ]
        assert pictures[0] == pictures[1]


def test_strain_is_travel_by_the_gauge_length_at_the_preload(control: Callable[..., Run]) -> None:
    compliance = 2e-3
    ran = control(
        Preload(axes=("C",), force=0.05, rate=SPEED),
        Zero(channels=("displacement",), gauge_length="here"),
        stretch(0.05, "C", until=Until(strain=0.04)),
        increment=0.04,
        data=yielding("biaxial-hook", compliance),
    )
    (zeroing,) = [event for event in ran.events if isinstance(event, Zeroing)]
    preloaded, last = ran.of_step(0)[-1], ran.rows[-1]
    assert zeroing.place == "steps[1].zero"
    assert zeroing.travel == pytest.approx(preloaded.crosshead)
    assert zeroing.force == pytest.approx(preloaded.force)
    # The hooks' own distance: the crosshead went farther by what the machine gave.
    assert preloaded.crosshead["C"] - preloaded.displacement["C"] == pytest.approx(compliance * 0.05, rel=0.01)
    for axis, gauge in ran.rig.gauges.items():
        assert zeroing.gauges[axis] == pytest.approx(gauge + preloaded.displacement[axis], rel=1e-12)
    assert ran.steps[2].end == "limit"
    assert ran.steps[2].message == "axis C is strained by 0.04"
    assert last.crosshead["C"] - preloaded.crosshead["C"] == pytest.approx(0.04 * zeroing.gauges["C"], rel=5e-3)


def test_axes_that_follow_a_force_strain_alike_from_the_zero(control: Callable[..., Run]) -> None:
    apart = Ramp(axes=("C", "W"), to=Target(kind="displacement", value=2e-3), rate=SPEED)
    zero = Zero(channels=("displacement",), gauge_length="here")
    ran = control(apart, zero, load(0.03, "C"), increment=0.04, others="follow")
    (zeroing,) = [event for event in ran.events if isinstance(event, Zeroing)]
    start, last = ran.of_step(0)[-1], ran.rows[-1]
    strain = {axis: (last.displacement[axis] - start.displacement[axis]) / zeroing.gauges[axis] for axis in ("C", "W")}
    assert abs(zeroing.gauges["C"] / ran.rig.gauges["C"] / (zeroing.gauges["W"] / ran.rig.gauges["W"]) - 1.0) > 0.01
    assert abs(strain["C"]) > 0.01
    assert strain["W"] == pytest.approx(strain["C"], rel=1e-3)

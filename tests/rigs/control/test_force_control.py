"""Control forces up and down: the force is met at every row, or the test ends there and says why."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import TYPE_CHECKING, Any

import pytest

from app.schemas.machine_data import read_machine
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import RelaxationTerm, Value, material_named
from rigs.control.controller import DEAD_BAND, FILTER
from rigs.control.experiment import perform
from rigs.control.force_control import LONGEST
from rigs.control.setpoint_search import FINEST_DIGIT, FORCE_TOLERANCE
from rigs.instruments.zeros import Zeroing
from rigs.protocol.protocol import Cycle, ForceRate, Hold, Preload, Ramp, Target, Until, UntilRupture, Zero
from rigs.protocol.targets import Bound
from tests.rigs.control.test_control import SPEED, Run, load, stretch, yielding

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigs.axes import Axis

    Control = Callable[..., Run]

UP, DOWN, RATE, INCREMENT = 0.06, 0.003, 0.02, 0.03


@pytest.fixture
def control(mount_knit: Callable[..., Any]) -> Control:
    def run(*steps: object, **knit: Any) -> Run:  # noqa: ANN401 (handed through)
        rig, state, protocol = mount_knit(*steps, **{"increment": INCREMENT, "nodes": 16, **knit})
        ran = Run(rig, list(perform(rig, state, protocol)))
        spent = sum(row.iterations for row in ran.rows) + ran.outcome.unfinished.iterations
        assert spent == rig.work.clock.iterations  # of trials and failed searches too
        return ran

    return run


def made_up(value: float, unit: str) -> Value:
    return Value(value=value, unit=unit, source="made up", assumed=True)


RESIN = material_named("RGD8530-DM")
CREEPING = replace(
    RESIN,
    relaxation=tuple(RelaxationTerm(share=made_up(0.2, "1"), time=made_up(time, "s")) for time in (2.0, 20.0)),
)
BRITTLE = replace(RESIN, elongation_at_break=made_up(0.03, "1"))

RELAXING: dict[str, Any] = {"material": CREEPING, "viscoelastic": True}
RIGS: dict[str, tuple[tuple[Axis, ...], dict[str, Any]]] = {
    "frame": (("C",), {"mount_along": "C"}),
    "soft frame with a gap": (("C",), {"mount_along": "C", "data": yielding("uniaxial-frame", 1e-3, 1e-3)}),
    "stage, other axis held": (("C",), {}),
    "stage, other axis free": (("C",), {"others": "free"}),
    "soft stage, other axis free": (("C",), {"others": "free", "data": yielding("biaxial-hook", 2e-3)}),
    "stage, both axes": (("C", "W"), {}),
    "soft stage with gaps, both axes": (("C", "W"), {"data": yielding("biaxial-hook", 2e-3, 1e-3)}),
}


def assert_force_met(ran: Run, axes: tuple[Axis, ...], *, free: bool) -> None:
    """Check the rows of a ramp up, a hold and a ramp down against what was asked at their times."""
    for step, aim in zip(ran.steps, (UP, None, DOWN), strict=True):
        rows = ran.of_step(step.number)
        begin = ran.rows[ran.rows.index(rows[0]) - 1].force
        # A hold keeps what the ramp before it left.
        end = begin if aim is None else dict.fromkeys(begin, aim)
        # Axes that are driven together arrive together.
        duration = max(abs(end[axis] - begin[axis]) for axis in axes) / RATE
        for row in rows:
            done = 1.0 if aim is None else min(1.0, (row.time - step.start) / duration)
            for axis in row.force if free else axes:
                wanted = begin[axis] + done * (end[axis] - begin[axis]) if axis in axes else 0.0
                largest = max(abs(one) for one in row.force.values())
                bar = FORCE_TOLERANCE * (abs(wanted) or largest) + FINEST_DIGIT * ran.rig.trains[axis].digit
                assert row.force[axis] == pytest.approx(wanted, abs=1.01 * bar), (step, row.time, axis)


def assert_no_jump(ran: Run) -> None:
    """Check that no crosshead goes faster than it can, and no axis farther from row to row than it may."""
    for before, row in pairwise(ran.rows):
        for axis, gauge in ran.rig.gauges.items():
            fastest = ran.rig.trains[axis].fastest
            way = abs(row.crosshead[axis] - before.crosshead[axis])
            assert way <= fastest * (row.time - before.time) * (1.0 + 1e-4) + 1e-12
            assert abs(row.displacement[axis] - before.displacement[axis]) <= (LONGEST + 1e-6) * INCREMENT * gauge


@pytest.mark.parametrize("relaxing", [False, True], ids=["elastic", "relaxing"])
@pytest.mark.parametrize("name", RIGS)
def test_a_controlled_force_is_met_at_every_row_up_and_down(name: str, control: Control, *, relaxing: bool) -> None:
    axes, knit = RIGS[name]
    up, down = (load(force, *axes, rate=RATE) for force in (UP, DOWN))
    hold = Hold(duration=5.0, axes=axes, control="force")
    ran = control(up, hold, down, **knit, **(RELAXING if relaxing else {}))
    assert [step.end for step in ran.steps] == ["target"] * 3, ran.outcome
    if "gap" not in name:
        assert_force_met(ran, axes, free=knit.get("others") == "free")
    assert_no_jump(ran)


def test_a_gap_is_closed_at_the_speed_of_the_machine_before_a_force_rises(control: Control) -> None:
    axes, knit = RIGS["soft frame with a gap"]
    ran = control(load(UP, *axes, rate=RATE), **knit)
    closed = next(row for row in ran.rows if row.crosshead["C"] >= 1e-3)
    assert closed.time >= 1e-3 / ran.rig.trains["C"].fastest
    assert ran.rows[-1].force["C"] == pytest.approx(UP, rel=1.01 * FORCE_TOLERANCE)


@pytest.mark.parametrize("seed", range(4))
def test_a_force_is_controlled_with_the_noise_of_the_instrument(seed: int, control: Control) -> None:
    axes: tuple[Axis, ...] = ("C",)
    up, down = load(UP, *axes, rate=RATE), load(0.0, *axes, rate=RATE)
    hold = Hold(duration=5.0, axes=axes, control="force")
    ran = control(Zero(), up, hold, down, others="free", noise=True, seed=seed, **RELAXING)
    assert [step.end for step in ran.steps] == ["target"] * 4, ran.outcome
    # The load cell was tared with noise on it: what it shows counts, to the mean of a filter.
    cell = read_machine("biaxial-hook").load_cell.noise.value / sqrt(10.0 * FILTER)
    for number, force in ((1, UP), (2, UP), (3, 0.0)):
        assert abs(ran.of_step(number)[-1].force["C"] - force) < 2.0 * DEAD_BAND * cell
    assert ran.of_step(1)[-1].force["C"] != pytest.approx(UP, abs=1e-6)
    assert_no_jump(ran)


def test_an_axis_that_gives_way_from_now_on_is_let_go_no_faster_than_its_carriages_go(control: Control) -> None:
    ran = control(stretch(0.1, "W"), load(0.02, "C"), others="free")
    assert ran.outcome.end == "target"
    let_go = ran.of_step(1)
    assert ran.of_step(0)[-1].force["W"] > 0.05
    assert let_go[0].force["W"] > 0.01
    # The force that is controlled waits till then.
    waits = [row for row in let_go if row.force["W"] > 1e-4]
    assert all(abs(row.force["C"]) < 1e-4 for row in waits)
    assert abs(let_go[-1].force["W"]) < 1e-4
    assert_no_jump(ran)


@pytest.mark.slow
def test_a_fibre_that_breaks_under_a_controlled_force_ends_the_test_before_a_jump(control: Control) -> None:
    ran = control(load(0.9, "W", rate=0.1), Hold(duration=1.0), mount_along="W", material=BRITTLE, rupture="go on")
    assert (ran.outcome.end, [step.end for step in ran.steps]) == ("limit", ["limit"])
    assert "force on axis W" in ran.outcome.message
    assert ran.outcome.message.endswith("; travel: a fibre breaks there")
    assert ran.steps[0].message == ran.outcome.message
    assert ran.rows[-1].force["W"] == pytest.approx(0.1 * ran.rows[-1].time, rel=1.01 * FORCE_TOLERANCE)
    assert_no_jump(ran)


@pytest.mark.parametrize(
    ("noise", "force", "why"), [pytest.param(False, 0.5, "slack", marks=pytest.mark.slow), (True, 6e-3, "noise")]
)
def test_a_force_that_a_torn_knit_cannot_carry_names_slack_or_noise(
    noise: bool,  # noqa: FBT001
    force: float,
    why: str,
    control: Control,
) -> None:
    tear, back = UntilRupture(axes=("W",), rate=SPEED, drop=0.5), stretch(0.0, "W")
    knit = {"mount_along": "W", "material": BRITTLE, "rupture": "go on", "noise": noise, "increment": 0.05, "nodes": 24}
    ran = control(tear, back, load(force, "W", rate=0.1), **knit)
    assert [step.end for step in ran.steps] == ["rupture", "target", "limit"]
    assert f"; {why}: " in ran.steps[-1].message
    assert "the axis would have to jump by" in ran.steps[-1].message
    # Within the noise it may move by less than a step, and not by the jump.
    assert abs(ran.rows[-1].displacement["W"]) < INCREMENT * ran.rig.gauges["W"]


@pytest.mark.parametrize(
    ("until", "goes_to", "shows"),
    [
        (Until(force=0.01), 0.2, "axis C carries 0.0"),
        (Until(force=Bound(side=">", value=0.01)), 0.0, "axis C carries 0.0"),
        (Until(force=Bound(side="<", value=0.5)), 0.2, "axis C carries 0.0"),
        (Until(strain=0.05), 0.2, "axis C is at 0.1"),
        (Until(strain=0.15), 0.0, "axis C is at 0.1"),
        (Until(displacement=1e-3), 0.2, "axis C is at 1.6 mm"),
    ],
)
def test_what_is_met_when_a_step_begins_ends_it_at_once_and_is_said(
    until: Until, goes_to: float, shows: str, control: Control
) -> None:
    ran = control(stretch(0.1, "C"), stretch(goes_to, "C", until=until), stretch(0.12, "C"))
    assert [step.end for step in ran.steps] == ["target", "limit", "target"]
    assert ran.steps[1].start == ran.steps[1].time
    assert not ran.of_step(1)
    assert ran.steps[1].message.startswith("until ")
    assert f"was met as the step began: {shows}" in ran.steps[1].message
    assert ("for the other way say" in ran.steps[1].message) == (not isinstance(until.force, Bound))


def test_a_level_is_passed_downwards_where_a_ramp_lets_go_or_the_file_says_so(control: Control) -> None:
    low = 0.4 * control(stretch(0.1, "C")).rows[-1].force["C"]
    for until in (Until(force=low), Until(force=Bound(side="<", value=low))):
        ran = control(stretch(0.1, "C"), stretch(0.0, "C", until=until))
        assert ran.steps[1].end == "limit"
        assert ran.rows[-1].force["C"] == pytest.approx(low, rel=6e-3)


def test_a_guard_of_a_cycle_is_meant_upwards_on_its_way_back_too(control: Control) -> None:
    cycle = Cycle(axes=("C",), lower=0.0, upper=0.1, rate=SPEED, n=1, until=Until(force=1.0))
    ran = control(cycle)
    assert [step.end for step in ran.steps] == ["target"]
    assert ran.rows[-1].crosshead["C"] == 0.0
    by_force = Cycle(
        axes=("C",), lower=0.0, upper=0.02, rate=ForceRate(value=RATE), n=1, control="force", until=Until(strain=0.5)
    )
    assert [step.end for step in control(by_force).steps] == ["target"]


def test_loops_that_slip_off_are_no_rupture(control: Control) -> None:
    # Loops pulled round rigid wires without friction, of a yarn that cannot break.
    step = UntilRupture(axes=("W",), rate=5e-4, drop=0.5, to=Target(kind="strain", value=1.5))
    ran = control(step, Hold(duration=1.0), mount_along="W", hook="wire", friction=0.0, nodes=24)
    assert [one.end for one in ran.steps] == ["slipped", "target"]
    assert ran.outcome.end == "slipped"
    assert ran.outcome.message == ran.steps[0].message
    assert ran.outcome.message.endswith("though nothing broke: loops slipped or snapped")
    assert ran.rows[-1].bonds_broken == 0
    assert not ran.rig.severed
    assert ran.rows[-1].force["W"] <= 0.5 * ran.column("force", "W").max()


@pytest.mark.parametrize("start", [0.25, -0.04])
def test_a_preload_by_force_goes_to_zero_from_either_side_and_strain_counts_from_there(
    start: float, control: Control
) -> None:
    moved = Ramp(axes=("C",), to=Target(kind="strain", value=start), rate=SPEED)
    seek = Preload(axes=("C",), force=0.0, rate=ForceRate(value=0.02), control="force")
    zero = Zero(channels=("displacement",), gauge_length="here")
    ran = control(moved, seek, zero, mount_along="C", noise=False)
    assert [step.end for step in ran.steps] == ["target"] * 3
    before, after = ran.of_step(0)[-1], ran.of_step(1)[-1]
    assert before.force["C"] * start > 0.0
    assert abs(before.force["C"]) > 1e-3
    assert after.force["C"] == pytest.approx(0.0, abs=FINEST_DIGIT * ran.rig.trains["C"].digit * 1.01)
    assert (after.displacement["C"] - before.displacement["C"]) * start < 0.0
    (zeroing,) = [event for event in ran.events if isinstance(event, Zeroing)]
    assert zeroing.gauges["C"] == pytest.approx(ran.rig.gauges["C"] + after.displacement["C"])


def test_driven_at_a_speed_an_axis_has_no_way_to_zero_force() -> None:
    with pytest.raises(SpecificationError, match="from 0 with control: force"):
        Preload(axes=("C",), force=0.0, rate=SPEED)

"""What ends a step early: a time, a place, a force or a drop, on the side that the step goes or that is said."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from rigs.control.controller import Cell, Controller, Memory
from rigs.control.stop_criteria import TOLERANCE, StopCriteria
from rigs.instruments.channels import Channel
from rigs.protocol.strokes import History, Stroke
from rigs.protocol.targets import Bound, Until

if TYPE_CHECKING:
    from rigs.axes import Axis
    from rigs.protocol.targets import Side

GAUGES: dict[Axis, float] = {"C": 0.02, "W": 0.02}
CELL = Channel(name="Force", reads="force_C", kind="force", unit="N", limit=10.0, noise=1e-3, resolution=1e-3)
CONTROLLER = Controller(cells={"C": Cell(channel=CELL, rate=10.0)}, seed=0, noise=False)
MEMORY = replace(CONTROLLER.begin(History(origin={"C": 0.0, "W": 0.0}, gauges=GAUGES)), since=5.0)


def outwards(*, to: float = 2e-3, start: float = 0.0) -> Stroke:
    """Return a stroke of ten seconds along the course, from one displacement to another [m]."""
    return Stroke(
        start={"C": start, "W": 0.0},
        end={"C": to, "W": 0.0},
        duration=10.0,
        phase="Stretch" if to > start else "Recover",
        cycle=1,
        named=("C",),
        force={},
    )


def ends(until: Until | None, stroke: Stroke | None = None, *, pulls: bool = False) -> StopCriteria:
    """Return what ends the step of a stroke."""
    return StopCriteria(until=until, stroke=outwards() if stroke is None else stroke, gauges=GAUGES, pulls=pulls)


def shown(force: float, peak: float = 0.0) -> Memory:
    """Return what the controller remembers where the load cell shows a force, after a peak [N]."""
    return replace(MEMORY, shown={"C": force}, peak={"C": peak})


def test_a_step_without_conditions_runs_to_its_end() -> None:
    criteria = ends(None)
    assert criteria.cut(MEMORY, begun=5.0) == (1.0, None)
    assert criteria.met(CONTROLLER, shown(9.0), {"C": 1e-3}) is None
    assert criteria.met_before(shown(9.0), {"C": 1e-3}) is None
    assert criteria.excess(MEMORY, {"C": 9.0}, {"C": 1e-3}) == -math.inf


def test_time_counts_from_the_step_and_not_from_the_stroke() -> None:
    share, reason = ends(Until(time=12.0)).cut(MEMORY, begun=9.0)
    assert share == pytest.approx((5.0 + 12.0 - 9.0) / 10.0)
    assert reason is not None
    assert (reason.end, reason.message, reason.test) == ("timeout", "12 s passed", False)
    assert ends(Until(time=20.0)).cut(MEMORY, begun=9.0) == (1.0, None)


@pytest.mark.parametrize(
    ("until", "share", "message"),
    [
        (Until(strain=0.025), 0.25, "axis C is strained by 0.025"),
        (Until(displacement=1e-3), 0.5, "axis C is displaced by 1 mm"),
        (Until(strain=0.08, displacement=1e-3), 0.5, "axis C is displaced by 1 mm"),
        (Until(strain=0.08, time=3.0), 0.3, "3 s passed"),
    ],
)
def test_the_first_condition_on_the_way_cuts_the_stroke(until: Until, share: float, message: str) -> None:
    found, reason = ends(until).cut(MEMORY, begun=5.0)
    assert found == pytest.approx(share)
    assert reason is not None
    assert reason.message == message


def test_a_place_counts_from_the_last_zero() -> None:
    memory = replace(MEMORY, history=History(origin={"C": 1e-3, "W": 0.0}, gauges=GAUGES))
    share, _ = ends(Until(displacement=0.5e-3)).cut(memory, begun=5.0)
    assert share == pytest.approx(0.75)


@pytest.mark.parametrize(("side", "stroke"), [("<", outwards()), (">", outwards(to=0.0, start=2e-3))])
def test_a_place_on_the_other_side_is_passed_over(side: Side, stroke: Stroke) -> None:
    until = Until(strain=Bound(side=side, value=0.05))
    assert ends(until, stroke).cut(MEMORY, begun=5.0) == (1.0, None)


def test_a_force_is_met_within_the_tolerance_on_the_way_up() -> None:
    criteria = ends(Until(force=2.0))
    short = 2.0 * (1.0 - 1.1 * TOLERANCE)
    assert criteria.met(CONTROLLER, shown(short), {"C": 0.0}) is None
    reason = criteria.met(CONTROLLER, shown(2.0 * (1.0 - 0.9 * TOLERANCE)), {"C": 0.0})
    assert reason is not None
    assert (reason.end, reason.message) == ("limit", "axis C carries 2 N")
    assert criteria.excess(MEMORY, {"C": 3.0}, {"C": 0.0}) == pytest.approx(0.5)


def test_letting_go_ends_below_a_force() -> None:
    criteria = ends(Until(force=0.5), outwards(to=0.0, start=2e-3))
    assert criteria.met(CONTROLLER, shown(1.0), {"C": 0.0}) is None
    assert criteria.met(CONTROLLER, shown(0.4), {"C": 0.0}) is not None


def test_a_condition_met_as_the_step_begins_ends_it_and_names_the_other_side() -> None:
    reason = ends(Until(force=0.05)).met_before(shown(0.546), {"C": 0.0})
    assert reason is not None
    assert reason.message == (
        "until force > 0.05 N was met as the step began: axis C carries 0.546 N (for the other way say '< 0.05 N')"
    )
    said = ends(Until(force=Bound(side=">", value=0.05))).met_before(shown(0.546), {"C": 0.0})
    assert said is not None
    assert "say" not in said.message


@pytest.mark.parametrize(
    ("broken", "stroke", "end"),
    [(1, outwards(), "rupture"), (0, outwards(), "slipped"), (0, outwards(to=0.0, start=2e-3), "limit")],
)
def test_a_drop_is_a_rupture_where_something_broke_and_a_slip_where_nothing_did(
    broken: int, stroke: Stroke, end: str
) -> None:
    memory = replace(shown(0.7, peak=1.0), broken=broken)
    reason = ends(Until(drop=0.2), stroke).met(CONTROLLER, memory, {"C": 0.0})
    assert reason is not None
    assert reason.end == end
    assert reason.message.startswith("the force on axis C fell by 30% below its peak of 1 N")
    assert ends(Until(drop=0.4), stroke).met(CONTROLLER, memory, {"C": 0.0}) is None


def test_a_drop_from_a_peak_within_the_noise_does_not_count() -> None:
    assert ends(Until(drop=0.2)).met(CONTROLLER, shown(0.0, peak=4e-3), {"C": 0.0}) is None
    assert ends(Until(drop=0.2)).met(CONTROLLER, shown(0.0, peak=6e-3), {"C": 0.0}) is not None

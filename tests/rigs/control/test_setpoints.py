"""Setpoints of a stroke under control: what is asked of each axis at a share of it, and what is kept to resume."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from rigs.control.controller import controller_of
from rigs.control.planner import Planner
from rigs.control.resume_point import ResumePoint
from rigs.control.session import Session
from rigs.control.setpoint_search import Setpoint
from rigs.control.setpoints import FIRST_PACE, SLOWEST_PACE, setpoints_of
from rigs.control.stop_criteria import StopCriteria
from rigs.protocol.protocol import Ramp, Target
from rigs.protocol.strokes import Stroke

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.control.setpoints import Setpoints
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol

    Mount = Callable[..., tuple[Rig, State, Protocol]]

STEP = Ramp(axes=("C", "W"), to=Target(kind="strain", value=0.02), rate=2e-4)
STILL: dict[Axis, float] = {"C": 0.0, "W": 0.0}


@pytest.fixture
def session(mount_knit: Mount) -> Session:
    rig, state, protocol = mount_knit(STEP, nodes=16)
    controller = controller_of(rig, seed=0, noise=False)
    memory = controller.begin(Planner(protocol=protocol, gauges=rig.gauges).begin())
    return Session(rig=rig, state=state, controller=controller, increment=0.02, cursor=ResumePoint(memory=memory))


def of(session: Session, **parts: Any) -> Setpoints:  # noqa: ANN401 (parts of a stroke)
    """Return the setpoints of a stroke of ten seconds."""
    whole: dict[str, Any] = {
        "start": STILL,
        "end": STILL,
        "duration": 10.0,
        "phase": "Stretch",
        "cycle": 1,
        "named": ("C",),
        "force": {},
    }
    stroke = Stroke(**{**whole, **parts})
    return setpoints_of(session, stroke, StopCriteria(until=None, stroke=stroke, gauges=session.rig.gauges))


def test_a_place_is_asked_for_in_proportion(session: Session) -> None:
    points = of(session, end={"C": 4e-4, "W": 0.0})
    assert points.orders(0.25) == {"C": Setpoint(place=1e-4), "W": Setpoint(place=0.0)}
    assert points.longest == pytest.approx(0.02 * session.rig.gauges["C"] / 4e-4)
    assert not points.open_ended


def test_a_force_is_asked_for_as_the_tared_load_cell_shows_it(session: Session) -> None:
    session.remember(replace(session.memory, tare={"C": 0.5, "W": 0.0}))
    points = of(session, force={"C": (0.0, 2.0)})
    assert points.open_ended
    assert points.pace == FIRST_PACE
    assert points.orders(0.5)["C"] == Setpoint(force=1.0 + 0.5)
    assert points.orders(1.0)["C"] == Setpoint(force=2.0 + 0.5)
    assert points.orders(0.5)["W"] == Setpoint(place=0.0)


def test_an_axis_that_gives_way_is_let_go_before_the_stroke_begins(session: Session) -> None:
    goal = {axis: 0.02 * length for axis, length in session.rig.gauges.items()}
    stroke = of(session).stroke
    row = session.accept(session.reach(goal), stroke, goal)
    points = of(session, start=goal, end=goal, free=("W",))
    assert points.share == -1.0
    assert points.orders(-1.0)["W"] == Setpoint(force=row.force["W"])
    assert points.orders(-0.5)["W"] == Setpoint(force=0.5 * row.force["W"])
    assert points.orders(0.5)["W"] == Setpoint(force=0.0)
    assert points.time(-0.5) == session.cursor.begun
    assert points.finest() == SLOWEST_PACE


def test_an_axis_that_follows_is_tied_to_its_leader(session: Session) -> None:
    points = of(session, force={"C": (0.0, 1.0)}, follow="C")
    assert points.orders(0.5)["W"] == Setpoint(place=0.0, leader="C", lead=0.0)


def test_an_axis_that_met_the_force_of_a_preload_stays(session: Session) -> None:
    points = of(session, end={"C": 1e-3, "W": 1e-3}, named=("C", "W"), stop_force=0.5)
    session.remember(replace(session.memory, shown={"C": 0.6, "W": 0.1}))
    session.crosshead = {"C": 3e-4, "W": 3e-4}
    assert not points.stop()
    assert points.orders(0.5) == {"C": Setpoint(place=3e-4), "W": Setpoint(place=5e-4)}
    session.remember(replace(session.memory, shown={"C": 0.6, "W": 0.6}))
    assert points.stop()


def test_an_accepted_force_is_met_and_the_stroke_is_resumed_from_what_is_kept(session: Session) -> None:
    points = of(session, force={"C": (0.0, 0.02)})
    found = points.settle(0.25)
    assert found.met
    row = points.accept(found, 0.25, STILL)
    assert row.force["C"] == pytest.approx(0.005, rel=0.03)  # the cell shows whole mN
    assert row.time == session.time == pytest.approx(2.5)
    again = of(session, force={"C": (0.0, 0.02)})
    for name in ("share", "late", "stopped", "carried", "trend"):
        assert getattr(again, name) == getattr(points, name), name
    assert again.pace == pytest.approx(points.pace)
    assert again.slope is not None
    assert points.slope is not None
    np.testing.assert_array_equal(again.slope, points.slope)

"""A session: the specimen's state, the row that each accepted equilibrium gives, and where the test can be resumed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigs.control.controller import controller_of
from rigs.control.planner import Planner
from rigs.control.resume_point import END, START, ResumePoint
from rigs.control.session import FRAME_SPACING, Session
from rigs.protocol.protocol import Ramp, Target
from rigs.protocol.strokes import Stroke

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.instruments.channels import Instrument
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol

    Mount = Callable[..., tuple[Rig, State, Protocol]]

STEP = Ramp(axes=("C", "W"), to=Target(kind="strain", value=0.02), rate=2e-4)
STROKE = Stroke(
    start={"C": 0.0, "W": 0.0},
    end={"C": 1e-4, "W": 1e-4},
    duration=1.0,
    phase="Stretch",
    cycle=3,
    step=1,
    tag="up",
    named=("C", "W"),
    force={},
)


@pytest.fixture
def session(mount_knit: Mount) -> Session:
    rig, state, protocol = mount_knit(STEP, nodes=16)
    controller = controller_of(rig, seed=0, noise=False)
    memory = controller.begin(Planner(protocol=protocol, gauges=rig.gauges).begin())
    return Session(rig=rig, state=state, controller=controller, increment=0.02, cursor=ResumePoint(memory=memory))


def at(session: Session, strain: float) -> dict[Axis, float]:
    """Return the displacements of a strain of both axes [m]."""
    return {axis: strain * length for axis, length in session.rig.gauges.items()}


def test_a_session_begins_where_the_specimen_was_mounted(session: Session) -> None:
    assert session.displacement == session.crosshead == {"C": 0.0, "W": 0.0}
    assert (session.time, session.last, session.over()) == (0.0, None, None)
    assert session.checkpoint() is None
    with pytest.raises(RuntimeError, match="mounted"):
        session.stand(STROKE)


def test_an_equilibrium_that_is_only_looked_at_changes_nothing(session: Session) -> None:
    state, goal = session.state, at(session, 0.01)
    found = session.reach(goal)
    assert found.displacement == pytest.approx(goal)
    assert session.state is state
    assert session.displacement == {"C": 0.0, "W": 0.0}
    assert session.uncounted().iterations > 0


def test_a_row_has_what_it_cost_and_the_labels_of_its_stroke(session: Session) -> None:
    goal = at(session, 0.01)
    spent = (found := session.reach(goal), session.uncounted())[1]
    session.time = 1.5
    row = session.accept(found, STROKE, goal)
    assert (row.time, row.cycle, row.phase, row.tag, row.step) == (1.5, 3, "Stretch", "up", 1)
    assert (row.iterations, row.factorisations) == (spent.iterations, spent.factorisations)
    assert session.uncounted().iterations == 0
    assert session.last is row
    assert session.memory.shown == pytest.approx(row.force)
    assert min(row.force.values()) > 0.0
    # Nothing but the two axes does work, and printed yarn begins without energy.
    stored = row.elastic_stretch + row.elastic_bend + row.elastic_twist + row.contact_energy
    assert row.external_work == pytest.approx(stored + row.friction_work, rel=1e-2)


def test_a_specimen_that_stands_gives_its_last_row_at_no_cost(session: Session) -> None:
    goal = at(session, 0.01)
    moved = session.accept(session.reach(goal), STROKE, goal)
    session.time = 7.0
    row = session.stand(replace(STROKE, phase="Hold"))
    assert row == replace(moved, time=7.0, phase="Hold", iterations=0, factorisations=0, seconds=0.0)
    assert session.cursor.place == END


def test_segments_before_the_one_under_way_are_not_made_again(session: Session) -> None:
    session.begin(session.readings())
    goal = at(session, 0.01)
    made = []
    for segment in session.segments("abc"):
        made.append(segment)
        if segment == "b":
            session.displacement = goal
    assert made == ["a", "b", "c"]
    assert (session.cursor.segment, session.cursor.origin, session.cursor.place) == (2, goal, START)
    session.cursor = replace(session.cursor, segment=1)
    assert list(session.segments("abc")) == ["b", "c"]


def test_frames_are_passed_at_whole_multiples_of_their_spacing(session: Session) -> None:
    before, session.displacement = at(session, 0.9 * FRAME_SPACING), at(session, 0.95 * FRAME_SPACING)
    assert not session.passes_frame(before)
    session.displacement = at(session, 1.05 * FRAME_SPACING)
    assert session.passes_frame(before)


def test_a_frame_shows_the_knit_where_it_is(session: Session) -> None:
    goal = at(session, 0.02)
    session.accept(session.reach(goal), STROKE, goal)
    frame = session.pictured(None)
    assert (frame.image, frame.phase, frame.cycle) == ("image", "Stretch", 3)
    assert frame.strain == pytest.approx({"C": 0.02, "W": 0.02})
    moved = np.ptp(frame.nodes, axis=0) - np.ptp(session.rig.specimen.nodes, axis=0)
    assert moved[0] > 0.0
    assert moved[1] > 0.0


def test_a_reading_beyond_its_limit_ends_the_test(session: Session) -> None:
    goal = at(session, 0.01)
    session.accept(session.reach(goal), STROKE, goal)
    assert session.over() is None

    def weaker(instrument: Instrument) -> Instrument:
        channels = (replace(one, limit=1e-9 if one.kind == "force" else one.limit) for one in instrument.channels)
        return replace(instrument, channels=tuple(channels))

    session.rig = replace(session.rig, instruments=tuple(map(weaker, session.rig.instruments)))
    reason = session.over()
    assert reason is not None
    assert (reason.end, reason.test) == ("limit", True)
    assert reason.message == "XForce passed its limit of 1e-09 N at strain C 1.0%, W 1.0%"
    assert session.checkpoint() is None

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas.machine_data import read_machine
from knitlab_core.equilibrium.newton import Options
from rigs.control.experiment import perform
from rigs.instruments.zeros import Zeroing
from rigs.protocol.protocol import Cycle, Hold, Preload, Ramp, Repeat, Target, Zero
from rigs.record import Equilibrium, Frame, Outcome
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.control.experiment import Event
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol

    Mount = Callable[..., tuple[Rig, State, Protocol]]

SPEED = 2e-4
# One iteration is enough for a slack knit only.
HASTY = Options(max_iterations=1)


@dataclass
class Happened:
    """What a test yielded, sorted."""

    stage: Rig
    rows: list[Equilibrium] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)
    zeroings: list[Zeroing] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)

    def keep(self, event: Event) -> None:
        match event:
            case Equilibrium():
                self.rows.append(event)
            case Frame():
                self.frames.append(event)
            case Zeroing():
                self.zeroings.append(event)
            case Outcome():
                self.outcomes.append(event)

    @property
    def outcome(self) -> Outcome:
        (outcome,) = self.outcomes
        return outcome

    @property
    def counts(self) -> tuple[int, int]:
        """Return the iterations and factorisations that rows and outcome account for."""
        rest = self.outcome.unfinished
        return (
            sum(row.iterations for row in self.rows) + rest.iterations,
            sum(row.factorisations for row in self.rows) + rest.factorisations,
        )

    def strain(self, row: Equilibrium, axis: Axis) -> float:
        return row.displacement[axis] / self.stage.gauges[axis]


def both(strain: float) -> Ramp:
    return Ramp(axes=("C", "W"), to=Target(kind="strain", value=strain), rate=SPEED)


@pytest.fixture
def happen(mount_knit: Mount) -> Callable[..., Happened]:
    def run(*steps: object, options: Options | None = None, **knit: object) -> Happened:
        stage, state, protocol = mount_knit(*steps, **knit)
        happened = Happened(stage)
        for event in perform(stage, state, protocol, options=options):
            assert not happened.outcomes, "an outcome comes last"
            happened.keep(event)
        assert happened.counts == (stage.work.clock.iterations, stage.work.clock.factorisations)
        return happened

    return run


def test_a_ramp_goes_exactly_where_it_should(happen: Callable[..., Happened]) -> None:
    ran = happen(Zero(), both(0.05), both(-0.01))
    assert ran.outcome == Outcome(end="target")
    assert [row.phase for row in ran.rows] == ["Zero"] + ["Stretch"] * 3 + ["Recover"] * 4
    for axis in BOTH:
        strains = [ran.strain(row, axis) for row in ran.rows]
        assert max(strains) == pytest.approx(0.05, abs=1e-15)
        assert strains[-1] == pytest.approx(-0.01, abs=1e-15)
        assert np.abs(np.diff(strains)).max() <= 0.02 + 1e-12
    longest = max(ran.stage.gauges.values())
    assert ran.rows[3].time == pytest.approx(0.05 * longest / SPEED)
    assert ran.rows[-1].time == pytest.approx(0.11 * longest / SPEED)


def test_an_axis_that_is_not_named_stays_exactly_where_it_is(happen: Callable[..., Happened]) -> None:
    ran = happen(both(0.03), Ramp(axes=("C",), to=Target(kind="displacement", value=2e-3), rate=SPEED))
    held = {row.displacement["W"] for row in ran.rows[2:]}
    assert held == {0.03 * ran.stage.gauges["W"]}
    assert ran.rows[-1].displacement["C"] == 2e-3


def test_cycles_and_repeats_count_their_sets(happen: Callable[..., Happened]) -> None:
    cycle = Cycle(axes=("C",), lower=0.0, upper=0.04, rate=SPEED, n=2, tag="twice")
    ran = happen(Repeat(n=2, steps=(cycle,)))
    turns = [(row.cycle, row.phase, round(ran.strain(row, "C"), 12)) for row in ran.rows[2::2]]
    assert turns == [(k, phase, peak) for k in (1, 2, 3, 4) for phase, peak in (("Stretch", 0.04), ("Recover", 0.0))]
    assert {row.tag for row in ran.rows[1:]} == {"twice"}


def test_a_hold_keeps_the_equilibrium_it_starts_from(happen: Callable[..., Happened]) -> None:
    ran = happen(both(0.28), Hold(duration=30.0, tag="still"))
    before, after = ran.rows[-2:]
    assert after.time - before.time == pytest.approx(30.0)
    idle = replace(before, iterations=0, factorisations=0, seconds=0.0)
    assert after == replace(idle, time=after.time, phase="Hold", tag="still", step=1)
    assert before.force["C"] > 0.01


def test_zeroing_says_when_and_what(happen: Callable[..., Happened]) -> None:
    ran = happen(Zero(), both(0.02), Zero(channels=("displacement",)), both(0.02))
    assert [(zeroing.time, zeroing.kinds) for zeroing in ran.zeroings] == [
        (0.0, frozenset({"force", "displacement"})),
        (ran.rows[1].time, frozenset({"displacement"})),
    ]
    # A target counts from the last zero.
    assert ran.strain(ran.rows[-1], "C") == pytest.approx(0.04)
    assert [row.phase for row in ran.rows] == ["Zero", "Stretch", "Zero", "Stretch"]


def test_frames_at_the_start_at_20_percent_marks_and_where_strokes_end(happen: Callable[..., Happened]) -> None:
    ran = happen(Zero(), Cycle(axes=("C", "W"), lower=0.0, upper=0.25, rate=SPEED, n=1), increment=0.03)
    marked = [frame for frame in ran.frames if round(frame.strain["C"], 14) in {0.0, 0.2, 0.25}]
    assert [round(frame.strain["C"], 14) for frame in marked] == [0.0, 0.2, 0.25, 0.2, 0.0]
    assert [frame.phase for frame in marked] == ["Zero", "Stretch", "Stretch", "Recover", "Recover"]
    # Between them, a frame for every 2.5 % or where the next equilibrium is, each at a time of its own.
    strains = np.array([frame.strain["C"] for frame in ran.frames])
    assert np.abs(np.diff(strains)).max() <= 0.025 + 0.03
    assert len(ran.frames) <= 2 * 10 + 5
    assert len({frame.time for frame in ran.frames}) == len(ran.frames)
    times = {row.time for row in ran.rows}
    assert all(frame.time in times for frame in ran.frames)
    assert ran.frames[0].nodes == pytest.approx(ran.stage.specimen.nodes, abs=1e-12)


@pytest.mark.parametrize("force", [0.02, 0.2])
def test_a_preload_stops_every_axis_at_its_force(happen: Callable[..., Happened], force: float) -> None:
    ran = happen(Zero(), Preload(axes=("C", "W"), force=force, rate=SPEED, tag="pre"))
    assert ran.outcome.end == "target"
    loads = {axis: np.array([row.force[axis] for row in ran.rows]) for axis in BOTH}
    ways = {axis: np.array([ran.strain(row, axis) for row in ran.rows]) for axis in BOTH}
    stops = {axis: int(np.argmax(ways[axis])) for axis in BOTH}
    for axis in BOTH:
        # Where an axis stops it carries the force; the other may add to it later, none overshoots.
        assert loads[axis][stops[axis]] == pytest.approx(force, rel=5e-3)
        assert np.all(loads[axis][: stops[axis]] < force)
        assert np.all(ways[axis][stops[axis] :] == ways[axis][stops[axis]])
    assert max(stops.values()) == len(ran.rows) - 1
    rows = ran.rows
    assert {row.phase for row in rows[1:]} == {"Preload"}
    assert rows[-1].time == pytest.approx(
        max(ways[axis][-1] * ran.stage.gauges[axis] for axis in BOTH) / SPEED, rel=0.2
    )


def test_a_preload_that_is_met_already_moves_nothing(happen: Callable[..., Happened]) -> None:
    ran = happen(both(0.28), Preload(axes=("C",), force=0.01, rate=SPEED), both(0.28))
    assert ran.outcome.end == "target"
    assert {row.phase for row in ran.rows} == {"Zero", "Stretch"}


def test_a_preload_out_of_reach_is_a_limit(happen: Callable[..., Happened]) -> None:
    # One loop drawn along its yarn alone, with no row to catch it, carries next to nothing.
    ran = happen(Preload(axes=("C",), force=50.0, rate=SPEED), rows=1, loops=2, increment=0.05)
    assert ran.outcome.end == "limit"
    assert re.fullmatch(r"preload of 50 N not met within a strain of 0\.5: axis C carries \S+ N", ran.outcome.message)
    assert ran.strain(ran.rows[-1], "C") == pytest.approx(0.5)


@pytest.mark.parametrize("step", [both(0.3), Preload(axes=("C", "W"), force=10.0, rate=SPEED)])
def test_an_overload_ends_the_test_and_keeps_its_rows(happen: Callable[..., Happened], step: Ramp | Preload) -> None:
    data = read_machine("biaxial-hook")
    cell = replace(data.load_cell, limit=replace(data.load_cell.limit, value=0.05))
    ran = happen(step, data=replace(data, load_cell=cell))
    assert ran.outcome.end == "limit"
    assert re.fullmatch(r"[XY]Force passed its limit of 0\.05 N at strain C \d+\.\d%, W \d+\.\d%", ran.outcome.message)
    loads = [max(row.force.values()) for row in ran.rows]
    assert loads[-1] > 0.05
    assert max(loads[:-1]) <= 0.05
    assert ran.frames[-1].time == ran.rows[-1].time


def test_travel_has_its_limit_too(happen: Callable[..., Happened]) -> None:
    data = read_machine("biaxial-hook")
    encoder = replace(data.encoder, limit=replace(data.encoder.limit, value=1e-3))
    ran = happen(
        Ramp(axes=("C",), to=Target(kind="strain", value=0.1), rate=SPEED), data=replace(data, encoder=encoder)
    )
    assert ran.outcome.end == "limit"
    assert ran.outcome.message.startswith("XDisplacement passed its limit of 0.001 m")


def test_a_test_that_diverges_keeps_its_rows_and_names_the_place(
    happen: Callable[..., Happened], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Rescues are tried elsewhere.
    monkeypatch.setattr("knitlab_core.equilibrium.continuation.MOST_ITERATIONS", 0)
    monkeypatch.setattr("knitlab_core.equilibrium.march.MOST_MOVES", 2)
    ran = happen(both(0.05), both(0.4), options=HASTY)
    assert ran.outcome.end == "diverged"
    assert len(ran.rows) > 3
    assert ran.outcome.unfinished.iterations > ran.rows[-1].iterations
    assert re.fullmatch(
        r"no equilibrium beyond strain C \d+\.\d%, W \d+\.\d%: after \d+ iterations at the shortest step \S+ of the "
        r"mean fixture force is left at node \d+ \(x -?[\d.]+, y -?[\d.]+, z -?[\d.]+ mm\), "
        r"(row \d, loop \d|turn-around from row \d to row \d, (first|second) half) of the yarn",
        ran.outcome.message,
    )
    assert ran.frames[-1].time == ran.rows[-1].time
    assert all(row.residual < 1e-4 for row in ran.rows)


def test_time_and_effort_stand_in_every_row(happen: Callable[..., Happened]) -> None:
    ran = happen(both(0.1))
    for row in ran.rows[1:]:
        assert row.seconds > 0.0
        assert row.iterations >= 1
        assert row.factorisations >= row.iterations


def test_energy_comes_from_work_in_si(happen: Callable[..., Happened]) -> None:
    ran = happen(both(0.3), increment=0.01)
    rows = ran.rows
    # The carriages' work by the trapezium rule on what the record itself says.
    work = sum(
        0.5 * (b.force[axis] + a.force[axis]) * (b.displacement[axis] - a.displacement[axis])
        for a, b in pairwise(rows)
        for axis in BOTH
    )
    last = rows[-1]
    stored = last.elastic_stretch + last.elastic_bend + last.elastic_twist + last.contact_energy
    assert last.external_work == pytest.approx(work, rel=1e-3)
    assert last.external_work == pytest.approx(stored + last.friction_work, rel=0.01)

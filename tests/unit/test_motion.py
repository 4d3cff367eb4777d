from __future__ import annotations

from typing import Literal

import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, planar_specimen
from rigs.motion import (
    PRELOAD_REACH,
    Stroke,
    planned_duration,
    planned_rows,
    planned_strokes,
    strokes,
)
from rigs.protocol import (
    Axis,
    Cycle,
    Hold,
    LogSpec,
    Preload,
    Protocol,
    Ramp,
    Repeat,
    SpecimenSpec,
    Step,
    Target,
    Zero,
)
from rigs.specimen import gauge_lengths

GAUGES: dict[Axis, float] = {"C": 0.05, "W": 0.04}
SPECIMEN = SpecimenSpec(knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM")
BOTH: tuple[Axis, ...] = ("C", "W")


def protocol(*steps: Step, speed_ref: Literal["pair", "grip"] = "pair", rate: float = 10.0) -> Protocol:
    return Protocol(
        specimen=SPECIMEN, speed_ref=speed_ref, others="hold", steps=steps, log=LogSpec(rate=rate, noise=False)
    )


def test_hooks_are_as_far_apart_as_the_sites_of_the_printed_yarn() -> None:
    stitch = NAMED_STITCHES["stockinette-default"]
    coarse, fine = (
        gauge_lengths(planar_specimen(stitch, rows=2, loops=3, loop_width=8e-3, nodes_per_loop=nodes))
        for nodes in (12, 48)
    )
    assert coarse == pytest.approx(fine, rel=1e-12)
    assert coarse["C"] == pytest.approx(3 * 8e-3)


def to_strain(strain: float, *axes: Axis, tag: str | None = None) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=strain), rate=2e-4, tag=tag)


def all_strokes(plan: Protocol) -> list[Stroke]:
    return list(strokes(plan, GAUGES))


def test_axes_driven_together_arrive_together_at_the_rate_of_the_longest_way() -> None:
    (stroke,) = all_strokes(protocol(to_strain(0.4, "C", "W")))
    assert stroke.end == {"C": pytest.approx(0.02), "W": pytest.approx(0.016)}
    assert stroke.duration == pytest.approx(0.02 / 2e-4)
    assert stroke.phase == "Stretch"


def test_others_hold_where_they_are() -> None:
    first, second = all_strokes(protocol(to_strain(0.2, "W"), to_strain(0.4, "C")))
    assert first.end == {"C": 0.0, "W": pytest.approx(0.008)}
    assert second.start == first.end
    assert second.end["W"] == first.end["W"]


def test_the_rate_of_a_grip_is_half_that_of_its_pair() -> None:
    pair = planned_duration(protocol(to_strain(0.4, "C")), GAUGES)
    grip = planned_duration(protocol(to_strain(0.4, "C"), speed_ref="grip"), GAUGES)
    assert pair == pytest.approx(2.0 * grip)


def test_where_one_grip_stands_the_rate_of_a_grip_is_that_of_its_pair() -> None:
    ramp = to_strain(0.4, "W")
    pair, grip = (
        Protocol(specimen=SPECIMEN, rig="uniaxial-frame", mount="W", others="free", speed_ref=which, steps=(ramp,))
        for which in ("pair", "grip")
    )
    assert planned_duration(pair, {"W": 0.04}) == planned_duration(grip, {"W": 0.04}) == pytest.approx(80.0)
    assert next(strokes(pair, {"W": 0.04})).end == {"W": pytest.approx(0.016)}


def test_a_cycle_is_a_stretch_and_a_recovery_each_time_and_the_set_counts_up() -> None:
    cycle = Cycle(axes=BOTH, lower=0.0, upper=0.4, rate=2e-4, n=3, tag="main")
    plan = all_strokes(protocol(Zero(), cycle))
    assert [(one.phase, one.cycle) for one in plan] == [
        ("Zero", 1),
        ("Stretch", 1),
        ("Recover", 1),
        ("Stretch", 2),
        ("Recover", 2),
        ("Stretch", 3),
        ("Recover", 3),
    ]
    assert [one.tag for one in plan] == [None] + ["main"] * 6
    assert plan[0].channels == ("force", "displacement")
    assert plan[-1].end == {"C": 0.0, "W": 0.0}


def test_a_hold_belongs_to_the_set_before_it() -> None:
    plan = all_strokes(protocol(to_strain(0.1, "C"), to_strain(0.0, "C"), Hold(duration=5.0), to_strain(0.1, "C")))
    assert [(one.phase, one.cycle) for one in plan] == [("Stretch", 1), ("Recover", 1), ("Hold", 1), ("Stretch", 2)]
    assert plan[2].start == plan[2].end
    assert plan[2].duration == 5.0


def test_repeats_nest() -> None:
    inner = Repeat(n=2, steps=(to_strain(0.1, "C"), to_strain(0.0, "C")))
    plan = all_strokes(protocol(Repeat(n=3, steps=(inner, Hold(duration=1.0)))))
    assert [one.phase for one in plan] == (["Stretch", "Recover"] * 2 + ["Hold"]) * 3
    assert plan[-1].cycle == 6


def test_a_ramp_to_where_the_axes_stand_makes_no_stroke() -> None:
    assert all_strokes(protocol(to_strain(0.0, "C"))) == []


def test_displacement_targets_are_of_the_pair() -> None:
    ramp = Ramp(axes=("W",), to=Target(kind="displacement", value=0.003), rate=1e-3)
    (stroke,) = all_strokes(protocol(ramp))
    assert stroke.end == {"C": 0.0, "W": 0.003}
    assert stroke.duration == pytest.approx(3.0)


def test_strokes_start_from_what_was_reached() -> None:
    plan = strokes(
        protocol(Preload(axes=("C",), force=0.05, rate=1e-4), Zero(), to_strain(0.1, "C")),
        GAUGES,
    )
    preload = next(plan)
    assert (preload.phase, preload.stop_force) == ("Preload", 0.05)
    assert preload.end["C"] == pytest.approx(PRELOAD_REACH * GAUGES["C"])
    zero = plan.send({"C": 0.001, "W": 0.0})
    assert zero.start == {"C": 0.001, "W": 0.0}
    ramp = plan.send(zero.end)
    # The zero moves the origin: 10 % of 50 mm from where the preload ended.
    assert ramp.end["C"] == pytest.approx(0.001 + 0.005)


def test_a_zero_of_force_leaves_the_origin_of_strain() -> None:
    plan = all_strokes(protocol(to_strain(0.1, "C"), Zero(channels=("force",)), to_strain(0.2, "C")))
    assert plan[-1].end["C"] == pytest.approx(0.2 * GAUGES["C"])


def test_a_plan_takes_a_preload_to_end_at_once_but_counts_its_time() -> None:
    plan = protocol(Preload(axes=("C",), force=0.05, rate=1e-4), to_strain(0.1, "C"))
    assert planned_strokes(plan, GAUGES)[1].start == {"C": 0.0, "W": 0.0}
    assert planned_duration(plan, GAUGES) == pytest.approx(PRELOAD_REACH * 0.05 / 1e-4 + 0.1 * 0.05 / 2e-4)


def test_rows_are_one_at_the_start_and_one_a_tick() -> None:
    assert planned_rows(protocol(Hold(duration=10.0)), GAUGES) == 101
    assert planned_rows(protocol(Hold(duration=10.05)), GAUGES) == 101
    assert planned_rows(protocol(*[Hold(duration=0.1)] * 3), GAUGES) == 4


def test_a_log_without_end_is_refused() -> None:
    with pytest.raises(SpecificationError, match=r"log\.rate: .*10000000 rows or fewer"):
        planned_rows(protocol(Hold(duration=1e7), rate=1e4), GAUGES)


def test_hooks_cannot_pass_through_each_other() -> None:
    ramp = Ramp(axes=("W",), to=Target(kind="displacement", value=-0.05), rate=1e-3)
    with pytest.raises(SpecificationError, match="axis W"):
        all_strokes(protocol(ramp))

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, knit_specimen
from rigs.control.plan import planned_duration, planned_images, planned_rows, planned_steps
from rigs.control.planner import Planner
from rigs.protocol.made_specimen import gauge_lengths
from rigs.protocol.protocol import (
    Cycle,
    ForceRate,
    Hold,
    Image,
    LogSpec,
    Preload,
    Protocol,
    Ramp,
    Repeat,
    SpecimenSpec,
    Step,
    StrainRate,
    Target,
    Until,
    UntilRupture,
    Waveform,
    Zero,
)
from rigs.protocol.strokes import PRELOAD_REACH, History, Readings, Situation, Stroke
from rigs.protocol.unrolled import unrolled
from tests.planned import planned_strokes

if TYPE_CHECKING:
    from rigs.axes import Axis

GAUGES: dict[Axis, float] = {"C": 0.05, "W": 0.04}
SPECIMEN = SpecimenSpec(knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM")
BOTH: tuple[Axis, ...] = ("C", "W")


def protocol(
    *steps: Step | Repeat,
    speed_ref: Literal["pair", "grip"] = "pair",
    rate: float = 10.0,
    others: Literal["hold", "free", "follow"] = "hold",
) -> Protocol:
    return Protocol(
        specimen=SPECIMEN, speed_ref=speed_ref, others=others, steps=steps, log=LogSpec(rate=rate, noise=False)
    )


def test_hooks_are_as_far_apart_as_the_sites_of_the_printed_yarn() -> None:
    stitch = NAMED_STITCHES["stockinette-default"]
    coarse, fine = (
        gauge_lengths(knit_specimen(stitch, rows=2, loops=3, loop_width=8e-3, nodes_per_loop=nodes))
        for nodes in (12, 48)
    )
    assert coarse == pytest.approx(fine, rel=1e-12)
    assert coarse["C"] == pytest.approx(3 * 8e-3)


def to_strain(strain: float, *axes: Axis, tag: str | None = None) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=strain), rate=2e-4, tag=tag)


def all_strokes(plan: Protocol) -> list[Stroke]:
    return planned_strokes(plan, {axis: GAUGES[axis] for axis in plan.axes})


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
    assert all_strokes(pair)[0].end == {"W": pytest.approx(0.016)}


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


def test_strokes_start_from_what_the_controller_sees() -> None:
    plan = protocol(Preload(axes=("C",), force=0.05, rate=1e-4), Zero(), to_strain(0.1, "C"))
    planner, (preload_step, zero_step, ramp_step) = Planner(protocol=plan, gauges=GAUGES), unrolled(plan.steps)
    readings = Readings(displacement={"C": 0.0, "W": 0.0}, force={"C": 0.0, "W": 0.0})
    history = planner.begin()
    preload = planner.stroke(preload_step, 0, history, readings)
    assert preload is not None
    assert (preload.phase, preload.stop_force) == ("Preload", 0.05)
    assert preload.end["C"] == pytest.approx(PRELOAD_REACH * GAUGES["C"])
    met = Readings(displacement={"C": 0.001, "W": 0.0}, force={"C": 0.05, "W": 0.0})
    zero = planner.stroke(zero_step, 0, history.after(preload, met), met)
    assert zero is not None
    assert zero.start == {"C": 0.001, "W": 0.0}
    ramp = planner.stroke(ramp_step, 0, history.after(zero, met), met)
    # The zero moves the origin: 10 % of 50 mm from where the preload ended.
    assert ramp is not None
    assert ramp.end["C"] == pytest.approx(0.001 + 0.005)


def test_a_zero_of_force_leaves_the_origin_of_strain() -> None:
    plan = all_strokes(protocol(to_strain(0.1, "C"), Zero(channels=("force",)), to_strain(0.2, "C")))
    assert plan[-1].end["C"] == pytest.approx(0.2 * GAUGES["C"])


def after_zeros(*zeros: Zero) -> Situation:
    """Return what a step is told after zeros with the hooks 5 mm and 2 mm farther apart, the crossheads 6 and 2."""
    planner = Planner(protocol=protocol(*zeros, to_strain(0.1, "C")), gauges=GAUGES)
    readings = Readings(displacement={"C": 6e-3, "W": 2e-3}, opening={"C": 5e-3, "W": 2e-3}, force={"C": 0.1, "W": 0.1})
    history = planner.begin()
    for leaf in list(unrolled(planner.protocol.steps))[:-1]:
        stroke = planner.stroke(leaf, 0, history, readings)
        assert stroke is not None
        history = history.after(stroke, readings)
    return Situation(printed=GAUGES, gears={"C": 1, "W": 1}, others="follow", history=history, readings=readings)


def test_strain_counts_by_the_gauge_length_that_the_last_zero_took() -> None:
    situation = after_zeros(Zero(gauge_length="here"))
    # Hooks 55 mm and 42 mm apart: a calliper does not see that the machine gave way by 1 mm.
    assert situation.gauges == pytest.approx({"C": 0.055, "W": 0.042})
    stroke = situation.drive(("C",), StrainRate(value=0.01), Target(kind="strain", value=0.1))
    assert stroke is not None
    assert stroke.end["C"] == pytest.approx(6e-3 + 0.1 * 0.055)
    assert stroke.end["W"] == pytest.approx(2e-3 + 0.1 * 0.042)  # it follows
    assert stroke.duration == pytest.approx(10.0)
    assert situation.drive(("C",), StrainRate(value=0.01), None, reach=0.2).duration == pytest.approx(20.0)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("zeros", "gauges"),
    [
        ([Zero()], GAUGES),
        ([Zero(gauge_length="printed")], GAUGES),
        ([Zero(gauge_length="here"), Zero(channels=("force",))], {"C": 0.055, "W": 0.042}),
        ([Zero(gauge_length="here"), Zero()], {"C": 0.055, "W": 0.042}),
        ([Zero(gauge_length="here"), Zero(gauge_length="printed")], GAUGES),
    ],
)
def test_a_zero_that_says_nothing_of_it_keeps_the_gauge_length(zeros: list[Zero], gauges: dict[Axis, float]) -> None:
    situation = after_zeros(*zeros)
    assert situation.gauges == pytest.approx(gauges)


def test_hooks_do_not_pass_whatever_the_gauge_length() -> None:
    situation = replace(after_zeros(Zero(gauge_length="here")), others="hold")
    nearly = situation.move(("C",), Target(kind="displacement", value=-55.9e-3))
    assert nearly.end["C"] > -GAUGES["C"]
    with pytest.raises(SpecificationError, match=r"above -0\.05 m"):
        situation.move(("C",), Target(kind="displacement", value=-56.1e-3))


def test_a_gauge_length_is_taken_where_strain_is_zero() -> None:
    with pytest.raises(SpecificationError, match=r"gauge_length: found .*force.*, allowed .*displacement"):
        Zero(channels=("force",), gauge_length="here")


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


def test_others_follow_with_the_same_strain() -> None:
    (stroke,) = all_strokes(protocol(to_strain(0.4, "W"), others="follow"))
    assert stroke.end == {"C": pytest.approx(0.02), "W": pytest.approx(0.016)}
    # The rate is that of the axis that is named.
    assert stroke.duration == pytest.approx(0.016 / 2e-4)


def test_others_that_give_way_stay_so_while_the_named_axis_is_held() -> None:
    ramp, hold = all_strokes(protocol(to_strain(0.4, "W"), Hold(duration=1.0), others="free"))
    assert ramp.free == hold.free == ("C",)


def test_a_strain_rate_and_a_force_rate_set_the_time() -> None:
    strain = Ramp(axes=("C", "W"), to=Target(kind="strain", value=0.4), rate=StrainRate(value=1e-2))
    force = Ramp(axes=("C",), to=Target(kind="force", value=2.0), rate=ForceRate(value=0.5))
    back = Cycle(axes=("C",), lower=0.5, upper=1.0, rate=ForceRate(value=0.5), n=1, control="force")
    plan = all_strokes(protocol(strain, force, back))
    assert [stroke.duration for stroke in plan] == pytest.approx([40.0, 4.0, 2.0, 1.0])
    assert [stroke.force for stroke in plan[1:]] == [{"C": (0.0, 2.0)}, {"C": (2.0, 1.0)}, {"C": (1.0, 0.5)}]
    assert [stroke.phase for stroke in plan] == ["Stretch", "Stretch", "Recover", "Recover"]


def test_cycles_after_a_prestrain_open_a_set_of_their_own() -> None:
    cycle = Cycle(axes=("C",), lower=0.0, upper=0.4, rate=2e-4, n=2)
    plan = all_strokes(protocol(to_strain(0.2, "W"), cycle))
    assert [stroke.cycle for stroke in plan] == [1, 2, 2, 3, 3]


def test_a_cycle_from_its_upper_end_begins_with_a_recovery() -> None:
    cycle = Cycle(axes=("C",), lower=0.0, upper=0.4, rate=2e-4, n=2)
    plan = all_strokes(protocol(to_strain(0.4, "C"), cycle))
    assert [stroke.phase for stroke in plan] == ["Stretch", "Recover", "Stretch", "Recover"]


def test_steps_have_their_places_and_times() -> None:
    steps = planned_steps(
        protocol(
            Repeat(n=2, steps=(Hold(duration=3.0), to_strain(0.1, "C"))),
            Hold(duration=9.0, until=Until(time=4.0)),
            UntilRupture(axes=("C",), rate=1e-3),
        ),
        GAUGES,
    )
    assert [step.leaf.place for step in steps] == [
        "steps[0].repeat.steps[0].hold",
        "steps[0].repeat.steps[1].ramp",
        "steps[0].repeat.steps[0].hold",
        "steps[0].repeat.steps[1].ramp",
        "steps[1].hold",
        "steps[2].until_rupture",
    ]
    assert [step.duration for step in steps[:5]] == pytest.approx([3.0, 25.0, 3.0, 0.0, 4.0])
    assert steps[-1].strokes[0].drop == 0.6


def test_pictures_are_counted_over_the_steps() -> None:
    steps = (Image(), Hold(duration=5.0), Image(every=2.0), Hold(duration=3.0), Hold(duration=3.0), Image(every="off"))
    assert planned_images(protocol(*steps, Hold(duration=9.0)), GAUGES) == 1 + 1 + 3


def sheared(*zeros: Zero, at: float = 0.0) -> Situation:
    """Return what a step is told on a cell of 16 mm by 10 mm, at 20 % along the wale, and sheared by so much [m]."""
    gauges: dict[Axis, float] = {"C": 0.016, "W": 0.010, "WC": 0.010}
    readings = Readings(displacement={"C": 0.0, "W": 2e-3, "WC": at}, force=dict.fromkeys(gauges, 0.0))
    situation = Situation(
        printed=gauges,
        gears=dict.fromkeys(gauges, 1),
        others="hold",
        history=History(origin=dict.fromkeys(gauges, 0.0), gauges=gauges),
        readings=readings,
    )
    for zero in zeros:
        situation = replace(situation, history=situation.history.after(zero.stroke(0, situation), readings))
    return situation


def test_the_gauge_length_of_a_shear_is_the_length_across_its_face() -> None:
    situation = sheared(Zero(gauge_length="here"), at=1e-3)
    assert situation.gauges == pytest.approx({"C": 0.016, "W": 0.012, "WC": 0.012})
    stroke = situation.drive(("WC",), StrainRate(value=0.01), Target(kind="strain", value=-0.1))
    assert stroke is not None
    assert stroke.end["WC"] == pytest.approx(1e-3 - 0.1 * 0.012)
    assert (stroke.phase, stroke.end["W"]) == ("Recover", 2e-3)
    assert stroke.duration == pytest.approx(10.0)


def test_a_cell_is_sheared_no_further_than_its_images_are_looked_for() -> None:
    with pytest.raises(SpecificationError, match=r"on axis WC', allowed a displacement from -0\.009 m to 0\.009 m"):
        sheared().drive(("WC",), 1e-3, Target(kind="displacement", value=-9.5e-3))
    with pytest.raises(SpecificationError, match="axis WC"):
        sheared(Zero(), at=5e-3).drive(("WC",), 1e-3, Target(kind="strain", value=0.5))
    # A step without a target goes as far as it may.
    farthest = sheared().drive(("WC",), 1e-3, None)
    assert farthest is not None
    assert farthest.end["WC"] == pytest.approx(9e-3)


@pytest.mark.parametrize("wrong", [0.95, -0.95, 1.5])
def test_a_shear_strain_has_bounds_in_every_step(wrong: float) -> None:
    shear: tuple[Axis, ...] = ("WC",)
    for make in (
        lambda: Ramp(axes=shear, to=Target(kind="strain", value=wrong), rate=1e-4),
        lambda: Cycle(axes=shear, lower=min(wrong, 0.0), upper=max(wrong, 0.0), rate=1e-4, n=1),
        lambda: UntilRupture(axes=shear, to=Target(kind="strain", value=wrong), rate=1e-4),
        lambda: Waveform(axes=shear, points=((0.0, 0.0), (1.0, wrong))),
    ):
        with pytest.raises(SpecificationError, match=r"a (shear )?strain from -0\.9"):
            make()

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas.machine_data import machines_of
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Counts
from rigs.instruments.channels import measure
from rigs.instruments.zeros import Zeroing, pin_strain
from rigs.machines.machine import instruments_on
from rigs.machines.pins import stitch_pitch
from rigs.machines.rig import read
from rigs.protocol.extensometer import Extensometer
from rigs.protocol.protocol import Protocol, Ramp, SpecimenSpec, Target, Zero
from rigs.trace import trace_of
from tests.synthetic_run import rows

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.machines.rig import Rig


def ramp(*axes: Axis) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=0.1), rate=2e-4)


@pytest.mark.parametrize(
    ("counts", "course", "wale"),
    [
        (Counts(2, 3), (0, 2), (0, 1)),
        (Counts(4, 5), (1, 3), (1, 2)),
        (Counts(6, 8), (2, 5), (1, 4)),
        (Counts(1, 7), (1, 5), None),
    ],
)
def test_pins_are_about_half_of_the_knit_apart_and_in_its_middle(
    counts: Counts, course: tuple[int, int], wale: tuple[int, int] | None
) -> None:
    assert Extensometer.inner_half(counts) == Extensometer(course=course, wale=wale)


def test_pins_in_stitches_that_are_not_there_are_refused_by_name() -> None:
    with pytest.raises(SpecificationError, match="two of the 4 rows") as refused:
        Extensometer(course=(0, 2), wale=(1, 4)).check(Counts(4, 3))
    assert refused.value.field == "extensometer.wale"
    with pytest.raises(SpecificationError, match="the first before the last"):
        Extensometer(course=(2, 2)).check(Counts(4, 3))


def test_the_distance_of_pins_is_that_of_their_stitches_as_mounted(
    mount_knit: Callable[..., tuple[Rig, State, Protocol]],
) -> None:
    pins = Extensometer(course=(0, 2), wale=(0, 2))
    rig, state, _ = mount_knit(ramp("W"), rows=3, loops=3, nodes=16, mount_along="W", extensometer=pins)
    found = read(rig, state).pins
    assert found["C"] == pytest.approx(2 * 8e-3, rel=1e-3)
    assert found["W"] == pytest.approx(2 * 0.86 * 8e-3, rel=1e-3)
    # A body that turns or moves has the same strain; one that is stretched by a factor has that strain.
    moved = replace(state, q=state.q * [1.0, 1.25, 1.0, 1.0] + [3.0, -2.0, 1.0, 0.0])
    assert read(rig, moved).pins == {"C": pytest.approx(found["C"]), "W": pytest.approx(1.25 * found["W"])}


def protocol(**more: object) -> Protocol:
    spec = SpecimenSpec(knit="stockinette-default", rows=4, loops=4, loop_width=8e-3, material="RGD8530-DM")
    usual = {"rig": "biaxial-hook", "others": "hold", "steps": (ramp("C", "W"),)}
    return Protocol(specimen=spec, **{**usual, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize("rig", ["biaxial-hook", "uniaxial-frame"])
def test_channels_of_pins_come_last_and_change_no_other(rig: str) -> None:
    frame = rig == "uniaxial-frame"
    usual = {"mount": "W", "others": "free", "steps": (ramp("W"),)} if frame else {}
    bare, pinned = (
        protocol(rig=rig, extensometer=one, **usual) for one in (None, Extensometer.inner_half(Counts(4, 4)))
    )
    (plain,), (instrument,) = (instruments_on(test, machines_of(test)) for test in (bare, pinned))
    assert instrument.channels[: len(plain.channels)] == plain.channels
    further = instrument.channels[len(plain.channels) :]
    assert [one.name for one in further] == ["ExtensometerC", "ExtensometerW"]
    assert {(one.noise, one.resolution) for one in further} == {(2e-6, 1e-6)}


def test_a_machine_without_an_extensometer_refuses_pins(monkeypatch: pytest.MonkeyPatch) -> None:
    test = protocol(extensometer=Extensometer(course=(0, 1)))
    bare = replace(machines_of(test)["biaxial-hook"], extensometer=None)
    monkeypatch.setattr("app.schemas.machine_data.read_machine", lambda _name: bare)
    with pytest.raises(SpecificationError, match="biaxial-hook has no extensometer"):
        machines_of(test)


def test_no_zero_changes_what_pins_show_and_strain_counts_from_it() -> None:
    test = protocol(extensometer=Extensometer(wale=(1, 2)), steps=(Zero(channels=("displacement",)), ramp("W")))
    (instrument,) = instruments_on(test, machines_of(test))
    told = [replace(row, pin_distance={"W": 0.01 * (1.0 + 0.1 * number)}) for number, row in enumerate(rows())]
    trace = trace_of(told)
    zeroing = Zeroing(time=told[2].time, kinds=frozenset({"displacement", "force"}))
    seen = measure(instrument, trace, seed=1, noise=False, zeroings=[zeroing])
    assert seen.measured["ExtensometerW"][0] == pytest.approx(0.01)
    assert np.all(seen.offset["ExtensometerW"] == 0.0)
    strain = pin_strain(trace.columns["pin_distance_W"], trace.columns["time"], [zeroing])
    assert strain[:2] == pytest.approx([0.0, 0.1])
    assert strain[2:4] == pytest.approx([0.0, 0.1 / 1.2])


def test_the_pitch_of_stitches_is_what_they_were_laid_in_at_until_the_knit_is_stretched(
    mount_knit: Callable[..., tuple[Rig, State, Protocol]],
) -> None:
    rig, state, _ = mount_knit(ramp("W"), rows=4, loops=3, nodes=16, mount_along="W")
    assert rig.relaxed_pitch == {}
    q = state.q * rig.work.model.scales.length
    assert stitch_pitch(rig.specimen, q) == {
        "C": pytest.approx(8e-3, rel=1e-3),
        "W": pytest.approx(0.86 * 8e-3, rel=1e-3),
    }
    stretched = stitch_pitch(rig.specimen, q * [0.9, 1.2, 1.0, 1.0])
    assert stretched == {"C": pytest.approx(0.9 * 8e-3, rel=1e-3), "W": pytest.approx(1.2 * 0.86 * 8e-3, rel=1e-3)}

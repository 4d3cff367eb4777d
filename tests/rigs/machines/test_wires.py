"""Which hooks of an edge become wires, what slides along the poles, and where a wire has no room."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.errors import GeometryError
from knitlab_core.knits import wires_through
from rigs.axes import SITES
from rigs.machines.fixtures import grips_on
from rigs.machines.wires import hang_on_wires, require_room, sliding_hooks
from rigs.protocol.catalogue import arranged
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.specimen import SpecimenSpec

if TYPE_CHECKING:
    from knitlab_core.knits import Specimen
    from rigs.axes import Axis
    from rigs.machines.fixtures import Grip


@pytest.fixture(scope="module")
def knit() -> Specimen:
    return make_specimen(
        SpecimenSpec(
            knit="stockinette-default", rows=2, loops=3, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=16
        )
    )


@pytest.fixture(scope="module")
def pins(knit: Specimen) -> dict[Axis, tuple[Grip, Grip]]:
    return {axis: grips_on(knit, axis, drive) for axis, drive in arranged("biaxial-hook", None).items()}


def unknowns(knit: Specimen, wires: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return the unknowns (N, 4) of yarn and wires as mounted, in lengths of the specimen."""
    nodes = np.concatenate([knit.nodes, *wires])
    return np.column_stack([nodes, np.zeros(len(nodes))])


def test_nodes_of_wires_come_after_the_yarn_one_after_the_other(
    knit: Specimen, pins: dict[Axis, tuple[Grip, Grip]]
) -> None:
    wires, grips = hang_on_wires(knit, pins)
    numbers = np.concatenate([hung for pair in grips.values() for grip in pair for hung in grip.wires])
    assert numbers.tolist() == list(range(len(knit.nodes), len(knit.nodes) + sum(map(len, wires))))


def test_every_pin_is_left_or_replaced_by_the_wire_of_its_loop(
    knit: Specimen, pins: dict[Axis, tuple[Grip, Grip]]
) -> None:
    _, grips = hang_on_wires(knit, pins)
    for axis, pair in grips.items():
        for number, grip in enumerate(pair):
            loops = wires_through(knit, SITES[axis][number])
            before = pins[axis][number].nodes
            gone = {int(before[hook]) for loop in loops for hook in loop.hooks}
            assert len(grip.wires) == len(loops)
            assert set(grip.nodes.tolist()) == set(before.tolist()) - gone
    assert all(grip.wires for grip in grips["W"])


def test_a_wire_in_the_place_of_the_anchored_pin_is_anchored(knit: Specimen) -> None:
    frame = {axis: grips_on(knit, axis, drive) for axis, drive in arranged("uniaxial-frame", "W").items()}
    (middle,) = frame["W"][0].anchored
    _, grips = hang_on_wires(knit, frame)
    lower, upper = grips["W"]
    assert middle not in lower.nodes
    assert [hung.tolist() for hung in lower.wires].count(lower.anchored.tolist()) == 1
    assert upper.anchored.size == 0


def test_pins_on_smooth_poles_need_no_hooks(knit: Specimen, pins: dict[Axis, tuple[Grip, Grip]]) -> None:
    assert sliding_hooks(pins, dict.fromkeys(pins, 0.0), unknowns(knit, ())) is None


def test_pins_on_rough_poles_slide_one_by_one(knit: Specimen, pins: dict[Axis, tuple[Grip, Grip]]) -> None:
    hooks = sliding_hooks(pins, {"C": 0.2, "W": 0.0}, unknowns(knit, ()))
    assert hooks is not None
    nodes = np.concatenate([grip.nodes for grip in pins["C"]])
    assert hooks.nodes.tolist() == hooks.slider.tolist() == nodes.tolist()
    assert set(hooks.friction) == {0.2}
    assert set(hooks.pole) == {1}
    assert hooks.tied.size == 0


def test_nodes_of_a_wire_slide_as_one_at_the_distances_they_have(
    knit: Specimen, pins: dict[Axis, tuple[Grip, Grip]]
) -> None:
    wires, grips = hang_on_wires(knit, pins)
    q = unknowns(knit, wires)
    hooks = sliding_hooks(grips, dict.fromkeys(grips, 0.0), q)
    assert hooks is not None
    assert len(hooks.slider) == sum(len(grip.wires) for pair in grips.values() for grip in pair)
    assert hooks.tied.size == hooks.nodes.size - len(hooks.slider)
    along = hooks.pole[hooks.hook[np.isin(hooks.nodes, hooks.tied)]]
    np.testing.assert_array_equal(hooks.apart, q[hooks.tied, along] - q[hooks.tied - 1, along])
    assert not hooks.friction.any()


def test_a_wire_without_room_is_refused_before_anything_is_mounted(knit: Specimen) -> None:
    require_room(knit, ("C", "W"))
    tight = replace(knit, yarn=replace(knit.yarn, fibre_radius=0.15), radius=0.15 * knit.loop_width)
    with pytest.raises(GeometryError, match="wire"):
        require_room(tight, ("C", "W"))

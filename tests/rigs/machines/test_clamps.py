"""Small knits between clamps."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from rigs.axes import SITES
from rigs.machines.rig import pose, read
from rigs.protocol.protocol import Ramp, Target

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.machines.rig import Rig

# The solver leaves 1e-4 of the mean force of a held unknown at a free one; over the knit these add up.
BALANCE = 1e-3

Pulled = tuple["Rig", "State"]


def ramp(*axes: Axis) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=0.1), rate=2e-4)


def drawn(rig: Rig, state: State, *travels: float) -> State:
    """Return the state after all axes went to some travels [m], one after the other."""
    for low, high in pairwise([0.0, *travels]):

        def target(share: float, low: float = low, high: float = high) -> np.ndarray:
            return pose(rig, dict.fromkeys(rig.grips, low + share * (high - low)))

        *_, (_, state, _) = march(rig.work, state, target, longest=0.5)
    return state


@pytest.fixture(scope="module")
def mounted(request: pytest.FixtureRequest) -> Callable[..., Pulled]:
    """Return a function that mounts a knit of 3 rows of 5 loops along its courses and pulls it to some travels [m]."""

    def pull(grips: str, *travels: float) -> Pulled:
        put = request.getfixturevalue("mount_knit")
        rig, state, _ = put(ramp("C"), rows=3, loops=5, nodes=16, mount_along="C", grips=grips)
        return rig, drawn(rig, state, *travels)

    return pull


@pytest.fixture(scope="module")
def clamped(mounted: Callable[..., Pulled]) -> Pulled:
    """Return the knit between clamps, pulled by 12 mm."""
    return mounted("clamps", 12e-3)


def width(rig: Rig, state: State, near: float) -> float:
    """Return the width of the knit across the course, over the stitch whose printed place is nearest to x [m]."""
    x, y = rig.mounted[:, 0], state.q[:, 1]
    column = np.abs(x * rig.work.model.scales.length - near) < 0.5 * rig.specimen.loop_width
    return float(np.ptp(y[column])) * rig.work.model.scales.length


def test_clamps_keep_the_width_they_took(clamped: Pulled) -> None:
    rig, state = clamped
    low, high = rig.grips["C"]
    for grip in (low, high):
        moved = state.q[grip.nodes] - rig.mounted[grip.nodes]
        assert np.ptp(moved, axis=0) == pytest.approx(0.0, abs=1e-9)
        assert moved[0, 1:] == pytest.approx(0.0, abs=1e-9)
    edge = 2.0 * rig.specimen.loop_width
    printed = replace(state, q=rig.mounted)
    for near in (-edge, edge):
        assert width(rig, state, near) == pytest.approx(width(rig, printed, near), abs=1e-12)


def test_a_clamp_s_pull_is_what_the_cell_reads_and_its_forces_balance_in_every_direction(clamped: Pulled) -> None:
    rig, state = clamped
    reading = read(rig, state)
    pull = reading.force["C"]
    assert pull > 1e-3
    assert reading.fixture["C+_C"] == pytest.approx(pull)
    for along in ("C", "W", "P"):
        assert reading.fixture[f"C+_{along}"] + reading.fixture[f"C-_{along}"] == pytest.approx(0.0, abs=BALANCE * pull)
    assert set(reading.fixture) == set(rig.fixture_forces)


def test_clamps_hold_the_knit_stiffer_than_hooks_that_slide(mounted: Callable[..., Pulled], clamped: Pulled) -> None:
    # At one strain of the fabric between the fixtures: 12 mm over 3 loops, 20 mm over 5.
    rig, state = mounted("hooks", 20e-3)
    assert rig.fixture_forces == []
    assert read(rig, state).fixture == {}
    assert clamped[0].gauges["C"] == pytest.approx(3 * 8e-3)
    assert rig.gauges["C"] == pytest.approx(5 * 8e-3)
    # Hooks slide along their poles as the rows' ends are drawn out; clamps keep them where they were.
    sites = rig.specimen.sites["course+"]
    assert abs(np.ptp(state.q[sites, 1]) / np.ptp(rig.mounted[sites, 1]) - 1.0) > 0.05
    assert read(*clamped).force["C"] > 1.05 * read(rig, state).force["C"]


def test_hooks_beside_clamps_hold_what_is_in_no_jaws_and_slide_along_their_poles(
    mount_knit: Callable[..., tuple[Rig, State, object]],
) -> None:
    rig, state, _ = mount_knit(ramp("C", "W"), rows=4, loops=3, nodes=16, grips={"W": "clamps"})
    jaws = np.concatenate([grip.nodes for grip in rig.grips["W"]])
    for grip, edge in zip(rig.grips["C"], SITES["C"], strict=True):
        # Feet are below the middle of their row: those of the first two rows are in the lower jaws.
        assert grip.nodes.tolist() == rig.specimen.sites[edge][2:].tolist()
        assert not np.isin(grip.nodes, jaws).any()
        assert rig.work.model.fixed[grip.nodes, :3].tolist() == [[True, False, True]] * len(grip.nodes)
    assert rig.work.model.fixed[jaws].all()
    assert rig.gauges == pytest.approx({"C": 3 * 8e-3, "W": 2 * 6.88e-3})
    reading = read(rig, drawn(rig, state, 2e-3))
    assert min(reading.force.values()) > 0.0
    # Friction holds nothing along a pole, so the jaws alone balance each other along the wale.
    assert reading.fixture["W+_W"] + reading.fixture["W-_W"] == pytest.approx(0.0, abs=BALANCE * reading.force["W"])


def test_the_stage_pulls_four_clamps_apart(mount_knit: Callable[..., tuple[Rig, State, object]]) -> None:
    rig, state, _ = mount_knit(ramp("C", "W"), rows=4, loops=4, nodes=16, grips="clamps")
    found = drawn(rig, state, 2e-3)
    reading = read(rig, found)
    assert min(reading.force.values()) > 0.0
    for along in ("C", "W", "P"):
        total = sum(reading.fixture[f"{side}_{along}"] for side in ("C-", "C+", "W-", "W+"))
        assert total == pytest.approx(0.0, abs=BALANCE * max(reading.force.values()))
    corner = np.all(np.abs(rig.mounted[:, :2]) * rig.work.model.scales.length > 10e-3, axis=1)
    assert corner.any()
    assert not rig.work.model.fixed[corner, :3].any()

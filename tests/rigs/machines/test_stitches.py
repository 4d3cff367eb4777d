"""Pulls of planar knits other than stockinette."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.knits import clasp_numbers
from rigs.axes import COORDINATE, SITES
from rigs.machines.rig import pose, read
from rigs.protocol.protocol import Cycle, Zero

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol

STEPS = (Zero(), Cycle(axes=("C", "W"), lower=0.0, upper=0.05, rate=2e-4, n=1))


@pytest.mark.parametrize("name", ["rib-1x1", "garter", "seed"])
def test_a_pull_along_both_axes_converges_and_lets_no_loop_go(
    mount_knit: Callable[..., tuple[Rig, State, Protocol]], name: str
) -> None:
    stage, state, _ = mount_knit(*STEPS, knit=name, nodes=16)
    printed = clasp_numbers(stage.specimen, stage.specimen.nodes)
    goal = {axis: 0.05 * length for axis, length in stage.gauges.items()}
    start, forces = state.q.copy(), []
    path = march(
        stage.work, state, lambda share: pose(stage, {axis: share * way for axis, way in goal.items()}), longest=0.25
    )
    for _, found, _ in path:
        state = found
        forces.append([read(stage, state).force[axis] for axis in ("C", "W")])
    sites, radius = stage.specimen.sites, stage.specimen.radius
    for axis in stage.gauges:
        near, far = SITES[axis]
        moved = state.q[:, COORDINATE[axis]] - start[:, COORDINATE[axis]]
        assert radius * (moved[sites[far]].mean() - moved[sites[near]].mean()) == pytest.approx(goal[axis])
    pulls = np.array(forces)
    assert np.all(pulls[-1] > 1e-4)
    assert np.all(np.diff(pulls.sum(axis=1)) > 0.0)
    assert np.array_equal(clasp_numbers(stage.specimen, state.q[:, :3]), printed)

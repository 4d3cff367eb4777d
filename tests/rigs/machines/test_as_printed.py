"""Printed knits are free of stress as mounted, however narrow their gaps, and pull as soon as they are moved."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.knits import NAMED_STITCHES, NAMED_VOLUMETRIC_STITCHES, Stitch, same_area
from knitlab_core.knits.clearance import check_clearance
from knitlab_core.knits.volumetric import check_volumetric_clearance, volumetric, volumetric_middle
from rigs.machines.rig import pose, read
from rigs.protocol.protocol import Hold
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State
    from knitlab_core.knits.volumetric_stitch import VolumetricStitch
    from rigs.machines.rig import Rig

DEFAULT = NAMED_STITCHES["stockinette-default"]
LOOP = 8e-3


def thick(gap: float) -> Stitch:
    """Return the default stitch of a fibre so thick that the surfaces of a 2x2 knit are a gap [m] apart."""
    apart = check_clearance(DEFAULT, rows=2, loops=2, loop_width=LOOP).distance
    return replace(DEFAULT, fibre_radius=0.5 * (apart - gap / LOOP))


def thick_volumetric(gap: float) -> VolumetricStitch:
    """Return the same of the default volumetric stitch and a 2x2x2 knit."""
    stitch = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
    line, middle = volumetric(stitch, rows=2, loops=2, layers=2), volumetric_middle(stitch, 2, 2, 2)
    apart = check_volumetric_clearance(stitch, line, middle=middle, loop_width=LOOP).distance
    return replace(stitch, fibre_radius=0.5 * (apart - gap / LOOP))


def gradient(stage: Rig, state: State) -> FloatArray:
    """Return all forces and moments (N, 4) at a state [E r^2], [E r^3]."""
    stage.work.start_step(state.q, state.frames, state.memory)
    return stage.work.gradient()


@pytest.mark.parametrize(
    "specimen",
    [
        *(
            {"knit": thick(1e-6 * gap), "nodes_per_loop": nodes}
            for gap in (30.0, 10.0, 1.2, 0.1, 1e-3)
            for nodes in (8, 16, 48)
        ),
        {"knit": thick(1.2e-6), "loop_width": 50e-6},
        {"knit": thick_volumetric(1.2e-6), "layers": 2},
        {"hook": "wire", "nodes_per_loop": 12},
        {"yarn": same_area(DEFAULT.fibre_radius, 3, gap=1e-4, model="bundle")},
    ],
    ids=str,
)
def test_mounted_knits_are_free_of_stress(mount_knit: Callable[..., Any], specimen: dict[str, Any]) -> None:
    stage, state, _ = mount_knit(Hold(duration=1.0), **specimen)
    assert np.abs(gradient(stage, state)).max() < 1e-12


@pytest.mark.parametrize("nodes", [16, 48])
def test_a_knit_that_all_but_touches_is_pulled_and_comes_back(mount_knit: Callable[..., Any], nodes: int) -> None:
    stage, state, _ = mount_knit(Hold(duration=1.0), knit=thick(1.2e-6), nodes_per_loop=nodes)
    digit = 1e-3  # of the stage's load cells [N]
    forces, states = [read(stage, state).force], []
    for begin, end in ((0.0, 0.05), (0.05, 0.0)):

        def path(share: float, begin: float = begin, end: float = end) -> FloatArray:
            strain = begin + (end - begin) * share
            return pose(stage, {axis: strain * length for axis, length in stage.gauges.items()})

        *_, (_, state, _) = march(stage.work, state, path, longest=0.25)
        forces.append(read(stage, state).force)
        states.append(state)
    assert all(abs(forces[0][axis]) < 1e-9 for axis in BOTH)
    assert all(forces[1][axis] > 100.0 * digit for axis in BOTH), forces
    assert states[0].energies[3] > 0.0
    # Strands pressed on each other and came apart again: friction alone may hold something back.
    assert all(abs(forces[2][axis]) < digit for axis in BOTH), forces

"""Loops of a volumetric knit are counted as held under load, and as let go where they have slipped out."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.knits.clasp import joined_clasps
from rigs.machines.rig import pose, read
from rigs.protocol.protocol import Hold

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits import Specimen
    from rigs.axes import Axis

Pulled = list[tuple["Specimen", "FloatArray", float]]

STRAINS = (0.1, 0.2, 0.4)


def pulled(mount_knit: Callable[..., Any], axis: Axis, size: int, strains: tuple[float, ...], **options: Any) -> Pulled:  # noqa: ANN401
    """Return specimen, nodes and force of a knit with free sides, as mounted and at strains along an axis."""
    stage, state, _ = mount_knit(
        Hold(duration=1.0), rows=size, loops=size, layers=size, mount_along=axis, others="free", **options
    )
    found: Pulled = [(stage.specimen, state.q[:, :3].copy(), 0.0)]
    for begin, end in pairwise((0.0, *strains)):

        def path(share: float, begin: float = begin, end: float = end) -> FloatArray:
            strain = begin + (end - begin) * share
            return pose(stage, {axis: strain * stage.gauges[axis]})

        *_, (_, state, _) = march(stage.work, state, path, longest=0.25)
        found.append((stage.specimen, state.q[:, :3].copy(), read(stage, state).force[axis]))
    return found


LOOSE_END = {2: ("rows", (1, 0, 0, 0)), 3: ("layers", (1, 2, 2, 1))}
"""By size the clasp that the end of the yarn would leave: that of the loop knitted last. No hook holds the end."""


def let_go(specimen: Specimen, nodes: FloatArray) -> set[tuple[str, tuple[int, ...]]]:
    """Return the clasps that are 0, and check that all others are those of the printed knit."""
    found: set[tuple[str, tuple[int, ...]]] = set()
    moved = joined_clasps(specimen, nodes)
    for joined, printed in joined_clasps(specimen, specimen.nodes).items():
        now = moved[joined]
        assert np.all(np.abs(printed) == 1)
        assert np.all((now == printed) | (now == 0))
        found |= {(joined, tuple(at)) for at in np.argwhere(now == 0).tolist()}
    return found


def check_held(states: Pulled) -> None:
    """Check that the knit pulls ever harder with all its loops held, but for where the yarn's end slips out at last."""
    forces = [force for *_, force in states]
    assert forces == sorted(forces)
    for specimen, nodes, _ in states[:-1]:
        assert not let_go(specimen, nodes)
    specimen, nodes, _ = states[-1]
    assert let_go(specimen, nodes) <= {LOOSE_END[specimen.rows]}


@pytest.mark.parametrize("axis", ["C", "W", "P"])
def test_loops_of_a_small_volumetric_knit_are_held_under_load(mount_knit: Callable[..., Any], axis: Axis) -> None:
    check_held(pulled(mount_knit, axis, 2, STRAINS, nodes_per_loop=16))


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["C", "W", "P"])
def test_loops_of_a_larger_volumetric_knit_are_held_under_load(mount_knit: Callable[..., Any], axis: Axis) -> None:
    check_held(pulled(mount_knit, axis, 3, STRAINS))


def test_layers_drawn_out_of_each_other_under_load_are_let_go(mount_knit: Callable[..., Any]) -> None:
    _, (specimen, nodes, _) = pulled(mount_knit, "P", 2, (0.1,), nodes_per_loop=16)
    half = specimen.centreline.starts[4] * specimen.loop_width
    above = specimen.arc_lengths > half
    for lift, held in ((0.0, 1), (2.0 * specimen.loop_width, 0)):
        moved = nodes + lift / specimen.radius * np.outer(above, [0.0, 0.0, 1.0])
        assert np.all(np.abs(joined_clasps(specimen, moved)["layers"]) == held)
        assert np.all(np.abs(joined_clasps(specimen, moved)["rows"]) == 1)

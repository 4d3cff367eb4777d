"""Forces of a knit at n and 2n nodes per loop.

Contact acts on the quadratic B-spline of which the nodes are the control points, and specimens place them so that
it passes through the printed curve. With the nodes on that curve the spline would run inside it by h^2 kappa / 8,
and 48 nodes per loop would err by 6 to 10 % against 96.

Both meshes are pulled equally far, by the strain of the yarn: over the nodes a coarse specimen is longer, by 0.08 % of
the wale at 48 nodes per loop, which makes 0.25 % of the force at 40 %.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.validation.knit import FloatArray, make_knit, pull

if TYPE_CHECKING:
    from collections.abc import Callable

STRAINS = (0.2, 0.3, 0.4)


@cache
def _forces(size: int, nodes_per_loop: int) -> FloatArray:
    """Return course and wale force (3, 2) at 20, 30 and 40 % [N]."""
    rows, _ = pull(make_knit(size, nodes_per_loop=nodes_per_loop), STRAINS, steps=10)
    return np.array([rows[index].force for index in (10, 20, 30)])


@pytest.mark.parametrize("axis", [0, 1], ids="CW")
@pytest.mark.parametrize("point", range(3), ids=[f"{strain:.0%}" for strain in STRAINS])
@pytest.mark.parametrize("size", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_forces_are_those_at_twice_as_many_nodes(bar: Callable[..., None], size: int, point: int, axis: int) -> None:
    coarse, fine = (_forces(size, nodes)[point, axis] for nodes in (48, 96))
    name = f"mesh, {size}x{size}: {'CW'[axis]} at {STRAINS[point]:.0%}, 48 against 96 nodes per loop"
    bar(name, coarse / fine - 1.0, 0.01, "1", "physics.md §6; decision 0018")

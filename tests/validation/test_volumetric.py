"""A volumetric knit pulled with free sides: its stress over E is the same at every size, and the pile is stiffest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, knit_specimen

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

Direction = Literal["course", "wale", "pile"]

# What a hook holds beside the pull: the coordinate across its pole; along the pole it is free.
ACROSS = {"course": 2, "wale": 2, "pile": 1}
DIRECTIONS: tuple[Direction, ...] = ("course", "wale", "pile")


def _stress(
    direction: Direction, loop_width: float, young_modulus: float, *, strain: float, steps: int
) -> NDArray[np.float64]:
    """Return stress over E at every step on the way to a strain, of 2x2x2 stitches."""
    stitch = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
    specimen = knit_specimen(stitch, rows=2, loops=2, layers=2, loop_width=loop_width, nodes_per_loop=32)
    model, state = make_model(
        [specimen.nodes],
        radius=specimen.radius,
        young_modulus=young_modulus,
        poisson_ratio=0.37,
        friction=0.3,
    )
    axis = DIRECTIONS.index(direction)
    low, high = (specimen.sites[f"{direction}{side}"] for side in "-+")  # type: ignore[index]
    for held in (axis, ACROSS[direction]):
        model.fixed[low, held] = model.fixed[high, held] = True
    # One hook is tied along its pole, against drift.
    along = 3 - axis - ACROSS[direction]
    model.fixed[low[0], along] = True
    start = state.q.copy()
    travel = strain * (start[high, axis].mean() - start[low, axis].mean())

    def path(share: float) -> NDArray[np.float64]:
        target = start.copy()
        target[high, axis] += share * travel
        return target

    way = march(Workspace(model), state, path, longest=1.0 / steps, options=Options(tolerance=1e-8))
    force = [model.scales.force * float(found.reaction[high, axis].sum()) for _, found, _ in way]
    section = np.prod(np.delete(np.ptp(specimen.nodes, axis=0), axis))
    return np.array(force) / (float(section) * young_modulus)


def test_stress_over_modulus_is_the_same_at_50_um_and_8_mm(bar: Callable[..., None]) -> None:
    macro = _stress("pile", 8e-3, 0.82e9, strain=0.1, steps=10)
    micro = _stress("pile", 50e-6, 3.0e9, strain=0.1, steps=10)
    error = np.abs(micro / macro - 1.0)[np.abs(macro) > 1e-3 * macro[-1]].max()
    bar("volumetric 2x2x2, 50 um and 8 mm loops: stress / E", error, 1e-6, "1", "physics.md §6")


def test_the_pile_is_stiffest(bar: Callable[..., None]) -> None:
    course, wale, pile = (_stress(direction, 8e-3, 0.82e9, strain=0.1, steps=10)[-1] for direction in DIRECTIONS)
    bar("volumetric 2x2x2 at 10 %: stiffer of the others / pile", max(course, wale) / pile, 1.0, "1", "paper, Fig. 4c")

"""A periodic cell of a volumetric knit: the same whatever is called its inside, and its forces are what is cut."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, knit_specimen
from tests.validation.cells import WIDTH, CellTest, cut_forces, make_test

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

KNIT = "volumetric-default"
STRAIN = (0.22, 0.22, 0.22)


def stretched(
    counts: Sequence[int], *, friction: float = 0.0, roll: int = 0, shift: Sequence[float] = (0.0,) * 3, wider: int = 0
) -> CellTest:
    """Stretch a cell along all three axes."""
    test = make_test(counts, knit=KNIT, friction=friction, roll=roll, shift=shift, wider=wider)
    test.stretch(STRAIN, steps=8)
    return test


def by_strand(test: CellTest) -> np.ndarray:
    """Return the forces along course, wale and pile on every repeat of a strand or a loop [E r^2]."""
    return np.asarray(test.forces.diagonal() / test.area)


@pytest.fixture(scope="module", name="one")
def _one() -> CellTest:
    """Return the smallest cell, stretched without friction."""
    return stretched((1, 1, 2))


LARGER = [(2, 2, 2), *(pytest.param(one, marks=pytest.mark.slow) for one in ((1, 1, 4), (2, 2, 4)))]


@pytest.mark.parametrize("counts", LARGER)
def test_cells_of_any_size_are_one_fabric(one: CellTest, counts: tuple[int, ...], bar: Callable[..., None]) -> None:
    error = np.abs(by_strand(stretched(counts)) / by_strand(one) - 1.0).max()
    name = " x ".join(map(str, counts))
    bar(f"volumetric cell: {name} against 1 x 1 x 2", error, 1e-6, "1", "one fabric")


@pytest.mark.slow
def test_moving_the_fabric_through_the_sides_of_its_cell_changes_nothing(
    one: CellTest, bar: Callable[..., None]
) -> None:
    """Images beyond those that are near are looked at too, and touch nothing."""
    moved = stretched((1, 1, 2), roll=9, shift=(0.013, -0.031, 0.007), wider=1)
    error = np.abs(by_strand(moved) / by_strand(one) - 1.0).max()
    bar("volumetric cell: moved, cut elsewhere, more images", error, 1e-6, "1", "invariance")


def test_forces_on_the_cell_are_those_of_all_that_a_plane_cuts(one: CellTest, bar: Callable[..., None]) -> None:
    largest = np.abs(one.forces).max()
    for axis, name in enumerate(("course", "wale", "pile")):
        cuts = [cut_forces(one.work, one.state, axis, place) for place in (0.1, 0.37, 0.8)]
        error = np.abs(np.array(cuts) - one.forces[axis]).max() / largest
        bar(f"volumetric cell: force against all cut across the {name}", error, 1e-6, "1", "balance of forces")


def test_nothing_pulls_on_free_sides_and_the_work_is_kept(bar: Callable[..., None]) -> None:
    test = make_test((1, 1, 2), knit=KNIT, friction=0.3)
    test.release([(0, 0), (1, 1)])
    pile = test.stretch((0.0, 0.0, 0.2), steps=12)[-1][2, 2]
    course, wale, through = (cut_forces(test.work, test.state, axis, 0.37)[axis] / pile for axis in range(3))
    bar("volumetric cell: cut across free sides", max(abs(course), abs(wale)), 1e-6, "1", "free")
    bar("volumetric cell: cut across the pile, with friction", through - 1.0, 1e-6, "1", "balance of forces")
    bar("volumetric cell: energy balance", test.imbalance, 0.01, "1", "energy")
    # Pile loops draw the yarn that they need out of the course.
    assert test.vectors[0, 0] < 0.9 * test.printed[0, 0]


def specimen_stress(size: int, strain: float) -> float:
    """Return the force along the pile per column of pile loops of a specimen with edges, its sides free [E r^2]."""
    stitch = NAMED_VOLUMETRIC_STITCHES[KNIT]
    specimen = knit_specimen(stitch, rows=size, loops=size, layers=size, loop_width=WIDTH, nodes_per_loop=16)
    model, state = make_model(
        [specimen.nodes], radius=specimen.radius, young_modulus=0.82e9, poisson_ratio=0.37, friction=0.3
    )
    low, high = specimen.sites["pile-"], specimen.sites["pile+"]
    for held in (1, 2):
        model.fixed[low, held] = model.fixed[high, held] = True
    # One hook is tied along its pole, against drift.
    model.fixed[low[0], 0] = True
    start = state.q.copy()
    goal = start.copy()
    goal[high, 2] += strain * (start[high, 2].mean() - start[low, 2].mean())
    *_, (_, peak, _) = march(Workspace(model), state, lambda s: start + s * (goal - start), longest=1.0 / 16)
    return float(peak.reaction[high, 2].sum()) / size**2


@pytest.mark.slow
def test_specimens_come_near_the_cell_like_one_over_their_side(bar: Callable[..., None]) -> None:
    """Of specimens with 2 and 4 stitches a side at 30 % the share of edges halves."""
    cell = make_test((1, 1, 2), knit=KNIT, friction=0.3)
    cell.release([(0, 0), (1, 1)])
    inside = cell.stretch((0.0, 0.0, 0.3), steps=24)[-1][2, 2]
    two, four = (specimen_stress(size, 0.3) / inside - 1.0 for size in (2, 4))
    assert two > four > 0.0
    bar("volumetric cell: excess of specimens, 4 stitches a side over 2", four / two, 0.7, "1", "share of edges")

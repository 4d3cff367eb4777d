"""Stretch and shear periodic cells of printed knits, and keep every equilibrium."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.periodic import Period, make_cell
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import fabric_named, has_cells, knit_cell

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from knitlab_core.equilibrium.model import State

WIDTH: Final = 8e-3
TIGHT: Final = Options(tolerance=1e-8)


@dataclass(slots=True, kw_only=True)
class CellTest:
    """A cell under test: its model with buffers, where it is, and its vectors as printed (D, 3) [r].

    `area` is, for every vector, how many strands' repeats its force is spread over: rows x layers along the course.
    """

    work: Workspace
    state: State
    printed: np.ndarray
    area: np.ndarray

    @property
    def nodes(self) -> np.ndarray:
        """Return the nodes whose positions are the cell's vectors, (D,)."""
        ties = self.work.model.ties
        assert ties is not None
        return ties.cell

    @property
    def vectors(self) -> np.ndarray:
        """Return the cell's vectors (D, 3) [r]."""
        return self.state.q[self.nodes, :3]

    @property
    def forces(self) -> np.ndarray:
        """Return the forces on the cell's vectors (D, 3) [E r^2]."""
        return self.state.reaction[self.nodes, :3]

    @property
    def energy(self) -> float:
        """Return what is stored [E r^3], in the links too, which are no part of the state's energies."""
        links = self.work.links
        assert links is not None
        return float(self.state.energies.sum()) + links.energy()

    @property
    def imbalance(self) -> float:
        """Return work that is neither stored nor lost over the work [1]."""
        kept = self.energy + self.state.friction_work + self.state.snap_work
        return float(self.state.external_work / kept - 1.0)

    def release(self, parts: Collection[tuple[int, int]]) -> None:
        """Set components of vectors free: (1, 1) is the length along the wale, (1, 0) its lean along the course."""
        for vector, along in product(range(len(self.nodes)), range(len(self.nodes))):
            self.work.model.fixed[self.nodes[vector], along] = (vector, along) not in parts

    def go(self, vectors: np.ndarray, *, steps: int = 1, options: Options = TIGHT) -> list[np.ndarray]:
        """Bring the vectors (D, 3) to their goal [r]; return the forces at every equilibrium."""
        start = self.state.q.copy()
        goal = start.copy()
        goal[self.nodes, :3] = vectors
        forces = []
        for _, state, _ in march(
            self.work, self.state, lambda s: start + s * (goal - start), longest=1.0 / steps, options=options
        ):
            self.state = state
            forces.append(self.forces.copy())
        return forces

    def stretch(self, strains: Sequence[float], *, steps: int, options: Options = TIGHT) -> list[np.ndarray]:
        """Bring the cell to strains of its lengths [1], upright; return the forces at every equilibrium."""
        return self.go(self.printed * (1.0 + np.array(strains))[:, None], steps=steps, options=options)


def make_test(
    counts: Sequence[int],
    *,
    knit: str = "stockinette-default",
    friction: float = 0.0,
    nodes: int = 16,
    roll: int = 0,
    shift: Sequence[float] = (0.0, 0.0, 0.0),
    wider: int = 0,
) -> CellTest:
    """Make a cell of so many rows, loops and, of a volumetric knit, layers.

    `roll` begins each row so many nodes further on, `shift` moves all of them [m], `wider` looks for contact in more
    images than there can be any.
    """
    fabric = fabric_named(knit)
    assert has_cells(fabric)
    rows, loops, layers = (*counts, 1)[:3]
    specimen = knit_cell(fabric, loop_width=WIDTH, rows=rows, loops=loops, layers=layers, nodes_per_loop=nodes)
    cell = specimen.cell
    assert cell is not None
    periods = []
    for strand, along in zip(specimen.strands, cell.shifts, strict=True):
        moved = np.roll(strand[:-2], -roll, axis=0)
        moved[len(moved) - roll :] += along[0] * cell.vectors[0]
        periods.append(Period(moved + np.array(shift), along))
    model, state = make_cell(
        periods,
        cell.vectors,
        [most + wider for most in cell.reach],
        neighbours=cell.neighbours,
        stitches=cell.stitches,
        radius=specimen.radius,
        young_modulus=0.82e9,
        poisson_ratio=0.37,
        friction=friction,
    )
    assert model.ties is not None
    area = np.array([rows * layers, loops * layers, rows * loops])[: len(cell.vectors)]
    return CellTest(work=Workspace(model), state=state, printed=state.q[model.ties.cell, :3].copy(), area=area)


def cut_forces(work: Workspace, state: State, axis: int, place: float) -> np.ndarray:
    """Return what is cut by a plane across an axis, and by its images: all tensions and contacts through it (3,).

    Parameters
    ----------
    work, state
        A cell that is not sheared, at the equilibrium where its search ended.
    axis : int
        Coordinate that the plane is across.
    place : float
        Where the plane is, as a share of the cell's length.
    """
    ties = work.model.ties
    assert ties is not None
    gradient = np.zeros_like(state.q)
    for term in work.terms:
        term.add_gradient(gradient)
    # Whatever is on one side of all planes as a whole has forces that cancel.
    beyond = np.floor(state.q[:, axis] / state.q[ties.cell[axis], axis] - place)
    beyond[ties.cell] = 0.0
    beyond[ties.cell[axis]] = 1.0
    return np.asarray((beyond[:, None] * gradient[:, :3]).sum(axis=0))

"""Fields along the yarn: axial strain, bending strain, contact force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.rods.rod import edges_of
from knitlab_core.rods.rupture import axial_strain as stretched_along
from knitlab_core.rods.rupture import bending_strain as bent_along
from rigs.axes import AXES, COORDINATE, DIRECTIONS, FACE

if TYPE_CHECKING:
    from knitlab_core.equilibrium.model import State
    from rigs.axes import FloatArray
    from rigs.machines.rig import Rig


def axial_strain(rig: Rig, state: State) -> FloatArray:
    """Return the axial strain of every edge as made, strand by strand, shape (E,) [1]; nan where it is broken."""
    rods = rig.work.model.rods
    along = np.where(rods.has_edge, stretched_along(state.q, rods, state.frames), np.nan)
    return _of_edges(rig, along)


def bending_strain(rig: Rig, state: State) -> FloatArray:
    """Return how much bending strains the fibre's surface along every edge as made, shape (E,) [1]; nan where broken.

    Of an edge's two ends the one that bends more counts, as it does for rupture.
    """
    rods = rig.work.model.rods
    bent = np.where(rods.has_edge, bent_along(state.q, rods, state.frames, rig.fibre_reach), np.nan)
    return _of_edges(rig, bent)


def _of_edges(rig: Rig, values: FloatArray) -> FloatArray:
    """Return values of all nodes (N,) at the edges as made, strand by strand, shape (E,)."""
    chosen = values[: len(rig.specimen.nodes) - 1][edges_of(rig.strands)[:-1]]
    if rig.specimen.cell is not None:
        # The first and the last edge of a row are one edge, of which each knows the span on one side only.
        rows = chosen.reshape(len(rig.strands), -1)
        rows[:, [0, -1]] = 0.5 * (rows[:, 1] + rows[:, -2])[:, None]
    return chosen


def cell_shape(rig: Rig, state: State) -> dict[str, float]:
    """Return the components of a periodic cell's vectors by column [m]; empty for a specimen with edges."""
    if rig.specimen.cell is None:
        return {}
    vectors = rig.work.model.scales.length * state.q[-len(rig.specimen.cell.vectors) :, :3]
    return {
        axis: float(vectors[DIRECTIONS.index(FACE[axis]), COORDINATE[axis]])
        for axis in AXES
        if axis in rig.cell_columns
    }


def contact_force(rig: Rig, state: State) -> FloatArray:
    """Return what presses on the yarn around every node, the sum of the loads of its contacts, shape (N,) [N].

    A sum of magnitudes: a strand that is nipped from two sides is pressed, though it is not pushed away.
    """
    model, memory = rig.work.model, state.memory
    per_node = len(model.samples.weights)
    count = len(state.q)
    first, second = np.divmod(memory.key, count * per_node)
    loads = model.scales.force * np.concatenate([memory.load, memory.load])
    nodes = np.concatenate([first, second]) // per_node
    return np.bincount(nodes, loads, minlength=count).astype(np.float64)[: len(rig.specimen.nodes)]


def wire_ends(rig: Rig, state: State) -> FloatArray:
    """Return both ends of every wire, shape (W, 2, 3) [m]."""
    model, yarn = rig.work.model, len(rig.specimen.nodes)
    if rig.specimen.cell is not None:
        return np.zeros((0, 2, 3))
    # A strand begins behind a node that no edge leaves.
    ends = np.column_stack(
        [np.flatnonzero(~model.rods.has_edge[yarn - 1 : -1]), np.flatnonzero(~model.rods.has_edge[yarn:])]
    )
    at: FloatArray = state.q[yarn:][ends, :3] * model.scales.length
    return at

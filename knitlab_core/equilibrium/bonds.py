"""The bonds that are whole in one step: where they are now, what they store, and their part of the stiffness."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.bond_forces import bond_energy, bond_gradient, bond_hessian, bond_loads
from knitlab_core.contact.bonds import Bonds, BondState
from knitlab_core.contact.slip import Placed, place_edges
from knitlab_core.equilibrium.pattern import update_pattern
from knitlab_core.rods.frames import Frames
from knitlab_core.sparse.blocks import Pattern


class BondTerm:
    """Whole bonds between the samples that a workspace places.

    Parameters
    ----------
    bonds : Bonds
        Those that are whole.
    placed : Placed
        Samples of the workspace, which moves them; turns are kept apart, as bonds count them since printing.
    weights : (m, 3) array
        Weights of a span's nodes at its samples.
    has_edge : (N,) bool array
        Nodes that an edge leaves.
    """

    pattern: Pattern

    def __init__(self, bonds: Bonds, placed: Placed, weights: FloatArray, has_edge: BoolArray) -> None:
        self.bonds = bonds
        self._placed = placed._replace(turn=np.zeros_like(placed.turn))
        self._weights, self._has_edge = weights, has_edge

    def fits(self, pattern: Pattern) -> bool:
        """Find the bonds' blocks in a pattern; return False if it lacks some."""
        found = update_pattern(pattern, self._has_edge.size, self.bonds)
        if found is None:
            return False
        self.pattern = found
        return True

    def place(self, q: FloatArray, frames: Frames) -> None:
        """Turn the edges to configuration `q`, where the samples already are."""
        place_edges(q, self._has_edge, frames, self.bonds.frames, self._placed)

    def energy(self) -> float:
        """Return the energy stored [E r^3]."""
        return bond_energy(self._placed, self.bonds, len(self._weights))

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the bonds' forces to a gradient (N, 4)."""
        bond_gradient(self._placed, self.bonds, self._weights, gradient)

    def add_hessian(self, exact: float, blocks: FloatArray) -> None:
        """Add the bonds' stiffness to the blocks of the pattern last fitted."""
        bond_hessian(self._placed, self.bonds, self._weights, exact, self.pattern, blocks)

    def state(self, before: BondState) -> BondState:
        """Return the state of the bonds, of which these are the whole ones in `before`."""
        loads = np.zeros(self.bonds.a.size)
        bond_loads(self._placed, self.bonds, len(self._weights), loads)
        load = np.zeros(before.whole.size)
        load[before.whole] = loads
        return before._replace(load=load, energy=self.energy())

"""What a knit's energy is made of: terms of one form, summed by the workspace.

Each term is an energy of the configuration in which it was last placed, with its gradient and its stiffness. Here are
rods, dead loads and the drag of a viscous fluid; contact with friction is in `contacts`, fused points in `bonds`, hooks
on poles in `hook_friction`.
"""

from typing import Protocol

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.stiffness import add_rod_hessian, rod_hessian
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.sums import inner
from knitlab_core.threads import both

HALVES_FROM = 4000
"""Nodes from which rods are assembled in halves: below, waiting for a thread on a busy machine costs what it saves."""


class Term(Protocol):
    """A part of the energy, in the configuration last placed [E r^3]."""

    def fits(self, pattern: Pattern) -> bool:
        """Return whether a pattern has all blocks of the term's stiffness; the term uses this pattern from now on."""
        ...

    def place(self, q: FloatArray, frames: Frames) -> None:
        """Take a configuration: unknowns (N, 4) and their frames. Neither may change before the next one."""
        ...

    def energy(self) -> float:
        """Return the energy [E r^3]."""
        ...

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the first derivatives to (N, 4)."""
        ...

    def add_hessian(self, exact: float, blocks: FloatArray) -> None:
        """Add the second derivatives to the blocks (B, 4, 4) of the pattern last fitted.

        `exact` is the weight of the second derivatives of distance and slip.
        """
        ...


class RodTerm:
    """Stretching, bending and twisting of the rods.

    Parameters
    ----------
    rods : Rods
        Rest state and stiffness.

    Attributes
    ----------
    q, frames
        The configuration last placed, (N, 4) and its frames.
    """

    q: FloatArray
    frames: Frames
    _pattern: Pattern

    def __init__(self, rods: Rods) -> None:
        self.rods = rods

    def fits(self, pattern: Pattern) -> bool:
        """Take a pattern; every pattern has the blocks of nodes that follow each other."""
        self._pattern = pattern
        return True

    def place(self, q: FloatArray, frames: Frames) -> None:
        """Take a configuration."""
        self.q, self.frames = q, frames

    def parts(self) -> tuple[float, float, float]:
        """Return the energies of stretching, bending and twisting [E r^3]."""
        stretch, bend, twist = rod_energy(self.q, self.rods, self.frames)
        return stretch, bend, twist

    def energy(self) -> float:
        """Return the elastic energy [E r^3]."""
        return sum(self.parts())

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the elastic forces to a gradient (N, 4)."""
        rod_gradient(self.q, self.rods, self.frames, gradient)

    def add_hessian(self, _: float, blocks: FloatArray) -> None:
        """Add the stiffness; of many nodes in two halves that share no block, then the nodes between them."""
        q, frames, pattern = self.q, self.frames, self._pattern
        if len(q) < HALVES_FROM:
            rod_hessian(q, self.rods, frames, 1.0, pattern, blocks)
            return
        middle = len(q) // 2

        def add(first: int, last: int) -> None:
            add_rod_hessian(q, self.rods, frames, 1.0, pattern, blocks, first, last)

        # A span acts on its two neighbours.
        both(lambda: add(0, middle), lambda: add(middle + 2, len(q)))
        add(middle, middle + 2)


class DeadLoads:
    """Constant loads on the unknowns.

    Parameters
    ----------
    n : int
        Nodes.

    Attributes
    ----------
    loads : (N, 4) array
        The loads [E r^2, E r^3].
    """

    _q: FloatArray

    def __init__(self, n: int) -> None:
        self.loads = np.zeros((n, 4))

    def fits(self, _: Pattern) -> bool:
        """Return True: loads have no stiffness."""
        return True

    def place(self, q: FloatArray, _: Frames) -> None:
        """Take a configuration."""
        self._q = q

    def energy(self) -> float:
        """Return the potential of the loads [E r^3]."""
        return -inner(self.loads, self._q)

    def add_gradient(self, gradient: FloatArray) -> None:
        """Subtract the loads."""
        gradient -= self.loads

    def add_hessian(self, _: float, blocks: FloatArray) -> None:
        """Add nothing."""


class Drag:
    """Resistance of every node to its motion since the step began, as by a viscous fluid in pseudo-time.

    Parameters
    ----------
    coefficient : float
        Force over motion [E r].
    origin : (N, 4) array
        Configuration in which the step began.
    """

    _pattern: Pattern
    _moved: FloatArray

    def __init__(self, coefficient: float, origin: FloatArray) -> None:
        self.coefficient = coefficient
        self._origin = origin[:, :3].copy()

    def fits(self, pattern: Pattern) -> bool:
        """Take a pattern; every pattern has its diagonal."""
        self._pattern = pattern
        return True

    def place(self, q: FloatArray, _: Frames) -> None:
        """Take a configuration."""
        self._moved = q[:, :3] - self._origin

    def energy(self) -> float:
        """Return c |x - x0|^2 / 2 [E r^3]."""
        return 0.5 * self.coefficient * inner(self._moved, self._moved)

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the resistance to a gradient (N, 4)."""
        gradient[:, :3] += self.coefficient * self._moved

    def add_hessian(self, _: float, blocks: FloatArray) -> None:
        """Add the coefficient to the diagonal."""
        blocks[self._pattern.diagonal[:, None], range(3), range(3)] += self.coefficient

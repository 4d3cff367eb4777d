"""Rods whose sections yield: elastic ones with moved rest strains, and what these lack, as a term of the energy."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.relaxation import rod_strains
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.yield_stiffness import add_yield_hessian
from knitlab_core.rods.yielding import Yielding, relieve


class YieldingRodTerm(RodTerm):
    """Stretching, bending and twisting of rods that yield, over one step.

    Parameters
    ----------
    made : Rods
        The rods as made.
    step : Rods
        The elastic rods of the step, with what relaxes.
    law : Yielding
        How sections yield.
    plastic : (N, K, P + R) array
        Plastic strains where the step begins; not changed.
    """

    def __init__(self, made: Rods, step: Rods, law: Yielding, plastic: FloatArray) -> None:
        copies = {name: getattr(step, name).copy() for name in ("rest_stretch", "rest_curvature", "rest_twist")}
        super().__init__(step._replace(**copies))
        self._made, self._step, self._law, self._plastic = made, step, law, plastic
        self._new: BoolArray = np.logical_not(np.any(plastic, axis=2))
        self._moved = np.column_stack(
            [
                step.rest_stretch[:, 0] - made.rest_stretch[:, 0],
                step.rest_curvature - made.rest_curvature,
                step.rest_twist - made.rest_twist,
                step.rest_stretch[:, 1] - made.rest_stretch[:, 1],
            ]
        )
        self._strain, self._beyond = np.zeros((len(plastic), 5)), 0.0

    def place(self, q: FloatArray, frames: Frames) -> None:
        """Take a configuration, and move the rest strains to what its sections bear."""
        super().place(q, frames)
        rods, step = self.rods, self._step
        rods.rest_stretch[:], rods.rest_curvature[:] = step.rest_stretch, step.rest_curvature
        rods.rest_twist[:] = step.rest_twist
        self._strain = rod_strains(q, self._made, frames)
        self._beyond = relieve(self._strain, self._moved, self._law, self._plastic, self._new, rods)

    def energy(self) -> float:
        """Return the incremental potential of the step: energy, and what plastic flow dissipates; constants apart."""
        return super().energy() + self._beyond

    def add_hessian(self, exact: float, blocks: FloatArray) -> None:
        """Add the stiffness, with the consistent tangent of sections that yield."""
        super().add_hessian(exact, blocks)
        add_yield_hessian(
            self.q,
            self._made,
            self.frames,
            self._strain,
            self._law,
            self._plastic,
            self._new,
            self._pattern,
            blocks,
        )

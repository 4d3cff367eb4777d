"""What a workspace carries from one equilibrium to the next beside the state."""

from typing import NamedTuple

from knitlab_core.arrays import FloatArray


class SolverState(NamedTuple):
    """All that a new workspace needs to go on as an old one would, to the last bit.

    `q`: (N, 4) configuration in which the pattern of the stiffness was made, and with it the order of elimination;
    `hold`: (B,) share of its stiffness that each bond had then, None for all of it; `shift`: of the last
    factorisation [E r].
    """

    q: FloatArray
    hold: FloatArray | None
    shift: float

"""Newton steps that bring friction's loads along: a system that is not symmetric, solved by GMRES about the factor."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.pattern import free_only
from knitlab_core.equilibrium.ties import gather
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.sparse.gmres import solve_coupled


def load_coupling(work: Workspace, v: FloatArray) -> FloatArray:
    """Return the change (N, 4) of the free forces by friction's loads when the strands move by `v` (N, 4)."""
    out = np.zeros_like(v)
    with work.clock("coupling"):
        work.contacts.add_load_coupling(v, out)
        if work.hooks is not None:
            work.hooks.add_load_coupling(v, out)
        if work.model.ties is not None:
            gather(work.model.ties, out)
        free_only(work.model.fixed, out)
    return out


def coupled_step(work: Workspace, step: FloatArray, tolerance: float) -> FloatArray:
    """Return the Newton step (N, 4) that brings friction's loads along, given the one that holds them.

    `tolerance` is that of its residual, relative to `step`.
    """
    with work.clock("coupling"):
        return solve_coupled(lambda v: work.stiffness.solve(load_coupling(work, v)), step, tolerance, work.basis)

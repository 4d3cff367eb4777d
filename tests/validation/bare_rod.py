"""One rod alone: no contact with itself, and its stiffness as a plain matrix.

Radius and modulus are 1, so lengths are in r, forces in E r² and bending stiffness is π/4.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State

EI = pi / 4.0


def bare_rod(
    nodes: NDArray[np.float64], *, straight: bool = False, poisson_ratio: float = 0.3
) -> tuple[Workspace, State]:
    """Make a rod of unit radius and modulus through nodes [r], with no contact."""
    model, state = make_model(
        [nodes], radius=1.0, young_modulus=1.0, poisson_ratio=poisson_ratio, friction=0.0, straight=straight
    )
    # No pair is ever listed, so no step needs cutting for the sake of one.
    law = model.law._replace(exclusion=np.inf, overlap_limit=np.inf)
    return Workspace(replace(model, law=law)), state


def settle(work: Workspace, state: State, target: NDArray[np.float64], *, tolerance: float = 1e-7) -> State:
    """Return the equilibrium with fixed unknowns at a target; fail the test where there is none."""
    found, report = advance(work, state, target, Options(tolerance=tolerance, max_iterations=200))
    assert found is not None, report
    return found


def stiffness(work: Workspace, state: State) -> NDArray[np.float64]:
    """Return the exact stiffness (4N, 4N) of all unknowns, fixed ones included."""
    work.move_to(state.q, state.frames)
    work.assemble()
    unit = np.eye(state.q.size).reshape(-1, *state.q.shape)
    return np.stack([work.stiffness.times(v).ravel() for v in unit], axis=1)

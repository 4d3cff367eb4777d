"""A straight rod held at both ends that relaxes, and its Prony series in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.relaxation import Relaxation
from tests.validation.bare_rod import bare_rod

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State

TIGHT = Options(tolerance=1e-9, max_iterations=100)
PRONY = Relaxation(np.array([0.3, 0.2, 0.1]), np.array([0.5, 5.0, 60.0]))
SOLID = Relaxation(np.array([0.4]), np.array([2.0]))


def modulus(prony: Relaxation, t: float) -> float:
    """Return E(t)/E."""
    return 1.0 - float(prony.shares @ -np.expm1(-t / prony.times))


def mean_modulus(prony: Relaxation, t: float, since: float) -> float:
    """Return the mean of E(s)/E over ages s from t - since to t: stress over strain of a ramp that ran till then."""
    age = t - since
    decay = np.exp(-age / prony.times) * -np.expm1(-since / prony.times) * prony.times / since
    return prony.lasting + float(prony.shares @ decay)


def relaxing_rod(prony: Relaxation | None, *, edges: int = 8, straight: bool = False) -> tuple[Workspace, State]:
    """Make a rod along x, edges of 2 r, with its first two nodes clamped."""
    line = np.outer(np.arange(edges + 1.0), [2.0, 0.0, 0.0])
    work, state = bare_rod(line, straight=straight)
    work = Workspace(replace(work.model, relaxation=prony))
    work.model.fixed[:2] = True
    return work, state


def step(work: Workspace, state: State, target: NDArray[np.float64], duration: float) -> State:
    """Return the equilibrium after a step; fail the test where there is none."""
    found, report = advance(work, state, target, TIGHT, duration=duration)
    assert found is not None, report
    return found

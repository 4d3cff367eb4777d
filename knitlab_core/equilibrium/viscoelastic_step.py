"""A step of rods that relax: elastic rods for the search, and what they remember after it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.relaxation import Relaxation, relaxed_rods, remember, rod_strains, stored_energy, viscous_work


@contextmanager
def relaxing(work: Workspace, state: State, duration: float) -> Iterator[None]:
    """Search with the rods of one step; elastic rods stay what they are.

    Contact samples keep the rest lengths of the rods as made, and contacts their elastic law.
    """
    model = work.model
    if model.relaxation is None:
        yield
        return
    strain = rod_strains(state.q, model.rods, state.frames)
    rods = relaxed_rods(model.rods, model.relaxation, strain, _history(model.relaxation, state), duration)
    work.model = replace(model, rods=rods)
    try:
        yield
    finally:
        work.model = model


def relaxed(model: Model, before: State, after: State, duration: float) -> State:
    """Return the equilibrium after a step with its history, stored energy and viscous work."""
    relaxation = model.relaxation
    if relaxation is None:
        return after
    rods, history = model.rods, _history(relaxation, before)
    begin = rod_strains(before.q, rods, before.frames)
    end = rod_strains(after.q, rods, after.frames)
    kept = remember(relaxation, history, begin, end, duration)
    lost = viscous_work(rods, relaxation, history, begin, end, duration)
    return replace(
        after,
        history=kept,
        energies=np.append(stored_energy(rods, relaxation, end, kept), after.energies[3]),
        viscous_work=before.viscous_work + lost,
    )


def _history(relaxation: Relaxation, state: State) -> FloatArray:
    return relaxation.unstrained(len(state.q)) if state.history is None else state.history

"""A step of rods that relax: elastic rods for the search, and what they remember after it."""

from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.rods.relaxation import Relaxation, relaxed_rods, remember, rod_strains, stored_energy, viscous_work
from knitlab_core.rods.rod import Rods


def rods_of_step(model: Model, state: State, duration: float) -> Rods:
    """Return the elastic rods by which a step of a duration [s] is searched; those of the model if nothing relaxes.

    Contact samples keep the rest lengths of the rods as made, and contacts their elastic law.
    """
    if model.relaxation is None:
        return model.rods
    strain = rod_strains(state.q, model.rods, state.frames)
    return relaxed_rods(model.rods, model.relaxation, strain, _history(model.relaxation, state), duration)


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

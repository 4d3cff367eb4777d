"""A step of rods that relax or yield: the rods for the search, and what they remember after it."""

from dataclasses import replace

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.yielding_rods import YieldingRodTerm
from knitlab_core.rods.relaxation import (
    Relaxation,
    elastic_energies,
    relaxed_rods,
    remember,
    rod_strains,
    stored_energy,
    viscous_work,
)
from knitlab_core.rods.yielding import Yielding, flow


def rods_of_step(model: Model, state: State, duration: float) -> RodTerm:
    """Return the rods by which a step of a duration [s] is searched.

    Contact samples keep the rest lengths of the rods as made, and contacts their elastic law.
    """
    rods = model.rods
    if model.relaxation is not None:
        strain = rod_strains(state.q, model.rods, state.frames)
        rods = relaxed_rods(model.rods, model.relaxation, strain, _history(model.relaxation, state), duration)
    if model.yielding is None:
        return RodTerm(rods)
    return YieldingRodTerm(model.rods, rods, model.yielding, _plastic(model.yielding, state))


def after_step(model: Model, before: State, after: State, duration: float) -> State:
    """Return the equilibrium after a step with what relaxes and yields brought up to date, and the energies stored."""
    relaxation, yielding, rods = model.relaxation, model.yielding, model.rods
    if relaxation is None and yielding is None:
        return after
    end = rod_strains(after.q, rods, after.frames)
    elastic = elastic_energies(rods, end)
    stored: FloatArray = elastic.sum(axis=0)
    if relaxation is not None:
        history = _history(relaxation, before)
        begin = rod_strains(before.q, rods, before.frames)
        kept = remember(relaxation, history, begin, end, duration)
        lost = viscous_work(rods, relaxation, history, begin, end, duration)
        stored = stored_energy(rods, relaxation, end, kept)
        after = replace(after, history=kept, viscous_work=before.viscous_work + lost)
    if yielding is not None:
        plastic, relieved = _plastic(yielding, before).copy(), np.zeros((len(end), 2))
        work = flow(end, yielding, rods, plastic, relieved)
        stored = stored - _shares(elastic, relieved)
        after = replace(after, plastic=plastic, plastic_work=before.plastic_work + work)
    return replace(after, energies=np.append(stored, after.energies[3]))


def _shares(elastic: FloatArray, relieved: FloatArray) -> FloatArray:
    """Divide what sections do not store (N, 2) into stretching, bending and twisting (3,), as if they were elastic."""
    bent = elastic[:, 0] + elastic[:, 1]
    share = np.divide(elastic[:, 0], bent, out=np.zeros(len(bent)), where=bent > 0.0)
    parts = np.column_stack([share * relieved[:, 0], (1.0 - share) * relieved[:, 0], relieved[:, 1]])
    return np.asarray(parts.sum(axis=0))


def _history(relaxation: Relaxation, state: State) -> FloatArray:
    return relaxation.unstrained(len(state.q)) if state.history is None else state.history


def _plastic(yielding: Yielding, state: State) -> FloatArray:
    return yielding.unstrained(len(state.q)) if state.plastic is None else state.plastic

"""Two crossed strands that overlap as laid in: the radius grows, and what is found is what fixtures press together."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from knitlab_core.contact.law import make_law, pair_potential, scaled_law
from knitlab_core.equilibrium.laying_in import lay_in
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.workspace import Workspace

APART = 1.2
"""Distance of the two centrelines as laid in [r]: clear of each other below a share of 0.6."""


def crossed(apart: float) -> tuple[Model, State]:
    """Return two straight strands at right angles, their ends held."""
    along = np.linspace(-12.0, 12.0, 25)
    zero, height = np.zeros(25), np.full(25, apart)
    strands = [np.column_stack([along, zero, zero]), np.column_stack([zero, along, height])]
    model, state = make_model(
        strands, radius=1.0, young_modulus=1.0, poisson_ratio=0.3, friction=0.0, straight=True, printed=False
    )
    for end in (0, 1, 23, 24, 25, 26, 48, 49):
        model.fixed[end] = True
    return model, state


@cache
def grown() -> tuple[Model, State]:
    model, state = crossed(APART)
    return model, lay_in(model, state, 0.5)


def gap(state: State) -> float:
    """Return the distance of the two centrelines where they cross [r]."""
    return float(state.q[37, 2] - state.q[12, 2])


def test_strands_that_overlapped_as_laid_in_are_bent_apart_to_their_whole_radius() -> None:
    _, state = grown()
    assert 1.85 < gap(state) < 2.05
    assert state.contacts > 0
    assert state.energies[1] > 0.0


def test_the_equilibrium_is_that_of_strands_that_fixtures_press_together() -> None:
    _, state = grown()
    pressed, begun = crossed(2.2)

    def target(share: float) -> np.ndarray:
        q = begun.q.copy()
        q[25:, 2] -= share * (2.2 - APART)
        return q

    *_, (_, found, _) = march(Workspace(pressed), begun, target, longest=0.25)
    upper = np.arange(25, 50)
    force, wanted = (float(one.reaction[upper, 2].sum()) for one in (state, found))
    assert wanted < 0.0
    assert force == pytest.approx(wanted, rel=1e-3)
    assert gap(state) == pytest.approx(gap(found), abs=1e-3)
    assert state.external_work == 0.0


def test_a_scaled_law_begins_at_a_share_of_the_distance_and_is_as_stiff() -> None:
    law = make_law(0.3, 0.3)
    half = scaled_law(law, 0.5)
    assert half.distance == 0.5 * law.distance
    assert half.reach - half.distance == pytest.approx(law.reach - law.distance)
    # Deep overlap is another matter: there the barrier is at a share too.
    assert pair_potential(0.01, half)[0] == pytest.approx(pair_potential(0.01, law)[0], rel=0.02)
    assert scaled_law(law, 1.0) == law

"""Overdamped motion after a break: to rest, along friction's path, losing energy and never gaining any."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.march import march, settle_after_break
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.rupture import break_fibre, weakest
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.transient import come_down
from knitlab_core.equilibrium.workspace import Workspace
from tests.validation.knit import Knit, make_knit

if TYPE_CHECKING:
    from knitlab_core.equilibrium.model import State


def drawn() -> tuple[Knit, Workspace, State]:
    knit = make_knit(2, nodes_per_loop=16)
    work = Workspace(knit.model)
    *_, (_, state, _) = march(work, knit.start, lambda s: knit.target(0.3 * s), longest=0.1)
    return knit, work, state


def test_a_break_sets_energy_free_the_same_every_time() -> None:
    knit, work, state = drawn()
    edge = weakest(knit.model, state).edge
    (_, first), (_, second) = break_fibre(work, state, edge), break_fibre(Workspace(knit.model), state, edge)
    np.testing.assert_array_equal(first.q, second.q)
    assert first.fracture_work == second.fracture_work
    assert 0.0 < first.fracture_work < float(state.energies.sum())
    assert first.friction_work > state.friction_work


def test_the_equilibrium_after_a_break_is_one_of_the_cut_knit() -> None:
    knit, work, state = drawn()
    left, found = break_fibre(work, state, weakest(knit.model, state).edge)
    again, report = settle_after_break(left, replace(found, increment=np.zeros_like(found.q)))
    assert again is not None
    assert report.iterations <= 1
    assert np.abs(again.q - found.q).max() < 1e-3


def test_motion_that_does_not_come_to_rest_is_reported() -> None:
    _, work, state = drawn()
    # Nothing is as near to balance as this asks for.
    found, report = come_down(work, state, RodTerm(work.model.rods), Options(tolerance=0.0))
    assert found is None
    assert not report.converged

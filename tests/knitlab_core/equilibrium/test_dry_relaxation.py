from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.equilibrium.dry_relaxation import knit_in
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError, SpecificationError
from knitlab_core.rods.relaxation import Relaxation
from knitlab_core.rods.rod import measure_strains

TIGHT = Options(tolerance=1e-8, max_iterations=100)


def _arch(*, straight: bool = True, bonds: BondLaw | None = None) -> tuple[Model, State]:
    """Lay a quarter turn of 60 r, its ends held."""
    angle = np.linspace(0.0, np.pi / 2.0, 31)
    nodes = 60.0 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(31)])
    model, state = make_model(
        [nodes], radius=1.0, young_modulus=1.0, poisson_ratio=0.3, friction=0.3, straight=straight, bonds=bonds
    )
    model.fixed[[0, -1], :3] = True
    # A plane arch is as much at rest turned about its chord: its middle is held out of plane.
    model.fixed[15, 2] = True
    return model, state


def _knitted(model: Model, state: State) -> State:
    *_, (share, found, report) = knit_in(Workspace(model), state, options=TIGHT)
    assert share == 1.0
    assert report.converged
    return found


def test_fixtures_stay_and_the_yarn_moves() -> None:
    model, state = _arch()
    found = _knitted(model, state)
    assert np.array_equal(found.q[model.fixed], state.q[model.fixed])
    assert np.abs(found.q - state.q).max() > 0.5


def test_a_yarn_at_rest_as_laid_stays() -> None:
    model, state = _arch(straight=False)
    found = _knitted(model, state)
    assert np.abs(found.q - state.q).max() < 1e-9
    assert found.energies.sum() < 1e-15


def test_energy_is_that_of_the_straight_yarn_and_works_begin_at_nought() -> None:
    model, state = _arch()
    found = _knitted(model, state)
    curvature = np.zeros((31, 2))
    measure_strains(found.q, model.rods.is_inner, found.frames, curvature, np.zeros(31))
    inner = model.rods.is_inner
    bend = 0.5 * np.pi / 4.0 * float(((curvature**2).sum(axis=1)[inner] / model.rods.span[inner]).sum())
    assert found.energies[1] == pytest.approx(bend, rel=1e-9)
    assert (found.external_work, found.friction_work, found.viscous_work, found.fracture_work) == (0.0, 0.0, 0.0, 0.0)
    assert not found.increment.any()


def test_the_model_is_the_callers_at_every_equilibrium_and_after() -> None:
    model, state = _arch()
    work = Workspace(model)
    way = knit_in(work, state)
    for _ in way:
        assert work.model is model
    assert work.model is model


def test_the_model_is_the_callers_after_a_failure() -> None:
    model, state = _arch()
    work = Workspace(model)
    with pytest.raises(ConvergenceError):
        list(knit_in(work, state, options=Options(tolerance=1e-8, max_iterations=0)))
    assert work.model is model


def test_what_relaxes_has_relaxed_when_the_test_begins() -> None:
    model, state = _arch()
    slow = replace(model, relaxation=Relaxation(np.array([0.3, 0.1]), np.array([1.0, 50.0])))
    quick, late = _knitted(model, state), _knitted(slow, state)
    assert np.allclose(late.q, quick.q, atol=1e-5)
    assert np.allclose(late.reaction, 0.6 * quick.reaction, atol=1e-8)
    assert np.allclose(late.energies, 0.6 * quick.energies, rtol=1e-4, atol=1e-12)
    assert late.history is None


def test_fused_points_are_refused() -> None:
    bonds = BondLaw(fuse_gap=1.0, patch_radius=0.1, strength=1.0, shear_strength=1.0)
    model, state = _arch(bonds=bonds)
    with pytest.raises(SpecificationError, match=r"model\.bonds: found '0 fused points', allowed none"):
        next(knit_in(Workspace(model), state))

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import GeometryError
from tests.contact_scenes import straight
from tests.knitlab_core.equilibrium.strands import crossing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import Model, State


def test_only_the_dummy_angles_at_the_strands_ends_are_fixed() -> None:
    line = np.zeros((5, 3))
    line[:, 0] = np.arange(5.0)
    model, _ = make_model(
        [line, line + np.array([0.0, 9.0, 0.0])], radius=0.1, young_modulus=1.0, poisson_ratio=0.3, friction=0.0
    )
    np.testing.assert_array_equal(np.argwhere(model.fixed), [[4, 3], [9, 3]])


def test_lengths_are_counted_in_radii_and_forces_in_e_r_squared() -> None:
    model, state = crossing(gap=0.5)
    assert model.scales.length == 1e-3
    assert model.scales.force == pytest.approx(1e3)
    np.testing.assert_allclose(state.q[17:, 2], 2.5)


@pytest.mark.parametrize("unbent", [False, True])
def test_an_arc_is_free_of_stress_if_it_rests_as_given(unbent: bool) -> None:  # noqa: FBT001
    t = np.linspace(0.0, np.pi, 21)
    arc = np.column_stack([np.cos(t), np.sin(t), 0.1 * t])
    model, state = make_model([arc], radius=0.05, young_modulus=1.0, poisson_ratio=0.3, friction=0.0, straight=unbent)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    gradient = work.gradient()
    assert (np.abs(gradient).max() < 1e-12) is not unbent


def _crossing(gap: float, *, printed: bool = False) -> tuple[Model, State]:
    """Make two strands of unit radius that cross a gap apart, neither over a sample of the other."""
    lower = straight((0.13, 0.0, 0.0), (1.0, 0.0, 0.0), 24.0)
    upper = straight((0.0, 0.29, 2.0 + gap), (0.4, 1.0, 0.0), 24.0)
    return make_model([lower, upper], radius=1.0, young_modulus=1.0, poisson_ratio=0.3, friction=0.3, printed=printed)


def _forces(model: Model, state: State, towards: float = 0.0) -> NDArray[np.float64]:
    """Return the gradient (N, 4) with the upper strand moved towards the lower one [r]."""
    q = state.q.copy()
    q[len(q) // 2 :, 2] -= towards
    work = Workspace(model)
    work.start_step(q, state.frames, state.memory)
    return work.gradient()


@pytest.mark.parametrize("gap", [0.03, 1e-3, 1e-7, 0.0, -0.1])
def test_printed_strands_feel_nothing_as_printed_and_each_other_once_they_move(gap: float) -> None:
    model, state = _crossing(gap, printed=True)
    assert not _forces(model, state).any()
    for towards in (0.02, 0.1):
        pressed = _forces(model, state, gap + towards if gap > 0.0 else towards)
        assert pressed[len(pressed) // 2 :, 2].sum() < 0.0
    # Without being told so it is no print: strands may be given pressed together.
    assert _forces(*_crossing(gap)).any()


def test_printed_strands_beyond_the_onset_make_the_model_they_always_made() -> None:
    for one, other in zip(_crossing(0.041, printed=True), _crossing(0.041), strict=True):
        assert pickle.dumps(one) == pickle.dumps(other)


def test_wires_as_mounted_press_on_nothing() -> None:
    yarn, wire = straight((0, 0, 0), (1, 0, 0), 24.0), straight((0.3, 2.001, 0), (0, 0, 1), 20.0)
    model, state = make_model(
        [yarn], radius=1.0, young_modulus=1.0, poisson_ratio=0.3, friction=0.3, printed=True, wires=[wire]
    )
    assert not _forces(model, state).any()


def test_strands_that_no_mesh_would_bring_together_are_refused() -> None:
    with pytest.raises(GeometryError, match=r"overlap by 0\.4 contact radii .* a finer mesh"):
        _crossing(-0.4, printed=True)


def test_samples_carry_the_whole_length_between_the_end_half_edges() -> None:
    model, _ = crossing(gap=0.5)
    carried = model.samples.length[model.samples.spans].sum() * len(model.samples.weights)
    assert carried == pytest.approx(2 * (16.0 - 1.0))

import numpy as np
import pytest

from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from tests.unit.equilibrium.strands import crossing


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


@pytest.mark.parametrize("straight", [False, True])
def test_an_arc_is_free_of_stress_if_it_rests_as_given(straight: bool) -> None:  # noqa: FBT001
    t = np.linspace(0.0, np.pi, 21)
    arc = np.column_stack([np.cos(t), np.sin(t), 0.1 * t])
    model, state = make_model([arc], radius=0.05, young_modulus=1.0, poisson_ratio=0.3, friction=0.0, straight=straight)
    work = Workspace(model)
    work.start_step(state.q, state.frames, state.memory)
    gradient = work.gradient(state.q, state.frames)
    assert (np.abs(gradient).max() < 1e-12) is not straight


def test_samples_carry_the_whole_length_between_the_end_half_edges() -> None:
    model, _ = crossing(gap=0.5)
    carried = model.samples.length[model.samples.spans].sum() * len(model.samples.weights)
    assert carried == pytest.approx(2 * (16.0 - 1.0))

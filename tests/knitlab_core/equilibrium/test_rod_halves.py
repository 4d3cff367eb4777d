import numpy as np
import pytest

from knitlab_core import threads
from knitlab_core.arrays import FloatArray
from knitlab_core.equilibrium import terms
from knitlab_core.equilibrium.workspace import Workspace
from tests.knitlab_core.equilibrium.strands import crossing


def test_rods_in_halves_have_the_bits_of_one_thread_and_the_stiffness_of_the_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model, state = crossing(gap=0.1)
    q = state.q + np.random.default_rng(1).normal(0.0, 0.05, state.q.shape)

    def blocks() -> FloatArray:
        work = Workspace(model)
        work.start_step(state.q, state.frames, state.memory)
        work.move_to(q, state.frames)
        work.assemble()
        return work.stiffness.blocks

    whole, before = blocks(), threads.thread_count()
    monkeypatch.setattr(terms, "HALVES_FROM", 0)
    try:
        threads.use_threads(1)
        one = blocks()
        threads.use_threads(2)
        two = blocks()
    finally:
        threads.use_threads(before)
    np.testing.assert_array_equal(one, two)
    np.testing.assert_allclose(one, whole, rtol=0.0, atol=1e-14 * np.abs(whole).max())

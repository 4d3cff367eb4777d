"""Drag of a fluid on the strands of a periodic cell is no force on the cell, however many images are dragged along."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.ties import gather
from tests.validation.cells import TIGHT, make_test


@pytest.mark.parametrize("drag", [0.0, 1e-3, 1.0])
def test_the_reaction_of_a_cell_is_the_force_of_its_strands_whatever_drags(drag: float) -> None:
    test = make_test((1, 1))
    test.stretch((0.36, 0.36), steps=4)
    target = test.state.q.copy()
    target[test.nodes[1], 0] += 0.02 * test.printed[1, 1]
    found, report = advance(test.work, test.state, target, TIGHT, drag=drag)
    assert found is not None, report
    work, ties = test.work, test.work.model.ties
    assert ties is not None
    strands = np.zeros_like(found.q)
    for term in work.terms:
        if term is not work.drag:
            term.add_gradient(strands)
    gather(ties, strands)
    reaction, expected = found.reaction[test.nodes, :3], strands[test.nodes, :3]
    held = work.model.fixed[test.nodes, :3]
    np.testing.assert_allclose(reaction[held], expected[held], atol=1e-9 * np.abs(expected).max())
    assert np.abs(reaction).max() > 0.0

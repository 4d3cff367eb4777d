"""Laying a thick yarn into a cell: it comes to rest without a force on the cell, wherever it began."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.contact.compression import Compression
from knitlab_core.contact.law import make_yarn_law, pair_potential, scaled_law
from knitlab_core.equilibrium.cell_relaxation import relax_cell
from knitlab_core.equilibrium.periodic import Period, make_cell
from knitlab_core.knits import Counts, Stitch, knit_cell
from knitlab_core.rods.section import measured_section
from tests.measured_yarns import measured_yarn

YARN_OF_A_STITCH = 11.28e-3


def test_a_sized_law_keeps_its_form() -> None:
    law = make_yarn_law(0.7, 2.4, 0.44, 0.3)
    small = scaled_law(law, 0.5, 3.0)
    for share in (0.1, 0.5, 0.9):
        psi, _, _ = pair_potential(share * law.overlap_limit, law)
        assert pair_potential(share * small.overlap_limit, small)[0] == pytest.approx(3.0 * psi, rel=1e-12)
    assert small.distance - small.overlap_limit == pytest.approx(0.5 * (law.distance - law.overlap_limit))


def at_rest(height: float, spacing: float, nodes: int = 24) -> np.ndarray:
    """Return the lengths of a stitch at rest, course and wale [m], of a yarn laid into a stitch as high as this."""
    stitch = Stitch(curvature=1.5, height=height, depth=0.3, row_spacing=spacing, fibre_radius=0.05)
    drawn = stitch.loop_length(Counts(1, 1))
    yarn = measured_yarn(rigidity=0.95)
    specimen = knit_cell(
        stitch,
        loop_width=YARN_OF_A_STITCH / drawn,
        rows=1,
        loops=1,
        nodes_per_loop=nodes,
        contact_radius=yarn.radius.value,
    )
    assert specimen.cell is not None
    assert specimen.clearance < 0.0
    periods = [Period(strand[:-2], along) for strand, along in zip(specimen.strands, specimen.cell.shifts, strict=True)]
    model, state = make_cell(
        periods,
        specimen.cell.vectors,
        specimen.cell.reach,
        radius=yarn.radius.value,
        young_modulus=yarn.reference_modulus,
        poisson_ratio=0.0,
        friction=0.2,
        section=measured_section(yarn),
        compression=Compression.of(yarn),
        straight=True,
    )
    found, iterations = relax_cell(model, state)
    assert iterations > 0
    assert found.external_work == 0.0
    lengths = found.q[[-2, -1], [0, 1]] * model.scales.length
    # What is prescribed of the cell feels no force along its lengths.
    assert np.abs(found.reaction[[-2, -1], [0, 1]]).max() == 0.0
    return lengths


@pytest.mark.slow
def test_the_fabric_at_rest_does_not_depend_on_how_it_was_drawn() -> None:
    one, other = at_rest(0.55, 0.69), at_rest(0.65, 0.79)
    np.testing.assert_allclose(one, other, rtol=0.01)


def test_a_stitch_at_rest_is_wider_than_high() -> None:
    # As of every stockinette, about as 1.3 to 1.6 in knitting practice (Munden 1959); this yarn is a thick one.
    course, wale = at_rest(0.55, 0.69, nodes=16)
    assert 1.3 < course / wale < 1.8

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import (
    NAMED_STITCHES,
    NAMED_VOLUMETRIC_STITCHES,
    Yarn,
    knit_specimen,
    wires_through,
)
from knitlab_core.knits.crossing import crossing_number
from knitlab_core.knits.wires import GAP, HALF_LENGTH, OUTWARDS


@pytest.mark.parametrize("name", sorted(NAMED_STITCHES))
@pytest.mark.parametrize("size", [1, 2, 3])
def test_wires_are_clear_of_the_yarn_and_of_each_other(name: str, size: int) -> None:
    specimen = knit_specimen(NAMED_STITCHES[name], rows=size, loops=size, loop_width=8e-3)
    line = specimen.centreline
    yarn = line.position(np.linspace(0.0, line.length, 20_000)) * specimen.loop_width
    # The nodes are centred, the line is not.
    yarn += specimen.nodes[0] - specimen.loop_width * line.position(np.array([0.0]))[0]
    middles = []
    for edge in OUTWARDS:
        for loop in wires_through(specimen, edge):
            for nodes in loop.nodes:
                assert np.ptp(nodes[:, :2]) == pytest.approx(np.ptp(nodes[0, :2]))
                assert np.ptp(nodes[:, 2]) == pytest.approx(2 * HALF_LENGTH * specimen.radius)
                gap = np.linalg.norm(yarn[:, :2] - nodes[0, :2], axis=1).min() / specimen.radius - 2.0
                assert 0.8 * GAP < gap < 1.2 * GAP
                middles.append(nodes[0, :2])
    apart = np.linalg.norm(np.array(middles)[:, None] - np.array(middles)[None], axis=-1)
    assert apart[~np.eye(len(middles), dtype=bool)].min() > 2.0 * specimen.radius


def test_every_hook_with_a_loop_is_a_wire() -> None:
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=3, loops=3, loop_width=8e-3)
    hooks = {edge: [loop.hooks for loop in wires_through(specimen, edge)] for edge in OUTWARDS}
    # The yarn begins at the lower left and ends at the upper right.
    assert hooks == {
        "course-": [(1, 2)],
        "course+": [(0, 1)],
        "wale-": [(1, 2), (3, 4), (5,)],
        "wale+": [(0, 1), (2, 3), (4, 5)],
    }


def test_loops_go_around_their_wires() -> None:
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=2, loop_width=8e-3)
    for edge, outwards in OUTWARDS.items():
        for loop in wires_through(specimen, edge):
            at = specimen.sites[edge][list(loop.hooks)]
            span = specimen.nodes[max(at.min() - 12, 0) : at.max() + 13]
            for wire in loop.nodes:
                way = np.array([*outwards, 0.0])
                assert abs(crossing_number(span, wire[[0, -1]])) == 1
                # Outside the loop nothing holds it.
                assert crossing_number(span, wire[[0, -1]] + 8 * specimen.radius * way) == 0


def test_what_cannot_hang_on_wires_is_refused() -> None:
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=1, loops=2, loop_width=8e-3)
    thick = replace(specimen, yarn=Yarn(fibre_radius=0.15), radius=0.15 * 8e-3)
    with pytest.raises(
        GeometryError, match=r"hook: found 'a wire that overlaps by .* mm at row 0, loop 0', allowed pin"
    ):
        wires_through(thick, "wale+")
    volumetric = knit_specimen(
        NAMED_VOLUMETRIC_STITCHES["volumetric-default"], rows=2, loops=2, layers=2, loop_width=8e-3
    )
    with pytest.raises(SpecificationError, match="hook: found 'wire in a volumetric knit', allowed pin"):
        wires_through(volumetric, "course+")

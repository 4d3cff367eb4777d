"""Loops of a periodic cell at rest, of which a specimen of a yarn by measurement is made."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, cast

from knitlab_core.equilibrium.cell_relaxation import relax_cell
from knitlab_core.knits import knit_cell, relaxed_stitch
from rigs.protocol.edges import OPEN
from rigs.protocol.strands import model_of

if TYPE_CHECKING:
    from knitlab_core.knits import RelaxedStitch, Stitch
    from rigs.protocol.specimen import SpecimenSpec

SIDE: Final = 2
"""Rows, and loops in a row, of the cell."""


def relaxed_loops(spec: SpecimenSpec) -> tuple[RelaxedStitch, float]:
    """Return the stitch of a specimen as a periodic cell of it is at rest, and its loop width [m].

    Raises
    ------
    GeometryError
        If strands are too near each other as drawn.
    ConvergenceError
        If the yarn comes to no rest.
    """
    return _relaxed(replace(spec, rows=SIDE, loops=SIDE, relaxed=False, periodic=True, edges=OPEN))


@lru_cache(maxsize=4)
def _relaxed(spec: SpecimenSpec) -> tuple[RelaxedStitch, float]:
    """Return the stitch of a cell at rest, and its loop width [m]."""
    drawn = cast("Stitch", spec.fabric)
    specimen = knit_cell(
        drawn,
        rows=spec.rows,
        loops=spec.loops,
        loop_width=spec.loop_width,
        nodes_per_loop=spec.nodes_per_loop,
        contact_radius=spec.grows_to,
    )
    model, state = model_of(specimen, spec, ())
    found, _ = relax_cell(model, state)
    at = model.scales.length * found.q[:, :3]
    return relaxed_stitch(drawn, at[: len(specimen.nodes)], at[-2:], specimen.counts, specimen.radius)

"""Pull a small knit at its four edges, as the pins of the biaxial stage do, and keep every equilibrium.

Pins on the course edges hold x and z and let the yarn slide along y; those on the wale edges hold y and z.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_STITCHES, SiteSet, Specimen, knit_specimen
from rigs.protocol.made_specimen import gauge_lengths

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.contact.bond_law import BondLaw
    from knitlab_core.equilibrium.newton import Options

FloatArray = NDArray[np.float64]

LOOP_WIDTH: Final = 8e-3
YOUNG_MODULUS: Final = 0.82e9
POISSON_RATIO: Final = 0.37

EDGES: Final[tuple[tuple[SiteSet, int, float], ...]] = (
    ("course-", 0, -0.5),
    ("course+", 0, 0.5),
    ("wale-", 1, -0.5),
    ("wale+", 1, 0.5),
)
"""Each edge's axis, and the share of the axis's displacement that it makes."""


class Row(NamedTuple):
    """One equilibrium: strain, force [N] along course and wale, works and elastic energy [J]."""

    strain: float
    force: tuple[float, float]
    external_work: float
    friction_work: float
    energy: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Knit:
    """A specimen on its four edges, not yet pulled; `gauge` is its length along course and wale [r].

    It is that of the yarn, the same for every mesh: nodes lie beside the yarn, the further the coarser the mesh.
    """

    specimen: Specimen
    model: Model
    start: State
    gauge: tuple[float, float]

    def target(self, strain: float) -> FloatArray:
        """Return where the pins stand (N, 4) at an equibiaxial strain."""
        q = self.start.q.copy()
        for edge, axis, share in EDGES:
            q[self.specimen.sites[edge], axis] += share * self.gauge[axis] * strain
        return q

    def force(self, state: State) -> tuple[float, float]:
        """Return the force by which course and wale are pulled [N], the mean of both edges."""
        total = np.zeros(2)
        for edge, axis, share in EDGES:
            total[axis] += share * state.reaction[self.specimen.sites[edge], axis].sum()
        course, wale = total * self.model.scales.force
        return float(course), float(wale)

    def held(self) -> NDArray[np.int64]:
        """Return the nodes on pins."""
        return np.unique(np.concatenate([self.specimen.sites[edge] for edge, _, _ in EDGES]))


def make_knit(
    size: int,
    *,
    friction: float = 0.3,
    loop_width: float = LOOP_WIDTH,
    young_modulus: float = YOUNG_MODULUS,
    nodes_per_loop: int = 48,
    bonds: BondLaw | None = None,
) -> Knit:
    """Make size x size loops of the default stockinette with pins on its edges."""
    stitch = NAMED_STITCHES["stockinette-default"]
    specimen = knit_specimen(stitch, rows=size, loops=size, loop_width=loop_width, nodes_per_loop=nodes_per_loop)
    model, start = make_model(
        [specimen.nodes],
        radius=specimen.radius,
        young_modulus=young_modulus,
        poisson_ratio=POISSON_RATIO,
        friction=friction,
        bonds=bonds,
    )
    for edge, axis, _ in EDGES:
        pins = specimen.sites[edge]
        model.fixed[pins, axis] = model.fixed[pins, 2] = True
    gauge = gauge_lengths(specimen)
    length = model.scales.length
    return Knit(specimen=specimen, model=model, start=start, gauge=(gauge["C"] / length, gauge["W"] / length))


def pull(
    knit: Knit, strains: Sequence[float], *, steps: int, options: Options | None = None
) -> tuple[list[Row], State]:
    """Go from strain to strain in so many steps each, from the knit as made; return a row per step and the end.

    A step that the march had to cut is one row all the same: rows up and down stand at the same strains.
    """
    work, state, rows = Workspace(knit.model), knit.start, [Row(0.0, (0.0, 0.0), 0.0, 0.0, 0.0)]
    joule = knit.model.scales.energy
    marks = [np.linspace(begin, end, steps + 1) for begin, end in pairwise([0.0, *strains])]
    for begin, end in (pair for stroke in marks for pair in pairwise(stroke)):

        def path(s: float, begin: float = begin, end: float = end) -> FloatArray:
            return knit.target(begin + (end - begin) * s)

        *_, (_, state, _) = march(work, state, path, longest=1.0, options=options)
        rows.append(
            Row(
                strain=float(end),
                force=knit.force(state),
                external_work=joule * state.external_work,
                friction_work=joule * state.friction_work,
                energy=joule * float(state.energies.sum()),
            )
        )
    return rows, state


def loop_area(knit: Knit, rows: Sequence[Row]) -> float:
    """Return the work lost over a closed path [J]: the integral of force over displacement (trapezium rule)."""
    force = np.array([row.force for row in rows])
    strain = np.array([row.strain for row in rows])
    travel = np.outer(strain, knit.gauge) * knit.model.scales.length
    return float(sum(np.trapezoid(force[:, axis], travel[:, axis]) for axis in (0, 1)))

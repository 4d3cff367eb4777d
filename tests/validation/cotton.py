"""Knit cotton in on pins and measure the relaxed state in ways that do not know the mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from scipy.interpolate import CubicSpline

from knitlab_core.equilibrium.dry_relaxation import STEPS, knit_in
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.strands import SAMPLE_SPACING
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_STITCHES, Specimen, knit_specimen
from knitlab_core.materials import material_named
from tests.validation.knit import EDGES, FloatArray

if TYPE_CHECKING:
    from knitlab_core.arrays import IndexArray as IntArray

Hooks = Literal["slide", "stay"]

COTTON: Final = material_named("cotton-2-ply")
ARCS: Final = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Laid:
    """A knit of cotton as laid in, on its hooks; `ways` (2, N, 4) are the motions of course and wale carriages."""

    specimen: Specimen
    model: Model
    state: State
    ways: FloatArray

    @property
    def held(self) -> IntArray:
        """Return the nodes on hooks."""
        return np.unique(np.concatenate([self.specimen.sites[edge] for edge, _, _ in EDGES]))


def lay(
    stitch: str,
    size: int,
    *,
    hooks: Hooks = "slide",
    friction: float = 0.3,
    nodes_per_loop: int = 48,
    sample_spacing: float = SAMPLE_SPACING,
) -> Laid:
    """Lay size x size loops of cotton on hooks that slide along their poles, or stay where they are."""
    specimen = knit_specimen(
        NAMED_STITCHES[stitch], rows=size, loops=size, loop_width=8e-3, nodes_per_loop=nodes_per_loop
    )
    model, state = make_model(
        specimen.strands,
        radius=specimen.radius,
        young_modulus=COTTON.young_modulus.value,
        poisson_ratio=COTTON.poisson_ratio.value,
        friction=friction,
        straight=True,
        sample_spacing=sample_spacing,
    )
    ways = np.zeros((2, *state.q.shape))
    for edge, axis, share in EDGES:
        pins = specimen.sites[edge]
        model.fixed[pins, axis] = model.fixed[pins, 2] = True
        ways[axis, pins, axis] = share
    laid = Laid(specimen=specimen, model=model, state=state, ways=ways)
    if hooks == "stay":
        model.fixed[laid.held, :3] = True
    return laid


@dataclass(frozen=True, slots=True, kw_only=True)
class Relaxed:
    """What a relaxed state is, in the solver's units.

    `shape` (n, 3): places of the yarn at equal arc lengths; `bend`: largest curvature; `force` (2,): of the course
    and wale carriages; `felt` (2,): the same with every hook's force counted as positive; `press`: sum of all normal
    forces of contacts; `iterations`: of Newton, in all.
    """

    state: State
    energy: float
    force: FloatArray
    felt: FloatArray
    press: float
    bend: float
    shape: FloatArray
    iterations: int


def relax(laid: Laid, *, steps: int = STEPS) -> Relaxed:
    """Knit a yarn in and measure what comes out."""
    found = list(knit_in(Workspace(laid.model), laid.state, steps=steps))
    _, state, _ = found[-1]
    arc = np.asarray(laid.specimen.arc_lengths)
    nodes = state.q[:, :3]
    yarn = np.concatenate([nodes[:1], (nodes[:-2] + 6.0 * nodes[1:-1] + nodes[2:]) / 8.0, nodes[-1:]])
    return Relaxed(
        state=state,
        energy=float(state.energies.sum()),
        force=np.tensordot(laid.ways, state.reaction, 2),
        felt=np.tensordot(np.abs(laid.ways), np.abs(state.reaction), 2),
        press=float(state.memory.load.sum()),
        bend=_largest_curvature(laid.model, nodes),
        shape=CubicSpline(arc / arc[-1], yarn)(np.linspace(0.0, 1.0, ARCS)),
        iterations=sum(report.iterations for _, _, report in found),
    )


def _largest_curvature(model: Model, nodes: FloatArray) -> float:
    edges = np.diff(nodes, axis=0)
    t = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    turn = 2.0 * np.arctan2(np.linalg.norm(t[1:] - t[:-1], axis=1), np.linalg.norm(t[1:] + t[:-1], axis=1))
    return float((turn / model.rods.span[1:-1]).max())


def apart(one: Relaxed, other: Relaxed) -> dict[str, float]:
    """Return how far two relaxed states are apart.

    Energy, largest curvature and the contacts' pressing relative to the other's, the carriages' forces relative to
    what their hooks feel, and the mean distance of the yarn's places relative to a loop's width of 20 r.
    """
    course, wale = (one.force - other.force) / other.felt
    return {
        "energy": one.energy / other.energy - 1.0,
        "largest curvature": one.bend / other.bend - 1.0,
        "pressing of contacts": one.press / other.press - 1.0,
        "course force": float(course),
        "wale force": float(wale),
        "shape": float(np.linalg.norm(one.shape - other.shape, axis=1).mean()) / 20.0,
    }

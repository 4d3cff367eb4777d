"""Pull a yarn of fibres, as one rod and fibre by fibre: ``python -m benchmarks.yarn_of_fibres``.

The smallest patch in which a stitch holds another: 2 x 2 loops of the default stockinette, pulled biaxially by hooks
on its sites. Every yarn has the area of the default's single fibre. The tables stand in docs/decisions/0008 and 0042.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_STITCHES, SiteSet, knit_specimen
from knitlab_core.knits.fibres import Yarn, fibre_sites, fibre_strands, same_area
from knitlab_core.knits.mesh import control_points
from knitlab_core.rods.section import SOLID, yarn_section

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray, IndexArray

LOOP_WIDTH: Final = 8e-3
EDGES: Final[tuple[tuple[SiteSet, int, float], ...]] = (
    ("course-", 0, -0.5),
    ("course+", 0, 0.5),
    ("wale-", 1, -0.5),
    ("wale+", 1, 0.5),
)
STEP: Final = 0.025
SHOWN: Final = (0.05, 0.1, 0.2, 0.3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Patch:
    """Hold a patch on its hooks; `sites` are nodes of all strands together, `gauge` in the solver's unit."""

    model: Model
    start: State
    sites: Mapping[SiteSet, IndexArray]
    gauge: FloatArray


def fused_along(bundle: Yarn) -> BondLaw:
    """Return unbreakable necks, as wide as a fibre, between fibres of a bundle that lie just apart."""
    radius = LOOP_WIDTH * bundle.fibre_radius
    return BondLaw(fuse_gap=0.2 * radius, patch_radius=0.5 * radius, strength=1e12)


def make_patch(
    yarn: Yarn, *, friction: float = 0.3, contact: float = 1.0, bonds: BondLaw | None = None, nodes_per_loop: int = 48
) -> Patch:
    """Print a patch of a yarn; `contact` is a factor on the stiffness of crossings."""
    stitch = NAMED_STITCHES["stockinette-default"]
    printed = knit_specimen(stitch, rows=2, loops=2, loop_width=LOOP_WIDTH, nodes_per_loop=nodes_per_loop)
    bundle = yarn.model == "bundle"
    middle = replace(yarn, fibres=1, winding_radius=0.0)
    strands = fibre_strands(printed.centreline, printed.arc_lengths / LOOP_WIDTH, yarn if bundle else middle)
    model, start = make_model(
        [LOOP_WIDTH * control_points(points) for points in strands],
        radius=LOOP_WIDTH * yarn.contact_radius,
        young_modulus=0.82e9,
        poisson_ratio=0.37,
        friction=friction,
        section=SOLID if bundle else yarn_section(yarn),
        bonds=bonds,
    )
    model = replace(model, law=model.law._replace(coefficient=contact * model.law.coefficient))
    count = len(printed.nodes)
    sites = {edge: fibre_sites(at, nodes=count, fibres=len(strands)) for edge, at in printed.sites.items()}
    gauge = np.zeros(2)
    for edge, axis, share in EDGES:
        model.fixed[sites[edge], axis] = model.fixed[sites[edge], 2] = True
        gauge[axis] += 2.0 * share * start.q[sites[edge], axis].mean()
    return Patch(model=model, start=start, sites=sites, gauge=gauge)


def pull(patch: Patch, largest: float) -> tuple[FloatArray, int, float]:
    """Pull to a strain; return rows (k, 3) of strain and forces [N], iterations and the share of work lost."""

    def target(part: float) -> FloatArray:
        q = patch.start.q.copy()
        for edge, axis, share in EDGES:
            q[patch.sites[edge], axis] += share * patch.gauge[axis] * largest * part
        return q

    rows, iterations, state = [np.zeros(3)], 0, patch.start
    for part, state, report in march(Workspace(patch.model), patch.start, target, longest=STEP / largest):
        force = np.zeros(2)
        for edge, axis, share in EDGES:
            force[axis] += share * state.reaction[patch.sites[edge], axis].sum()
        rows.append(np.array([part * largest, *(patch.model.scales.force * force)]))
        iterations += report.iterations
    return np.array(rows), iterations, state.friction_work / state.external_work


def show(name: str, patch: Patch, largest: float = 0.3) -> None:
    """Pull a patch and print its line."""
    began = process_time()
    rows, iterations, lost = pull(patch, largest)
    seconds = process_time() - began
    course, wale = (np.interp(SHOWN, rows[:, 0], rows[:, k], right=np.nan) for k in (1, 2))
    figures = "  ".join(f"{c:7.4f} {w:7.4f}" for c, w in zip(course, wale, strict=True))
    print(f"{name:28s} {figures}  {iterations:5d} {seconds:6.1f} {100.0 * lost:5.1f}", flush=True)


def main() -> None:
    """Print all tables."""
    single = Yarn(fibre_radius=NAMED_STITCHES["stockinette-default"].fibre_radius)
    pull(make_patch(single), STEP)  # compiles the kernels
    strains = "  ".join(f"{f'at {strain:.0%}':>15s}" for strain in SHOWN)
    print(f"{'force, course and wale [N]':28s} {strains}  iter.      s  lost %")
    show("1 fibre", make_patch(single))
    for n in (2, 3, 4, 6, 7, 8):
        yarn = same_area(single.fibre_radius, n)
        show(f"{n}, yarn, loose", make_patch(yarn))
        show(f"{n}, yarn, glued", make_patch(replace(yarn, bonding=1.0)))
    for n, largest in ((2, 0.3), (3, 0.3), (4, 0.3), (7, 0.1)):
        bundle = same_area(single.fibre_radius, n, model="bundle")
        show(f"{n}, bundle", make_patch(bundle), largest)
        if n < 7:
            show(f"{n}, bundle, fused along", make_patch(bundle, bonds=fused_along(bundle)))
    three = same_area(single.fibre_radius, 3)
    for factor in (0.5, 2.0):
        show(f"3, yarn, loose, contact x{factor:g}", make_patch(three, contact=factor))
    for friction in (0.0, 0.6):
        show(f"3, yarn, loose, friction {friction:g}", make_patch(three, friction=friction))
        show(f"3, bundle, friction {friction:g}", make_patch(replace(three, model="bundle"), friction=friction))
    for n, twist in ((2, 2.0), (2, 4.0), (3, 2.0), (3, 4.0)):
        bundle = same_area(single.fibre_radius, n, model="bundle")
        wound = replace(bundle, twist=twist, winding_radius=1.02 * bundle.winding_radius)
        show(f"{n}, bundle, twist {twist:g}", make_patch(wound))
    for n in (2, 3, 4):
        show(f"{n} of r = 0.025, yarn, loose", make_patch(same_area(0.025 * n**0.5, n)))


if __name__ == "__main__":
    main()

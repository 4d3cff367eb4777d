"""Yarns of fibres: wound ones against the helix, bundles against the sum of their fibres, one rod against a bundle."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas import from_yaml
from benchmarks.yarn_of_fibres import fused_along, make_patch, pull
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits.fibres import Yarn, fibre_strands, same_area
from knitlab_core.rods.section import yarn_section
from tests.curves import Straight, yarn_of
from tests.validation.bare_rod import settle
from tests.validation.test_cantilever import TIP

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from knitlab_core.contact.bond_law import BondLaw
    from knitlab_core.equilibrium.model import Model, State

WINDING, TWIST = 0.1, 4.0
LOAD = 1.0
"""Of the cantilevers, in n EI / L²."""


def wound() -> NDArray[np.float64]:
    """Return one turn of a fibre that winds around a straight line, in 400 edges."""
    turn = 2.0 * pi / TWIST
    yarn = Yarn(fibres=2, fibre_radius=0.02, winding_radius=WINDING, twist=TWIST, model="bundle")
    return fibre_strands(yarn_of(Straight(length=turn)), np.linspace(0.0, turn, 401), yarn)[1]


def test_length_of_a_turn(bar: Callable[..., None]) -> None:
    found = np.linalg.norm(np.diff(wound(), axis=0), axis=-1).sum()
    theory = 2.0 * pi * sqrt(WINDING**2 + 1.0 / TWIST**2)
    bar("wound fibre, length of a turn", found / theory - 1.0, limit=1e-5, unit="1", source="helix")


def test_curvature_of_a_wound_fibre(bar: Callable[..., None]) -> None:
    edges = np.diff(wound(), axis=0)
    length = np.linalg.norm(edges, axis=-1)
    tangent = edges / length[:, None]
    found = np.linalg.norm(np.diff(tangent, axis=0), axis=-1) / (0.5 * (length[1:] + length[:-1]))
    theory = WINDING / (WINDING**2 + 1.0 / TWIST**2)
    bar("wound fibre, curvature", np.abs(found / theory - 1.0).max(), limit=1e-4, unit="1", source="helix")


def straight_bundle(fibres: int, length: float, nodes: int) -> tuple[Model, State]:
    """Make parallel fibres of unit radius and modulus along x, just apart, without friction."""
    yarn = same_area(0.05, fibres, model="bundle")
    centreline = yarn_of(Straight(length=length * yarn.fibre_radius))
    strands = fibre_strands(centreline, np.linspace(0.0, centreline.length, nodes), yarn)
    return make_model(
        [points / yarn.fibre_radius for points in strands],
        radius=1.0,
        young_modulus=1.0,
        poisson_ratio=0.3,
        friction=0.0,
    )


@pytest.mark.parametrize("fibres", [2, 3, 7])
def test_stretched_bundle(bar: Callable[..., None], fibres: int) -> None:
    model, state = straight_bundle(fibres, 40.0, 17)
    ends = np.flatnonzero(np.isclose(state.q[:, 0] % 40.0, 0.0))
    model.fixed[ends, :3] = True
    target = state.q.copy()
    target[:, 0] *= 1.01
    end = settle(Workspace(model), state, target)
    found = end.reaction[np.isclose(state.q[:, 0], 40.0), 0].sum()
    bar(f"bundle of {fibres}, stretched by 1 %", found / (fibres * pi * 0.01) - 1.0, 1e-6, "1", "n E A strain")
    assert ends.size == 2 * fibres
    assert end.contacts == 0


def tip_load(model: Model, state: State, tip: int) -> float:
    """Clamp every strand's first edge, push node `tip` down as far as LOAD would; return its load [E r²] L²."""
    roots = np.flatnonzero(state.q[:, 0] < 1e-9)
    for root in (roots, roots + 1):
        model.fixed[root, :3] = True
    model.fixed[roots, 3] = True
    # Round fibres without friction do not stay on top of each other by themselves.
    model.fixed[:, 1] = True
    model.fixed[tip, 2] = True
    # A clamped edge keeps its direction up to its middle, so the wall stands there.
    length = state.q[tip, 0] - 0.5 * state.q[1, 0]

    def path(part: float) -> NDArray[np.float64]:
        q = state.q.copy()
        q[tip, 2] -= part * TIP[LOAD] * length
        return q

    *_, (_, end, _) = march(Workspace(model), state, path, longest=0.1)
    return float(-end.reaction[tip, 2] * length**2)


def test_loose_bundle_bends_as_its_fibres(bar: Callable[..., None]) -> None:
    # Two fibres, one above the other: what pushes the upper one reaches the lower one by contact alone.
    nodes = 61
    model, state = straight_bundle(2, 200.0, nodes)
    assert state.q[0, 2] > state.q[nodes, 2]
    found = tip_load(model, state, nodes - 1) / (LOAD * 2.0 * pi / 4.0)
    bar("loose bundle, cantilever", found - 1.0, limit=0.01, unit="1", source="elastica with n EI")


@pytest.mark.parametrize(("bonding", "name"), [(0.0, "loose"), (1.0, "glued")])
def test_yarn_as_one_rod_bends_as_its_section(bar: Callable[..., None], bonding: float, name: str) -> None:
    yarn = Yarn(fibres=3, fibre_radius=0.02, winding_radius=0.03, bonding=bonding)
    nodes = np.zeros((81, 3))
    nodes[:, 0] = np.linspace(0.0, 20.0, 81)
    model, state = make_model(
        [nodes],
        radius=yarn.contact_radius,
        young_modulus=1.0,
        poisson_ratio=0.3,
        friction=0.0,
        section=yarn_section(yarn),
    )
    # EI of three discs, by Steiner where they are glued, in the solver's unit.
    disc = pi / 4.0 * 0.02**4 + bonding * pi * 0.02**2 * 0.03**2 / 2.0
    found = tip_load(model, state, 80) / (LOAD * 3.0 * disc / yarn.contact_radius**4)
    bar(f"{name} yarn as one rod, cantilever", found - 1.0, 0.005, "1", "elastica with n EI, Steiner")


def test_a_printed_bundle_is_free_of_stress() -> None:
    patch = make_patch(same_area(0.05, 4, model="bundle"))
    work, state = Workspace(patch.model), patch.start
    work.start_step(state.q, state.frames, state.memory)
    assert work.lag() == 0
    assert np.abs(work.gradient()).max() < 1e-12


def test_one_rod_stands_for_a_loose_bundle(bar: Callable[..., None]) -> None:
    yarn = same_area(0.05, 2)
    rod, _, _ = pull(make_patch(yarn), 0.3)
    bundle, _, _ = pull(make_patch(same_area(0.05, 2, model="bundle")), 0.3)
    for strain, limit in ((0.05, 0.005), (0.3, 0.05)):
        for axis, name in ((1, "course"), (2, "wale")):
            found, wanted = (np.interp(strain, rows[:, 0], rows[:, axis]) for rows in (rod, bundle))
            title = f"yarn of 2 as one rod, {name} force at {strain:.0%}"
            bar(title, found / wanted - 1.0, limit, "1", "fibre by fibre; docs/decisions/0008")


PRINTED = """
schema: knitlab/protocol@1
rig: biaxial-hook
specimen:
  knit: stockinette-default
  loops: [2, 2]
  loop: 8 mm
  material: RGD8530-DM
  yarn: {{fibres: {fibres}}}
others: hold
steps:
  - ramp: {{axes: [C, W], to: 10 %, rate: 0.2 mm/s}}
"""


def force(yarn: Yarn, bonds: BondLaw | None = None) -> NDArray[np.float64]:
    """Return the force (2,) of a patch along course and wale at 10 % of strain [N]."""
    return pull(make_patch(yarn, bonds=bonds, nodes_per_loop=16), 0.1)[0][-1, 1:]


@pytest.fixture(scope="module")
def single() -> NDArray[np.float64]:
    return force(Yarn(fibre_radius=0.05))


def test_more_fibres_of_equal_area_stiffen_a_printed_yarn(
    bar: Callable[..., None], single: NDArray[np.float64]
) -> None:
    # The paper's finding; its yarns of n fibres have the single fibre's area.
    found = {}
    for fibres in (2, 3, 4, 6, 8):
        yarn = from_yaml(PRINTED.format(fibres=fibres)).specimen.yarn
        assert yarn is not None
        found[fibres] = float((force(yarn) / single).min())
    bar(
        "printed yarn of 2 to 8 fibres, 1 / least stiffening",
        1.0 / min(found.values()),
        0.8,
        "1",
        "the paper: n stiffens",
    )
    assert found[3] < found[4] < found[6] < found[8]


def test_fibres_fused_one_by_one_stiffen_as_a_glued_yarn_does(single: NDArray[np.float64]) -> None:
    bundle = same_area(0.05, 3, model="bundle")
    assert np.all(force(bundle) < 0.4 * single)
    for fused in (force(bundle, fused_along(bundle)), force(same_area(0.05, 3, bonding=1.0))):
        assert np.all(fused > 1.25 * single)

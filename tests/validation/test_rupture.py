"""Fibres that break: at which strain, and what the rest then carries."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.rupture import OVERSHOOT, break_fibre, reach_rupture, weakest
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.materials import material_named
from tests.validation.bare_rod import bare_rod
from tests.validation.knit import make_knit
from tests.validation.viscous_rod import SOLID, TIGHT, relaxing_rod, step

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State
    from knitlab_core.rods.relaxation import Relaxation

EA = np.pi
SOURCE = "brittle linear solid: |axial| + r |bending| = limit"


def breaking_strain() -> float:
    """Return the strain at which a resin breaks that stays linear up to its strength."""
    limit = replace(material_named("RGD8530-DM"), elongation_at_break=None).breaking_strain
    assert limit is not None
    return limit.value


def fibres(lengths: tuple[int, ...], relaxation: Relaxation | None = None) -> tuple[Workspace, State]:
    """Make straight fibres along x of so many edges of 2 r, 20 r apart, clamped at both ends."""
    strands = [
        np.column_stack([2.0 * np.arange(edges + 1.0), np.full((edges + 1, 2), 20.0 * number)])
        for number, edges in enumerate(lengths)
    ]
    model, state = make_model(strands, radius=1.0, young_modulus=1.0, poisson_ratio=0.3, friction=0.0)
    for end in np.cumsum([edges + 1 for edges in lengths]):
        model.fixed[[end - 2, end - 1]] = True
    for begin in np.cumsum([0, *(edges + 1 for edges in lengths[:-1])]):
        model.fixed[[begin, begin + 1]] = True
    return Workspace(replace(model, relaxation=relaxation)), state


def drawn(work: Workspace, state: State, travel: float) -> NDArray[np.float64]:
    """Return the target with the right-hand clamps moved along x."""
    q = state.q.copy()
    right = work.model.fixed[:, 0] & (q[:, 0] > 10.0)
    q[right, 0] += travel
    return q


def pull(state: State, nodes: slice) -> float:
    """Return the force along x on the right-hand clamp of a fibre [E r^2]."""
    last = np.arange(len(state.q))[nodes][-2:]
    return float(state.reaction[last, 0].sum())


def test_a_straight_fibre_breaks_at_its_limit(bar: Callable[..., None]) -> None:
    limit = breaking_strain()
    work, rest = fibres((10,))
    # Eight edges of 2 r between the clamps, drawn well beyond the limit in one step.
    travel = 1.37 * limit * 16.0
    share, state, edge, _ = reach_rupture(
        work, rest, lambda s: drawn(work, rest, s * travel), limit=limit, options=TIGHT
    )
    assert state is not None
    assert 1 <= edge < 9
    bar("straight fibre: strain at rupture", share * travel / 16.0 / limit - 1.0, 1e-4, "1", SOURCE)
    bar("straight fibre: force at rupture", pull(state, slice(None)) / (EA * limit) - 1.0, 1e-4, "1", SOURCE)
    assert limit <= weakest(work.model, state).strain <= limit * (1.0 + OVERSHOOT) * (1.0 + 1e-12)


@pytest.mark.parametrize("radius", [1.0, 0.5])
def test_a_bent_fibre_breaks_where_it_curves_too_much(bar: Callable[..., None], radius: float) -> None:
    limit, length, count = breaking_strain(), 1.0, 16
    work, rest = bare_rod(np.outer(length * np.arange(count + 1.0), [1.0, 0.0, 0.0]), straight=True)
    work.model.fixed[:] = True

    def arc(s: float) -> NDArray[np.float64]:
        # Control points of a circle on which every span is as long as it was; the end edges keep their lengths.
        turn = 0.2 * s
        angle = turn * (np.arange(count + 1) - 1)
        circle = 4.0 / (3.0 + np.cos(turn)) * length / max(turn, 1e-12)
        q = np.zeros_like(rest.q)
        q[:, 0], q[:, 1] = circle * np.sin(angle), circle * (1.0 - np.cos(angle))
        for end, inner in ((0, 1), (-1, -2)):
            edge = q[end] - q[inner]
            q[end] = q[inner] + length / np.linalg.norm(edge) * edge
        return q if turn > 0.0 else rest.q

    share, state, _, _ = reach_rupture(work, rest, arc, limit=limit, radius=radius)
    assert state is not None
    curvature = 0.2 * share / length
    bar(f"bent fibre of {radius} r: curvature at rupture", curvature * radius / limit - 1.0, 0.01, "1", SOURCE)


def test_tension_adds_to_bending() -> None:
    work, rest = relaxing_rod(None, straight=True)
    work.model.fixed[:] = True
    q = rest.q.copy()
    q[:, :2] *= 1.01
    turn = 0.02
    q[5:, :2] = q[4, :2] + np.outer(q[5:, 0] - q[4, 0], [np.cos(turn), np.sin(turn)])
    spot = weakest(work.model, step(work, rest, q, 0.0))
    assert spot.edge == 3
    # Edge 3 lies between a straight span and the bent one, whose spline cuts the corner.
    bent = 1.01 * (1.0 + 2.0 * np.cos(0.5 * turn)) / 3.0 - 1.0
    curvature = 3.0 * np.sin(turn) / (2.0 + np.cos(turn)) / 2.0
    assert spot.strain == pytest.approx(0.5 * (0.01 + bent) + curvature, rel=1e-9)


def test_a_path_that_stays_below_the_limit_breaks_nothing() -> None:
    work, rest = fibres((10,))
    share, state, _, _ = reach_rupture(work, rest, lambda s: drawn(work, rest, 0.16 * s), limit=0.02)
    assert (share, state) == (1.0, None)


@pytest.mark.parametrize("edge", [0, 1, 4, 8, 9])
@pytest.mark.parametrize("relaxation", [None, SOLID], ids=["elastic", "relaxing"])
def test_a_broken_fibre_carries_nothing(bar: Callable[..., None], edge: int, relaxation: Relaxation | None) -> None:
    work, rest = fibres((10,), relaxation)
    state = rest
    for travel in 0.48 * np.arange(1, 11) / 10:
        state = step(work, state, drawn(work, rest, travel), 0.1)
    stored, force = float(state.energies.sum()), pull(state, slice(None))
    left, found = break_fibre(work, state, edge)
    if edge in (0, 9):
        # The broken edge lies inside a clamp: what hangs between the clamps is whole.
        assert pull(found, slice(None)) == pytest.approx(force, rel=1e-9)
        assert found.fracture_work == pytest.approx(0.0, abs=1e-12)
        return
    name = f"{'elastic' if relaxation is None else 'relaxing'} fibre broken at edge {edge}"
    bar(f"{name}: force left", pull(found, slice(None)) / force, 1e-6, "1", "equilibrium")
    total = found.external_work - float(found.energies.sum()) - found.viscous_work - found.fracture_work
    bar(f"{name}: energy balance", total / found.external_work, 0.01, "1", "work in = stored + lost + set free")
    # Sudden unloading of what has relaxed leaves stress that balances itself inside the material.
    assert 0.5 * stored < found.fracture_work <= stored * (1.0 + 1e-9)
    on = step(left, found, drawn(work, rest, 0.6), 1.0)
    assert abs(pull(on, slice(None))) < 1e-6 * force


def test_the_other_fibre_carries_on(bar: Callable[..., None]) -> None:
    work, rest = fibres((10, 14))
    state = step(work, rest, drawn(work, rest, 0.48), 0.0)
    first, second = slice(0, 11), slice(11, 26)
    limit = 0.5 * (0.48 / 16.0 + 0.48 / 24.0)
    spot = weakest(work.model, state)
    assert spot.strain > limit
    assert 1 <= spot.edge < 9
    left, found = break_fibre(work, state, spot.edge)
    bar("two fibres, one broken: force on it", pull(found, first) / (EA * 0.03), 1e-6, "1", "equilibrium")
    whole = pull(found, second) / (EA * 0.02) - 1.0
    bar("two fibres, one broken: force on the other", whole, 1e-6, "1", "equilibrium")
    assert weakest(left.model, found).edge in range(12, 24)
    on = step(left, found, drawn(work, rest, 0.6), 0.0)
    assert pull(on, second) == pytest.approx(EA * 0.6 / 24.0, rel=1e-6)
    assert on.fracture_work == found.fracture_work
    assert found.fracture_work == pytest.approx(0.5 * EA * 0.03**2 * 16.0, rel=1e-6)


def test_a_knit_with_a_broken_yarn_carries_less(bar: Callable[..., None]) -> None:
    knit = make_knit(2)
    work, state, before = Workspace(knit.model), knit.start, knit.start
    limit, at = breaking_strain(), 0.0
    while weakest(knit.model, state).strain < limit:
        before, begin = state, at
        at += 0.0125
        *_, (_, state, _) = march(work, before, lambda s: knit.target(begin + 0.0125 * s), longest=1.0)  # noqa: B023
    _, broken, edge, _ = reach_rupture(work, before, lambda s: knit.target(begin + 0.0125 * s), limit=limit)
    assert broken is not None
    left, found = break_fibre(work, broken, edge)
    assert found.external_work == broken.external_work
    assert found.fracture_work > 0.0
    for now, then in zip(knit.force(found), knit.force(broken), strict=True):
        assert 0.0 < now < then
    force = found.reaction[:, :3]
    rest = np.abs(force.sum(axis=0)).max() / np.abs(force).sum()
    bar("knit with a broken yarn: action = reaction", rest, 1e-4, "1", "solver tolerance")
    *_, (_, on, _) = march(left, found, lambda s: knit.target(begin + 0.0125 * (1.0 + s)), longest=1.0)
    assert knit.force(on) > knit.force(found)


def test_a_yarn_may_break_where_it_rubs() -> None:
    knit = make_knit(2, nodes_per_loop=16)
    work = Workspace(knit.model)
    *_, (_, state, _) = march(work, knit.start, lambda s: knit.target(0.3 * s), longest=0.1)
    m, samples = len(knit.model.samples.weights), len(state.q) * len(knit.model.samples.weights)
    rubs = int(state.memory.key[np.argmax(state.memory.load)] // samples // m)
    for edge in (rubs, rubs - 1):  # the node that rubs is the first and the second of the broken edge
        left, found = break_fibre(work, state, edge)
        on = step(left, found, knit.target(0.31), 0.0)
        assert found.fracture_work > 0.0
        for now, then in zip(knit.force(found), knit.force(state), strict=True):
            assert 0.0 < now < then
        assert knit.force(on) > knit.force(found)

"""Yarn by measurement: rods have the stiffnesses that are given, contact has the law of compression that is given."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.integrate import quad

from knitlab_core.contact.compression import Compression
from knitlab_core.contact.law import pair_potential
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.workspace import Workspace
from tests.contact_scenes import sampled, straight, touch
from tests.measured_yarns import measured_yarn, yarn_model
from tests.validation.bare_rod import settle
from tests.validation.test_cantilever import TIP

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State
    from knitlab_core.materials import MeasuredYarn

DEPTHS = np.linspace(0.2, 0.9, 8)
"""Compression over that at which cores meet."""

YARNS = {
    "acrylic": measured_yarn(),
    "steep": measured_yarn(exponent=4.0),
    "shallow": measured_yarn(exponent=2.0, core=0.15e-3),
    "thin shell": measured_yarn(core=0.52e-3),
    "steepest": measured_yarn(exponent=6.0, core=0.15e-3),
}
ALONG = 16.0
"""Length of the upper strand [r]; the spans of its inner nodes carry contact: an edge is missing."""


def line_force(yarn: MeasuredYarn, compression: float) -> float:
    """Return the force by length [N/m] of parallel yarns by SciPy's quadrature of Abel's integral, x = h + (D - h) v^2.

    Its scale is the rigidity, the force halfway.
    """
    radius, core, n = yarn.radius.value, yarn.core.value, yarn.exponent.value
    outer, largest = 2.0 * radius, 2.0 * (radius - core)

    def force(height: float) -> float:
        def push(v: float) -> float:
            x = height + (outer - height) * v * v
            p = (outer - x) / largest
            return float(p ** (n - 1.0) * (1.0 - p) ** (-n - 1.0) / np.sqrt(x + height))

        return float(4.0 * height * np.sqrt(outer - height) * quad(push, 0.0, 1.0, epsrel=1e-10, limit=200)[0])

    return float(yarn.rigidity.value * force(outer - compression) / force(radius + core))


def crossed_force(yarn: MeasuredYarn, compression: float) -> float:
    """Return the force [N] between yarns crossed at right angles, 2 pi h psi: psi by the inverse of Abel's integral."""
    outer = 2.0 * yarn.radius.value
    height, reach = outer - compression, float(np.sqrt(compression))

    def back(v: float) -> float:
        further = (reach * v) ** 2
        return line_force(yarn, compression - further) * 2.0 * reach / float(np.sqrt(2.0 * height + further))

    return float(2.0 * height * quad(back, 0.0, 1.0, epsrel=1e-6)[0])


def normal_force(yarn: MeasuredYarn, compression: float, *, crossed: bool, phase: float) -> float:
    """Return the force [N] between two strands that are pressed into each other."""
    height = 2.0 - compression / yarn.radius.value
    lower = straight((0, 0, 0), (1, 0, 0), 24.0)
    upper = straight((phase, 0, 3.0), (0, 1, 0) if crossed else (1, 0, 0), ALONG)
    model, state = yarn_model([lower, upper], yarn)
    q = state.q.copy()
    q[len(lower) :, 2] = height
    return -model.scales.force * float(touch(model, state, q=q, skin=0.1).gradient(q)[len(lower) :, 2].sum())


@pytest.mark.parametrize("name", YARNS)
@pytest.mark.parametrize("crossed", [True, False], ids=["crossed", "parallel"])
def test_contact_follows_the_law_that_is_given(bar: Callable[..., None], name: str, *, crossed: bool) -> None:
    yarn = YARNS[name]
    law = Compression.of(yarn)
    length = yarn.radius.value * (ALONG - 2.0)
    worst = 0.0
    for depth in DEPTHS:
        compression = depth * law.largest
        expected = crossed_force(yarn, compression) if crossed else length * line_force(yarn, compression)
        for phase in (0.0, 0.3, 0.77):
            error = normal_force(yarn, compression, crossed=crossed, phase=phase) / expected - 1.0
            worst = max(worst, error, key=abs)
    bar(
        f"yarn by measurement, {name}, {'crossed' if crossed else 'parallel'}, compressed by 20 to 90 % of the most",
        figure=worst,
        limit=0.01,
        unit="1",
        source="Abel's integral of the given line force, docs/decisions/0040",
    )


@pytest.mark.parametrize("name", YARNS)
def test_derivatives_of_the_law_up_to_the_core(bar: Callable[..., None], name: str) -> None:
    model, _ = yarn_model([straight((0, 0, 0), (1, 0, 0), 8.0)], YARNS[name])
    law, worst = model.law, 0.0
    for depth in (1e-3, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999):
        p = depth * law.overlap_limit
        step = 1e-5 * min(p, law.overlap_limit - p)
        _, first, second = pair_potential(p, law)
        ahead, behind = pair_potential(p + step, law), pair_potential(p - step, law)
        for order, slope in ((0, first), (1, second)):
            worst = max(worst, abs((ahead[order] - behind[order]) / (2.0 * step) / slope - 1.0))
    bar(
        f"yarn by measurement, {name}: psi' and psi'' against differences, to 99.9 % of the way to the core",
        figure=worst,
        limit=1e-6,
        unit="1",
        source="central differences",
    )


def free_rod(yarn: MeasuredYarn, edges: int, edge: float) -> tuple[Workspace, State]:
    """Return a straight yarn along x that touches nothing, its first edge before the origin [r]."""
    nodes = np.zeros((edges + 1, 3))
    nodes[:, 0] = edge * (np.arange(edges + 1) - 0.5)
    model, state = yarn_model([nodes], yarn)
    law = model.law._replace(exclusion=np.inf, overlap_limit=np.inf)
    work = Workspace(replace(model, law=law))
    work.model.fixed[:2, :3] = True
    work.model.fixed[0, 3] = True
    return work, state


def test_cantilever_bends_by_the_given_stiffness(bar: Callable[..., None]) -> None:
    # A yarn of 148 mm and a load in newtons at its tip: P L^2 / EI = 2.
    yarn, edges = measured_yarn(), 40
    length = 200.0 * yarn.radius.value
    load = 2.0 * yarn.bending.value / length**2
    work, state = free_rod(yarn, edges, 200.0 / (edges - 0.5))
    for part in (0.25, 0.5, 0.75, 1.0):
        work.dead.loads[-1, 2] = -part * load / work.model.scales.force
        state = settle(work, state, state.q, tolerance=1e-8)
    bar(
        "yarn by measurement, cantilever of given EI, 40 edges: drop of the tip",
        figure=-state.q[-1, 2] / 200.0 / TIP[2.0] - 1.0,
        limit=0.005,
        unit="1",
        source="Mattiasson 1981; EI given",
    )


def test_torsion_and_tension_have_the_given_stiffnesses(bar: Callable[..., None]) -> None:
    yarn, edges, edge = measured_yarn(), 20, 2.0
    work, state = free_rod(yarn, edges, edge)
    work.model.fixed[-2:, :3] = True
    work.model.fixed[-2, 3] = True
    target = state.q.copy()
    target[-2, 3] = 0.5
    twisted = settle(work, state, target)
    scales = work.model.scales
    moment = twisted.reaction[-2, 3] * scales.energy
    twist = 0.5 / ((edges - 1) * edge * scales.length)
    source = "linear rod; GJ and EA given"
    bar(
        "yarn by measurement, torsion: moment over GJ and twist",
        figure=moment / (yarn.twisting.value * twist) - 1.0,
        limit=0.005,
        unit="1",
        source=source,
    )
    target = state.q.copy()
    strain = 1e-3
    target[:, 0] *= 1.0 + strain
    pulled = settle(work, state, target)
    force = pulled.reaction[-2:, 0].sum() * scales.force
    bar(
        "yarn by measurement, tension: force over EA and strain",
        figure=force / (yarn.axial.value * strain) - 1.0,
        limit=0.005,
        unit="1",
        source=source,
    )


@pytest.mark.parametrize("name", ["acrylic", "thin shell"])
def test_strands_never_pass_the_core(bar: Callable[..., None], name: str) -> None:
    # Two yarns crossed, both held at their ends, are pushed sixteen radii past touch.
    lower = straight((0, 0, 0), (1, 0, 0), 40.0)
    upper = straight((0.1, 0, 2.2), (0, 1, 0), 40.0)
    model, state = yarn_model([lower, upper], YARNS[name], friction=0.3)
    for first in (0, len(lower)):
        model.fixed[[first, first + 1, first + len(lower) - 2, first + len(lower) - 1]] = True
    start = state.q.copy()

    def path(s: float) -> FloatArray:
        target = start.copy()
        target[len(lower) :, 2] -= 16.0 * s
        return target

    m, strand = len(model.samples.weights), model.samples.strand[model.samples.spans]
    deepest = 0.0
    for _, found, _ in march(Workspace(model), state, path, longest=1.0):
        points = sampled(model, found.q).reshape(-1, m, 3)
        one, other = (points[model.samples.spans[strand == k]].reshape(-1, 3) for k in (0, 1))
        distance = float(np.sqrt(((one[:, None] - other[None]) ** 2).sum(axis=2)).min())
        deepest = max(deepest, (2.0 - distance) / model.law.overlap_limit)
        state = found
    assert np.abs(state.q - path(1.0))[model.fixed].max() == pytest.approx(0.0, abs=1e-12)
    assert deepest > 0.5
    bar(
        f"yarn by measurement, {name}, pushed 16 r past touch: deepest compression over the most",
        figure=deepest,
        limit=1.0,
        unit="1",
        source="no force compresses a core",
    )

"""A cantilever bent far, by a load at its tip and by its own weight."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from tests.validation.bare_rod import EI, bare_rod, settle

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

# Drop of the tip over length, by load PL²/EI and by weight qL³/EI; checked below against the elastica.
TIP = {1.0: 0.301721, 2.0: 0.493457, 5.0: 0.713792, 10.0: 0.810609}
WEIGHT = {1.0: 0.123471, 5.0: 0.495905, 10.0: 0.700200, 20.0: 0.829881}
CASES = [*((load, 0.0, drop) for load, drop in TIP.items()), *((0.0, load, drop) for load, drop in WEIGHT.items())]
NAMES = [*(f"tip load PL²/EI = {load:g}" for load in TIP), *(f"heavy, qL³/EI = {load:g}" for load in WEIGHT)]
SOURCES = ["Bisshopp & Drucker 1945; Mattiasson 1981"] * len(TIP) + ["Rohde 1953; elastica solved here"] * len(WEIGHT)

# In radii: so slender that the stretch of the rod (at most 1e-5) cannot be seen.
LENGTH = 1000.0
EDGES = (10, 20, 40, 80)


def solver_drop(edges: int, tip: float, weight: float) -> float:
    """Return the tip's drop over length for a tip load [EI/L²] and a weight [EI/L³]."""
    # A clamped edge keeps its direction up to its middle, so the wall stands there.
    edge = LENGTH / (edges - 0.5)
    nodes = np.zeros((edges + 1, 3))
    nodes[:, 0] = edge * (np.arange(edges + 1) - 0.5)
    work, state = bare_rod(nodes)
    work.model.fixed[:2, :3] = True
    work.model.fixed[0, 3] = True
    for part in (0.25, 0.5, 0.75, 1.0):
        work.dead.loads[:, 2] = -part * weight * EI / LENGTH**3 * edge
        work.dead.loads[-1, 2] = 0.5 * work.dead.loads[-1, 2] - part * tip * EI / LENGTH**2
        state = settle(work, state, state.q, tolerance=1e-8)
    return float(-state.q[-1, 2] / LENGTH)


def elastica_drop(tip: float, weight: float) -> float:
    """Return the same from θ″ = −(P + q (1 − s)) cos θ, θ(0) = θ′(1) = 0, w′ = sin θ."""
    s, y = np.linspace(0.0, 1.0, 50), np.zeros((3, 50))

    def slope(s: NDArray[np.float64], y: NDArray[np.float64], part: float) -> NDArray[np.float64]:
        return np.array([y[1], -part * (tip + weight * (1.0 - s)) * np.cos(y[0]), np.sin(y[0])])

    for part in (0.1, 0.3, 0.6, 1.0):
        found = solve_bvp(
            lambda s, y, part=part: slope(s, y, part), lambda a, b: np.array([a[0], b[1], a[2]]), s, y, tol=1e-8
        )
        s, y = found.x, found.y
    return float(y[2, -1])


@pytest.mark.parametrize(("tip", "weight", "drop"), CASES, ids=NAMES)
def test_table_is_the_elastica(tip: float, weight: float, drop: float) -> None:
    assert elastica_drop(tip, weight) == pytest.approx(drop, abs=1e-6)


@pytest.mark.parametrize(
    ("tip", "weight", "drop", "name", "source"),
    [(*case, name, source) for case, name, source in zip(CASES, NAMES, SOURCES, strict=True)],
    ids=NAMES,
)
def test_cantilever(bar: Callable[..., None], tip: float, weight: float, drop: float, name: str, source: str) -> None:
    errors = [abs(solver_drop(edges, tip, weight) / drop - 1.0) for edges in EDGES]
    bar(f"cantilever, {name}, 40 edges", figure=errors[2], limit=0.005, unit="1", source=source)
    order = -np.polyfit(np.log(np.array(EDGES) - 0.5), np.log(errors), 1)[0]
    bar(
        f"cantilever, {name}, order of error less 2, where lower",
        figure=min(order - 2.0, 0.0),
        limit=0.2,
        unit="1",
        source=source,
    )

"""A periodic cell: the same whatever is called its inside, and what a large specimen is in its middle."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.periodic import Period, make_cell
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import is_planar
from tests.validation.cells import WIDTH, cut_forces, make_test
from tests.validation.knit import Knit, make_knit, pull

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from knitlab_core.equilibrium.model import State

TIGHT = Options(tolerance=1e-8)


class Pulled(NamedTuple):
    """Rows (k, 5): strains of course and wale [1], their forces per width [N/m], missing work over work [1]."""

    rows: np.ndarray
    workspace: Workspace
    state: State


def stretched(
    rows: int,
    loops: int,
    path: Sequence[tuple[float, float | None]],
    *,
    knit: str = "stockinette-default",
    friction: float = 0.3,
    nodes: int = 24,
    roll: int = 0,
    shift: Sequence[float] = (0.0, 0.0, 0.0),
    steps: int = 16,
    wider: int = 0,
    options: Options = TIGHT,
) -> Pulled:
    """Stretch a cell along a path of strains; the wale is free where it has none.

    `roll` begins each row so many nodes further on, `shift` moves all of them, `wider` looks for contact in more
    images than there can be any.
    """
    one = make_test((rows, loops), knit=knit, friction=friction, nodes=nodes, roll=roll, shift=shift, wider=wider)
    work, state, model, found = one.work, one.state, one.work.model, []
    assert model.ties is not None
    radius = model.scales.length
    course, wale = model.ties.cell
    model.fixed[wale, 1] = path[0][1] is not None
    lengths = state.q[[course, wale], [0, 1]]
    for goal in path:
        start = state.q.copy()
        target = start.copy()
        target[course, 0] = lengths[0] * (1.0 + goal[0])
        if goal[1] is not None:
            target[wale, 1] = lengths[1] * (1.0 + goal[1])

        def place(share: float, start: np.ndarray = start, target: np.ndarray = target) -> np.ndarray:
            return np.asarray(start + share * (target - start))

        for _, now, _ in march(work, state, place, longest=1.0 / steps, options=options):
            force = now.reaction[[course, wale], [0, 1]] * model.scales.force
            strain = now.q[[course, wale], [0, 1]] / lengths - 1.0
            kept = now.energies.sum() + now.friction_work + now.snap_work
            balance = (now.external_work - kept) / max(abs(now.external_work), 1e-300)
            width = np.array([lengths[1], lengths[0]]) * radius
            found.append([*strain, *(force / width), balance])
        state = now
    return Pulled(np.array(found), work, state)


def relative(one: Pulled, other: Pulled, columns: slice = slice(2, 4)) -> float:
    """Return the largest difference of two curves over the largest value, at the places that both have."""
    places = [{tuple(np.round(row[:2], 6)): row[columns] for row in pulled.rows} for pulled in (one, other)]
    a, b = (np.array([rows[place] for place in places[0] if place in places[1]]) for rows in places)
    return float(np.abs(a - b).max() / np.abs(b).max())


def test_a_straight_strand_without_end_is_a_bar(bar: Callable[..., None]) -> None:
    nodes, length, radius = 20, 0.01, 1e-4
    x = np.zeros((nodes, 3))
    x[:, 0] = np.arange(nodes) * length / nodes
    model, state = make_cell(
        [Period(x, (1,))],
        np.array([[length, 0.0, 0.0]]),
        [1],
        radius=radius,
        young_modulus=1e9,
        poisson_ratio=0.3,
        friction=0.3,
    )
    assert model.ties is not None
    (end,) = model.ties.cell
    target = state.q.copy()
    target[end, 0] *= 1.02
    *_, (_, state, _) = march(Workspace(model), state, lambda s: (1.0 - s) * state.q + s * target, longest=1.0)
    bar(
        "periodic: straight strand: force over EA strain",
        state.reaction[end, 0] / (0.02 * np.pi) - 1.0,
        1e-6,
        "1",
        "Hooke",
    )


def test_cells_of_any_size_are_one_fabric(bar: Callable[..., None]) -> None:
    one = stretched(1, 1, [(0.36, 0.36)], friction=0.0)
    for rows, loops in ((2, 2), (2, 1), (4, 4)):
        more = stretched(rows, loops, [(0.36, 0.36)], friction=0.0)
        bar(f"periodic: {rows} x {loops} cell against 1 x 1", relative(more, one), 1e-6, "1", "one fabric")


def test_images_beyond_reach_touch_nothing(bar: Callable[..., None]) -> None:
    path = [(0.36, 0.36)]
    bar(
        "periodic: more images",
        relative(stretched(2, 2, path, wider=1), stretched(2, 2, path)),
        1e-6,
        "1",
        "one fabric",
    )


@pytest.mark.parametrize(("roll", "friction"), [(0, 0.3), (17, 0.0)])
def test_moving_the_fabric_through_the_side_of_its_cell_changes_nothing(
    bar: Callable[..., None], roll: int, friction: float
) -> None:
    """With friction rows of a cell may slip in patterns that rounding chooses: there nothing else is cut elsewhere."""
    path = [(0.36, 0.36), (0.2, 0.2)]
    moved = stretched(2, 2, path, roll=roll, shift=(0.013, -0.031, 0.007), friction=friction)
    fixed = stretched(2, 2, path, friction=friction)
    bar(f"periodic: moved, cut {roll} nodes on", relative(moved, fixed), 1e-6, "1", "invariance")


def test_the_force_on_the_cell_is_the_slope_of_its_energy(bar: Callable[..., None]) -> None:
    """Without friction; the derivative of the energy of equilibria is taken between neighbours."""
    away = 1e-4
    base, *ends = (
        stretched(1, 2, [(0.36 + sign * away, 0.36)], friction=0.0, steps=24).state for sign in (0.0, -1.0, 1.0)
    )
    course = len(base.q) - 2
    lengths = [end.q[course, 0] for end in ends]
    slope = (ends[1].energies.sum() - ends[0].energies.sum()) / (lengths[1] - lengths[0])
    bar("periodic: force over slope of energy", base.reaction[course, 0] / slope - 1.0, 1e-5, "1", "virtual work")


def test_a_free_side_carries_nothing_and_the_work_is_kept(bar: Callable[..., None]) -> None:
    pulled = stretched(2, 2, [(0.8, None), (0.4, None)], steps=32, options=Options())
    peak = int(np.argmax(pulled.rows[:, 2]))
    course, wale = (cut_forces(pulled.workspace, pulled.state, axis, 0.37)[axis] for axis in (0, 1))
    bar("periodic: cut across a free side over the other", abs(wale) / course, 1e-4, "1", "free")
    bar("periodic: energy balance", pulled.rows[peak, 4], 0.01, "1", "energy")
    # Loops that give their yarn to the course are drawn together in the wale.
    assert -0.03 < pulled.rows[peak, 1] < -0.01


def inner_lengths(knit: Knit, state: State, loops: int) -> np.ndarray:
    """Return how long the inner half of a knit is along course and wale [r]: between like points of its loops."""
    specimen = knit.specimen
    line, width = specimen.centreline, specimen.loop_width
    low, high = loops // 4, loops - 1 - loops // 4
    fabric = specimen.fabric
    assert is_planar(fabric)

    def head(row: int, loop: int) -> np.ndarray:
        this = fabric.row(row, loops)
        start = line.starts[2 * row] + float(this.arc_length(np.array([2.0 * np.pi * loop]))[0])
        # Between nodes the yarn is straight enough.
        return np.array([np.interp(start * width, specimen.arc_lengths, state.q[:, c]) for c in range(3)])

    corners = {(row, loop): head(row, loop) for row in (low, high) for loop in (low, high)}
    across = corners[low, high] + corners[high, high] - corners[low, low] - corners[high, low]
    along = corners[high, low] + corners[high, high] - corners[low, low] - corners[low, high]
    return np.array([0.5 * across[0], 0.5 * along[1]])


@pytest.mark.slow
def test_the_middle_of_large_specimens_becomes_the_cell(bar: Callable[..., None]) -> None:
    """Forces per row and per loop at the strains of the inner half, against a cell at those strains.

    With 4, 6, 8, 10, 12 and 16 loops a side they are 53, 27, 17, 14, 12 and 9 % below along the course; along the wale
    31 and 2 % below, then 4.2, 3.9, 3.4 and 2.3 % above.
    """
    errors = []
    for loops in (4, 8, 12):
        knit = make_knit(loops, nodes_per_loop=24, friction=0.0)
        _, peak = pull(knit, [0.4], steps=16)
        before, after = (inner_lengths(knit, state, loops) for state in (knit.start, peak))
        course, wale = after / before - 1.0
        cell = stretched(2, 2, [(float(course), float(wale))], friction=0.0, steps=24)
        mean = np.array(knit.force(peak)) / (loops * WIDTH * np.array([0.86, 1.0]))
        errors.append(np.abs(mean / cell.rows[-1, 2:4] - 1.0))
    # The edges' share of the loops falls like one over the side.
    course, wale = 3.0 * errors[-1] / errors[0]
    bar("periodic: specimens near it like 1 / side, course", course, 1.0, "1", "share of edge loops")
    bar("periodic: specimens near it like 1 / side, wale", wale, 1.0, "1", "share of edge loops")

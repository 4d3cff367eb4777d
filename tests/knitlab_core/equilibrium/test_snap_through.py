from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.snap_through import EASY, SOLID, THICK, THICKER, come_to_rest, kept
from knitlab_core.equilibrium.workspace import Workspace

if TYPE_CHECKING:
    from numpy.typing import NDArray

RISE, HALF, MIDDLE = 8.0, 40.0, 20

# Twice what the arch bears.
FORCE = -0.05


def arch() -> tuple[Model, State]:
    """Return a shallow arch of a stress-free rod in the plane of x and y, its feet clamped [r]."""
    x = np.linspace(-HALF, HALF, 2 * MIDDLE + 1)
    line = np.column_stack([x, 0.5 * RISE * (1.0 + np.cos(np.pi * x / HALF)), np.zeros_like(x)])
    model, state = make_model([1e-3 * line], radius=1e-3, young_modulus=1e9, poisson_ratio=0.3, friction=0.0)
    model.fixed[[0, 1, -2, -1]] = True
    model.fixed[:, 2] = True
    return model, state


def loaded(work: Workspace, state: State, share: float) -> NDArray[np.float64]:
    work.dead.loads[MIDDLE, 1] = share * FORCE
    return state.q


@pytest.fixture(scope="module")
def snapped() -> tuple[State, list[tuple[float, State]]]:
    model, state = arch()
    work = Workspace(model)
    path = march(work, state, lambda share: loaded(work, state, share), longest=0.1, options=Options(max_iterations=8))
    return state, [(share, found) for share, found, _ in path]


def height(state: State) -> float:
    return float(state.q[MIDDLE, 1])


def test_an_arch_snaps_through_and_bears_more_beyond(snapped: tuple[State, list[tuple[float, State]]]) -> None:
    _, way = snapped
    assert way[-1][0] == 1.0
    heights = [height(state) for _, state in way]
    jump = int(np.argmin(np.diff(heights)))
    # Up to the snap it stands above its feet; then it hangs below them.
    assert heights[jump] > 0.3 * RISE
    assert heights[jump + 1] < -0.5 * RISE
    assert np.all(np.diff(heights) < 0.0)


def test_what_a_snap_sets_free_is_counted_and_nothing_else(
    snapped: tuple[State, list[tuple[float, State]]],
) -> None:
    start, way = snapped
    jump = int(np.argmin(np.diff([height(state) for _, state in way])))
    before, after = way[jump][1], way[jump + 1][1]
    free = after.snap_work - before.snap_work
    assert free > 0.0
    assert free == pytest.approx(kept(before) - kept(after))
    # Steps of a growing load err by less than a thousandth of that; rounding decides which of them are counted.
    assert before.snap_work < 1e-3 * free
    assert way[-1][1].snap_work == pytest.approx(after.snap_work, rel=1e-3)
    assert kept(start) == 0.0


def test_what_rests_already_stays_and_sets_nothing_free() -> None:
    model, state = arch()
    work = Workspace(model)
    *_, (_, rests, _) = march(work, state, lambda share: loaded(work, state, 0.05 * share), longest=1.0)
    found, report = come_to_rest(lambda begun, drag: advance(work, begun, begun.q, drag=drag), rests, drag=1e-3)
    assert found is not None
    assert report.converged
    assert height(found) == pytest.approx(height(rests), abs=1e-4)
    assert found.snap_work == pytest.approx(0.0, abs=1e-6 * found.energies.sum())


def test_no_move_of_a_snap_is_longer_than_its_reach() -> None:
    model, state = arch()
    reach = 2.0
    work = Workspace(model)
    target, ways = loaded(work, state, 1.0), []

    def move(begun: State, drag: float) -> tuple[State | None, Report]:
        found, report = advance(work, begun, target, drag=drag)
        if found is not None:
            ways.append(float(np.linalg.norm(found.increment[:, :3], axis=1).max()))
        return found, report

    found, _ = come_to_rest(move, state, drag=1e-6, reach=reach)
    assert found is not None
    kept_to = [way for way in ways if way <= reach]
    # Some moves were too long and made again; those that count lead through the snap.
    assert len(kept_to) < len(ways)
    assert height(found) < -0.5 * RISE
    assert sum(kept_to) >= height(state) - height(found)


def test_what_comes_to_no_rest_is_none() -> None:
    _, state = arch()
    drags = []

    def stuck(_: State, drag: float) -> tuple[State | None, Report]:
        drags.append(drag)
        return None, Report(converged=False, iterations=7, residual=1.0, node=3, contacts=0)

    found, report = come_to_rest(stuck, state, drag=THICK)
    assert found is None
    assert report.iterations == 7 * len(drags)
    assert drags[0] == THICK
    assert drags == sorted(drags)
    assert drags[-1] <= SOLID < THICKER * drags[-1]


def test_it_gives_up_after_the_moves_it_has() -> None:
    _, state = arch()

    def creep(begun: State, _: float) -> tuple[State | None, Report]:
        return begun, Report(converged=True, iterations=EASY + 1, residual=0.0, node=0, contacts=0)

    found, report = come_to_rest(creep, state, drag=THICK, most=5)
    assert found is None
    assert report.iterations == 5 * (EASY + 1)

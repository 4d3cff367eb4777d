from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from knitlab_core.equilibrium import march as march_module
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import Failure, march
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options, Report
from knitlab_core.equilibrium.step_control import FINEST, SMALLEST
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.errors import ConvergenceError
from tests.knitlab_core.equilibrium.strands import crossing, strand, stretched

REPORT = Report(converged=True, iterations=3, residual=1e-6, node=2, contacts=0)


class Road:
    """Stands in for `advance`: the target's first number is the parameter, and some steps fail or change slip."""

    def __init__(
        self,
        *,
        longest: float = 1.0,
        rough: tuple[float, float] = (0.0, 1.0),
        change: Callable[[float, float], float] = lambda _, __: 0.0,
    ) -> None:
        self.longest, self.rough, self.change = longest, rough, change
        self.tried: list[tuple[float, float]] = []
        self.durations: list[float] = []
        self.guesses: list[object] = []

    def advance(
        self,
        _: Workspace,
        state: State,
        target: np.ndarray[Any, Any],
        __: Options | None,
        *,
        duration: float,
        ahead: np.ndarray[Any, Any] | None = None,
        drag: float = 0.0,  # noqa: ARG002 (as the one it stands for)
    ) -> tuple[State | None, Report]:
        begin, end = float(state.increment[0, 0]), float(target[0, 0])
        self.tried.append((begin, end))
        self.durations.append(duration)
        self.guesses.append(ahead)
        if end - begin > self.longest * (1.0 + 1e-9) and begin < self.rough[1] and end > self.rough[0]:
            return None, replace(REPORT, converged=False, residual=0.5)
        return replace(state, increment=target, slip_change=self.change(begin, end)), REPORT


def walk(road: Road, monkeypatch: pytest.MonkeyPatch, longest: float) -> list[float]:
    monkeypatch.setattr(march_module, "advance", road.advance)
    model, state = strand()
    return [s for s, _, _ in march(Workspace(model), state, lambda s: np.full_like(state.q, s), longest=longest)]


@pytest.mark.parametrize(("longest", "count"), [(1.0, 1), (3.0, 1), (0.25, 4), (0.1, 10), (0.3, 4), (1 / 49, 49)])
def test_even_steps_end_on_one(monkeypatch: pytest.MonkeyPatch, longest: float, count: int) -> None:
    found = walk(Road(), monkeypatch, longest)
    assert found[-1] == 1.0
    np.testing.assert_allclose(found, np.arange(1, count + 1) / count, rtol=1e-12)


def test_steps_share_the_time_evenly(monkeypatch: pytest.MonkeyPatch) -> None:
    road = Road(longest=0.125)
    monkeypatch.setattr(march_module, "advance", road.advance)
    model, state = strand()
    list(march(Workspace(model), state, lambda s: np.full_like(state.q, s), longest=0.25, duration=8.0))
    np.testing.assert_allclose(road.durations, [8.0 * (end - begin) for begin, end in road.tried])
    assert {1.0, 2.0} == set(road.durations)


def test_a_failed_step_is_halved_until_it_succeeds(monkeypatch: pytest.MonkeyPatch) -> None:
    road = Road(longest=1 / 16, rough=(0.0, 0.25))
    found = walk(road, monkeypatch, 0.25)
    assert road.tried[:3] == [(0.0, 0.25), (0.0, 0.125), (0.0, 0.0625)]
    assert found[0] == 0.0625
    assert found[-1] == 1.0


def test_steps_grow_again_and_fall_back_on_the_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    found = walk(Road(longest=1 / 32, rough=(0.25, 0.375)), monkeypatch, 0.125)
    assert found[-1] == 1.0
    assert {0.125, 0.25, 0.375, 0.5} <= set(found)
    np.testing.assert_array_equal(found[-4:], [0.625, 0.75, 0.875, 1.0])


def test_steps_do_not_grow_while_slip_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    road = Road(longest=0.0625, rough=(0.0, 0.1), change=lambda _, __: 0.3)
    np.testing.assert_allclose(np.diff(walk(road, monkeypatch, 0.25)), 0.0625)


def test_a_step_across_a_kink_of_slip_is_gone_again_in_shorter_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    kink = 0.3
    road = Road(change=lambda begin, end: 1.0 if begin < kink <= end else 0.0)
    found = walk(road, monkeypatch, 0.25)
    # Down to a sixteenth of the longest step, in quarters, with what the longer step found as a guess.
    assert road.tried[1:4] == [(0.25, 0.5), (0.25, 0.3125), (0.25, 0.265625)]
    assert [guess is None for guess in road.guesses[:4]] == [True, True, False, False]
    across = next(i for i, place in enumerate(found) if place >= kink)
    assert found[across] - found[across - 1] == pytest.approx(FINEST * 0.25)
    # The whole steps are met again.
    assert {0.25, 0.5, 0.75, 1.0} <= set(found)


def test_gives_up_at_the_shortest_step(monkeypatch: pytest.MonkeyPatch) -> None:
    road = Road(longest=0.0, rough=(0.5, 1.0))
    with pytest.raises(ConvergenceError) as caught:
        walk(road, monkeypatch, 0.5)
    begin, end = road.tried[-1]
    assert begin == 0.5
    assert 0.5 * SMALLEST <= end - begin < 2.0 * 0.5 * SMALLEST
    failure = caught.value.report
    assert isinstance(failure, Failure)
    assert failure.progress == 0.5
    np.testing.assert_allclose(failure.position, [4e-3, 0.0, 0.0], atol=1e-12)


def test_the_message_names_progress_residual_and_place() -> None:
    report = replace(REPORT, converged=False, iterations=60, residual=0.0123, node=7)
    message = str(ConvergenceError(Failure(progress=0.25, report=report, position=(1e-3, -2.5e-3, 0.0))))
    assert "\n" not in message
    for part in ("0.25 of the stroke", "1.2e-02", "node 7", "x 1.00, y -2.50, z 0.00 mm", "60 iterations"):
        assert part in message


def test_what_was_found_before_a_failure_is_kept() -> None:
    model, state = strand()
    # Nothing can follow pins that are nowhere.
    steps = march(Workspace(model), state, lambda s: stretched(state, 0.01 if s <= 0.5 else np.nan), longest=0.5)
    s, kept, _ = next(steps)
    assert s == 0.5
    assert kept.reaction.any()
    with pytest.raises(ConvergenceError, match=r"no equilibrium beyond 0.5 of the stroke"):
        next(steps)


def test_a_stretched_strand_pulls_back_with_EA_strain() -> None:  # noqa: N802
    model, state = strand()
    found, report = advance(Workspace(model), state, stretched(state, 0.01))
    assert found is not None
    assert report.converged
    np.testing.assert_allclose(found.reaction[9:, 0].sum(), 0.01 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(found.reaction[:2, 0].sum(), -0.01 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(found.external_work, 0.5 * np.pi * 0.01**2 * 20.0, rtol=1e-9)
    np.testing.assert_allclose(found.energies, [found.external_work, 0.0, 0.0, 0.0], rtol=1e-9, atol=1e-15)


def test_a_failed_search_is_no_state() -> None:
    model, state = crossing(gap=0.02)
    target = state.q.copy()
    target[17:, 2] -= 1.0
    found, report = advance(Workspace(model), state, target, Options(max_iterations=0))
    assert found is None
    assert not report.converged
    assert report.residual > Options().tolerance


def test_where_nothing_moves_nothing_changes() -> None:
    model, state = crossing(gap=0.5)
    found, report = advance(Workspace(model), state, state.q)
    assert found is not None
    assert report.iterations == 0
    np.testing.assert_array_equal(found.q, state.q)
    assert not found.reaction.any()
    assert found.external_work == 0.0

"""Surrogate and search on targets with known answers; no knit is tested."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.stats import qmc

from app.studies.search import best_of, search, surrogate_of
from app.studies.surrogate import Goal, Surrogate, candidates, ranked, widening_of
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray


def stiffness(z: FloatArray) -> FloatArray:
    """Return a smooth positive stiffness over three decades, like that of a fibre: r² of a length and a modulus."""
    radius, length = 0.5 + z[..., 0], 1.0 + z[..., 1]
    return np.exp(3.0 * np.log(radius) - 4.0 * np.log(length) + 1.5 * z[..., 2])[..., None]


def filled(count: int, dimension: int = 3) -> list[FloatArray]:
    return list(qmc.Halton(dimension, rng=np.random.default_rng(1)).random(count))


def of_one(wanted: float) -> Goal:
    return Goal(features=np.array([wanted]), scale=wanted)


def test_a_surrogate_goes_through_its_tests_and_knows_what_it_does_not_know() -> None:
    z = np.stack(filled(16))
    surrogate = Surrogate(z, stiffness(z))
    at = surrogate.predict(z)
    assert at.mean == pytest.approx(stiffness(z), rel=0.02)
    new = np.random.default_rng(5).random((200, 3))
    there = surrogate.predict(new)
    inside = (there.low <= stiffness(new)) & (stiffness(new) <= there.high)
    assert inside.mean() > 0.8
    assert (there.high / there.low).mean() > (at.high / at.low).mean()
    assert np.median(np.abs(there.mean / stiffness(new) - 1.0)) < 0.05


def test_an_interval_is_widened_where_tests_left_out_ask_for_it() -> None:
    z = np.stack(filled(9, 2))
    # A kink between two plateaus, as where loops lock: of nine tests a smooth process is too sure.
    rough = np.exp(np.where(z[:, :1] + 0.3 * z[:, 1:] > 0.6, 4.0, 0.0) + 0.5 * z[:, :1])
    widening = widening_of(z, rough)
    assert widening[0] > 1.3
    at = np.array([[0.5, 0.5]])
    plain, wide = Surrogate(z, rough).predict(at), Surrogate(z, rough, widening).predict(at)
    assert wide.mean == pytest.approx(plain.mean)
    assert np.log(wide.high / wide.low) == pytest.approx(widening * np.log(plain.high / plain.low))
    assert widening_of(z[:4], rough[:4]).tolist() == [1.0]


def test_values_of_both_signs_are_not_taken_in_logarithms() -> None:
    z = np.stack(filled(16))
    surrogate = Surrogate(z, z[:, :1] - 0.5)
    assert not surrogate.logarithmic
    assert surrogate.predict(np.array([[0.5, 0.5, 0.5]])).mean == pytest.approx(0.0, abs=0.02)


def test_proposals_lead_to_what_is_wanted() -> None:
    z = np.stack(filled(12))
    surrogate, goal = Surrogate(z, stiffness(z)), of_one(0.4)
    tested = goal.distance(stiffness(z))
    choice = candidates(z, [z[int(np.argmin(tested))]], seed=1)
    by_improvement, by_distance = ranked(surrogate, goal, choice, float(tested.min()))
    assert sorted(by_improvement) == sorted(by_distance) == list(range(len(choice)))
    best = goal.distance(stiffness(choice[by_distance[0]]))
    assert best < 0.3 * tested.min()
    assert best < np.median(goal.distance(stiffness(choice)))
    # Nothing is tested twice, and all is within the bounds.
    assert np.abs(choice[:, None] - z[None]).max(axis=2).min() > 0.01
    assert choice.min() >= 0.0
    assert choice.max() <= 1.0


@pytest.mark.parametrize("wanted", [0.4, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_search_comes_within_its_tolerance_in_few_tests(wanted: float) -> None:
    tests: list[FloatArray] = []

    def evaluate(places: Sequence[FloatArray]) -> list[FloatArray | None]:
        tests.extend(places)
        return [stiffness(z) for z in places]

    trials = search(evaluate, of_one(wanted), filled(10), within=0.02, rounds=8)
    assert len(tests) == len(trials) <= 26
    assert best_of(trials).distance <= 0.02
    # It ends once it is there; before each proposal the surrogate said what it expected.
    assert all(one.distance > 0.02 for one in trials if one.round < trials[-1].round)
    assert all((one.predicted is None) == (one.round == 0) for one in trials)
    again = search(evaluate, of_one(wanted), filled(10), within=0.02, rounds=8)
    assert [one.z.tolist() for one in again] == [one.z.tolist() for one in trials]


def test_a_curve_is_wanted_point_by_point() -> None:
    at = np.linspace(0.25, 1.0, 4)

    def curve(z: FloatArray) -> FloatArray:
        found: FloatArray = (1.0 + 9.0 * z[0]) * np.expm1((1.0 + 3.0 * z[1]) * at)
        return found

    wanted = curve(np.array([0.3, 0.6]))
    goal = Goal(features=wanted, scale=float(np.ptp(wanted)))
    trials = search(lambda places: [curve(z) for z in places], goal, filled(8, 2), within=0.01, rounds=8)
    best = best_of(trials)
    assert best.distance <= 0.01
    assert best.z == pytest.approx([0.3, 0.6], abs=0.1)


def test_what_fails_or_is_not_allowed_is_gone_around() -> None:
    asked: list[FloatArray] = []

    def evaluate(places: Sequence[FloatArray]) -> list[FloatArray | None]:
        asked.extend(places)
        return [None if z[1] > 0.8 else stiffness(z) for z in places]

    trials = search(evaluate, of_one(0.4), filled(12), within=0.05, rounds=8, allowed=lambda z: bool(z[0] < 0.6))
    assert best_of(trials).distance <= 0.05
    assert all(one.z[0] < 0.6 for one in trials if one.round)
    assert any(one.features is None for one in trials)
    surrogate = surrogate_of(trials, lambda z: z, but=best_of(trials).z)
    expected = surrogate.predict(best_of(trials).z[None])
    assert expected.mean[0] == pytest.approx(best_of(trials).features, rel=0.05)


def test_too_few_tests_are_refused_in_one_line() -> None:
    with pytest.raises(SpecificationError, match="design: found '2 tests that can be used', allowed 4 or more"):
        search(lambda places: [stiffness(z) for z in places], of_one(0.4), filled(2), within=1e-9, rounds=2)
    with pytest.raises(SpecificationError, match="design: found '0 tests"):
        search(lambda places: [None for _ in places], of_one(0.4), filled(9), within=1e-9, rounds=2)

"""Rods that relax against the Prony series, its hereditary integrals, and the standard linear solid."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods.relaxation import hold_steps
from tests.validation.knit import Knit, make_knit
from tests.validation.viscous_rod import PRONY, SOLID, mean_modulus, modulus, relaxing_rod, step

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import State

EA = np.pi
TIMES = np.array([0.05, 0.4, 2.0, 9.0, 80.0, 500.0])
SOURCE = "Boltzmann's superposition"


def stretched(state: State, strain: float) -> NDArray[np.float64]:
    q = state.q.copy()
    q[:, 0] *= 1.0 + strain
    return q


def curled(state: State, turn: float, twist: float) -> NDArray[np.float64]:
    """Return a rod of unstretched edges that turn and twist at every node by `turn` and `twist`."""
    q = np.zeros_like(state.q)
    count = len(q) - 1
    angle = turn * np.arange(count)
    q[1:, 0], q[1:, 1] = 2.0 * np.cumsum(np.cos(angle)), 2.0 * np.cumsum(np.sin(angle))
    q[:-1, 3] = twist * np.arange(count)
    return q


def test_a_stretched_rod_relaxes_by_the_series(bar: Callable[..., None]) -> None:
    work, rest = relaxing_rod(PRONY)
    work.model.fixed[-1] = True
    target = stretched(rest, 0.05)
    state = step(work, rest, target, 0.0)
    errors = [state.reaction[-1, 0] / (0.05 * EA) - 1.0]
    for begin, end in pairwise([0.0, *TIMES]):
        state = step(work, state, target, end - begin)
        errors.append(state.reaction[-1, 0] / (0.05 * EA * modulus(PRONY, end)) - 1.0)
    bar("stretched rod held: force against E(t)", np.abs(errors).max(), 1e-6, "1", SOURCE)


def test_a_bent_rod_relaxes_by_the_series(bar: Callable[..., None]) -> None:
    work, rest = relaxing_rod(PRONY)
    work.model.fixed[-1, :3] = True
    target = rest.q.copy()
    target[-1, :3] += [-5.0, 6.0, 0.0]
    state = step(work, rest, target, 0.0)
    begun = state.reaction[-1, :2]
    errors, shapes = [], []
    for begin, end in pairwise([0.0, *TIMES]):
        later = step(work, state, target, end - begin)
        shapes.append(np.abs(later.q - state.q).max())
        state = later
        errors.append(np.abs(state.reaction[-1, :2] / begun / modulus(PRONY, end) - 1.0).max())
    bar("bent rod held: force against E(t)", np.max(errors), 1e-6, "1", SOURCE)
    bar("bent rod held: motion while it relaxes", np.max(shapes), 1e-6, "r", "one relaxation for all strains")


@pytest.mark.parametrize("steps", [1, 7])
def test_ramp_then_hold_is_the_hereditary_integral(bar: Callable[..., None], steps: int) -> None:
    work, rest = relaxing_rod(PRONY)
    work.model.fixed[-1] = True
    state, ramp, errors = rest, 3.0, []
    for share in np.arange(1, steps + 1) / steps:
        state = step(work, state, stretched(rest, 0.05 * share), ramp / steps)
        t = ramp * share
        errors.append(state.reaction[-1, 0] / (0.05 * share * EA * mean_modulus(PRONY, t, t)) - 1.0)
    for begin, end in pairwise([0.0, *TIMES]):
        state = step(work, state, state.q, end - begin)
        errors.append(state.reaction[-1, 0] / (0.05 * EA * mean_modulus(PRONY, ramp + end, ramp)) - 1.0)
    bar(f"ramp of {steps} steps, then hold: force", np.abs(errors).max(), 1e-6, "1", SOURCE)


@pytest.mark.parametrize(("turn", "twist"), [(1e-6, 0.0), (0.0, 0.3)], ids=["bent", "twisted"])
@pytest.mark.parametrize("steps", [1, 5])
def test_bending_and_twisting_at_an_even_pace(bar: Callable[..., None], steps: int, turn: float, twist: float) -> None:
    # A span between unstretched edges shortens by φ²/12 as it bends: strains grow at an even pace where that is small.
    work, rest = relaxing_rod(PRONY, straight=True)
    elastic, _ = relaxing_rod(None, straight=True)
    for one in (work, elastic):
        one.model.fixed[:] = True
    state, plain, errors = rest, rest, []
    for share in np.arange(1, steps + 1) / steps:
        target = curled(rest, turn * share, twist * share)
        state, plain = step(work, state, target, 3.0 / steps), step(elastic, plain, target, 0.0)
        t = 3.0 * share
        off = state.reaction - mean_modulus(PRONY, t, t) * plain.reaction
        errors.append(np.abs(off).max() / np.abs(plain.reaction).max())
    what = "bent" if turn else "twisted"
    bar(f"rod {what} at an even pace in {steps} steps: forces and moments", np.max(errors), 1e-6, "1", SOURCE)


def test_creep_under_a_dead_load(bar: Callable[..., None]) -> None:
    work, rest = relaxing_rod(SOLID)
    work.model.fixed[2:-1, 1:] = True
    load, (share,), (time,) = 0.02 * EA, SOLID.shares, SOLID.times
    work.dead.loads[-1, 0] = load
    # The first two nodes are clamped: seven edges stretch.
    state, t, errors = step(work, rest, rest.q, 0.0), 0.0, []
    for duration in hold_steps(SOLID, 20.0):
        state, t = step(work, state, rest.q, duration), t + duration
        theory = 0.02 * (1.0 + share / (1.0 - share) * -np.expm1(-(1.0 - share) * t / time))
        errors.append((state.q[-1, 0] - rest.q[-1, 0]) / 14.0 / theory - 1.0)
    assert t == pytest.approx(20.0)
    bar("creep under a dead load, steps of a hold", np.abs(errors).max(), 0.01, "1", "standard linear solid")


def test_loss_of_a_cycle(bar: Callable[..., None]) -> None:
    work, rest = relaxing_rod(PRONY)
    work.model.fixed[-1] = True
    peak, period, steps = 0.01, 4.0, 64
    state, before = rest, rest
    for number in range(1, 4 * steps + 1):
        if number == 3 * steps + 1:
            before = state
        strain = peak * np.sin(2.0 * np.pi * number / steps)
        state = step(work, state, stretched(rest, strain), period / steps)
    x = 2.0 * np.pi / period * PRONY.times
    theory = np.pi * peak**2 * EA * 16.0 * float(PRONY.shares @ (x / (1.0 + x**2)))
    lost = state.viscous_work - before.viscous_work
    bar("loss of a sinusoidal cycle", lost / theory - 1.0, 0.01, "1", "loss modulus of the series")
    put_in = state.external_work - before.external_work
    kept = float(state.energies.sum() - before.energies.sum())
    bar("relaxing rod, cycle: work in = stored + lost", (put_in - kept - lost) / put_in, 0.01, "1", "energy balance")


def test_energy_of_a_ramp_and_a_hold(bar: Callable[..., None]) -> None:
    work, rest = relaxing_rod(PRONY)
    work.model.fixed[-1, :3] = True
    target, state = rest.q.copy(), rest
    for _ in range(40):
        target = target.copy()
        target[-1, :3] += [-0.125, 0.15, 0.05]
        state = step(work, state, target, 0.05)
    for duration in hold_steps(PRONY, 100.0):
        state = step(work, state, target, duration)
    rest_of = state.external_work - float(state.energies.sum()) - state.viscous_work
    bar("bent rod, ramp and hold: energy balance", rest_of / state.external_work, 0.01, "1", "work in = stored + lost")
    assert state.viscous_work > 0.2 * state.external_work


def test_a_relaxing_knit_keeps_its_books(bar: Callable[..., None]) -> None:
    knit = make_knit(2)
    work, state = Workspace(replace(knit.model, relaxation=PRONY)), knit.start
    peak = state
    for begin, end in ((0.0, 0.25), (0.25, 0.1)):
        path = partial(_between, knit, begin, end)
        for _, found, _ in march(work, state, path, longest=0.00625 / abs(end - begin), duration=4.0):
            state = found
        peak = state if begin == 0.0 else peak
    for duration in hold_steps(PRONY, 100.0):
        *_, (_, state, _) = march(work, state, lambda _: knit.target(0.1), longest=1.0, duration=duration)
    spent = float(state.energies.sum()) + state.friction_work + state.viscous_work
    bar("relaxing knit: work in = stored + lost", spent / state.external_work - 1.0, 0.01, "1", "energy balance")
    *_, (_, elastic, _) = march(Workspace(knit.model), knit.start, partial(_between, knit, 0.0, 0.25), longest=0.05)
    assert state.viscous_work > 0.05 * state.external_work
    for relaxed, stiff in zip(knit.force(peak), knit.force(elastic), strict=True):
        assert 0.5 * stiff < relaxed < 0.95 * stiff


def _between(knit: Knit, begin: float, end: float, share: float) -> NDArray[np.float64]:
    return knit.target(begin + (end - begin) * share)


def test_time_is_nothing_to_elastic_rods() -> None:
    knit = make_knit(2)
    ends = []
    for duration in (0.0, 7.0):
        *_, (_, end, _) = march(
            Workspace(knit.model), knit.start, partial(_between, knit, 0.0, 0.15), longest=0.25, duration=duration
        )
        ends.append(end)
    first, second = ends
    np.testing.assert_array_equal(first.q, second.q)
    np.testing.assert_array_equal(first.reaction, second.reaction)
    assert first.external_work == second.external_work
    assert first.history is None
    assert first.viscous_work == 0.0

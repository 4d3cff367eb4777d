from functools import cache

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import clasp_numbers
from knitlab_core.rods.frames import Frames, follow
from tests.validation.knit import FloatArray, Knit, make_knit, pull

seeds = st.integers(0, 2**32 - 1)
strains = st.floats(0.0, 0.35)


@cache
def loaded(friction: float) -> tuple[Knit, State]:
    """Pull a knit to 30 % and let it back a little, so that contacts slide, stick and carry slip."""
    knit = make_knit(2, friction=friction, nodes_per_loop=24)
    _, state = pull(knit, [0.3, 0.28], steps=10)
    return knit, state


class Scene:
    """A loaded knit, moved at random by some thousandths of a radius since its last equilibrium."""

    def __init__(self, friction: float, seed: int) -> None:
        knit, state = loaded(friction)
        self.rng = np.random.default_rng(seed)
        self.work = Workspace(knit.model)
        self.work.start_step(state.q, state.frames, state.memory)
        self.has_edge = knit.model.rods.has_edge
        self.q = state.q + self.direction(state.q) * 3e-3
        self.frames = self.follow(self.q, state.frames)
        self.work.move_to(self.q, self.frames)
        self.work.lag()

    def direction(self, q: FloatArray) -> FloatArray:
        d: FloatArray = self.rng.normal(size=q.shape)
        return d

    def follow(self, q: FloatArray, source: Frames) -> Frames:
        frames = source.copy()
        follow(q, self.has_edge, source, frames)
        return frames

    def energy(self, q: FloatArray) -> float:
        return self.work.energy(q, self.frames)

    def gradient(self, q: FloatArray) -> FloatArray:
        frames = self.follow(q, self.frames)
        self.work.move_to(q, frames)
        return self.work.gradient()


STEPS = 10.0 ** -np.arange(2.0, 8.0)


@settings(max_examples=10, deadline=None)
@given(friction=st.sampled_from([0.0, 0.3]), seed=seeds)
def test_forces_are_the_slope_of_the_energy(friction: float, seed: int) -> None:
    scene = Scene(friction, seed)
    d = scene.direction(scene.q)
    slope = float(np.vdot(scene.gradient(scene.q), d))
    scale = np.abs(scene.gradient(scene.q) * d).sum()
    errors = [
        abs((scene.energy(scene.q + h * d) - scene.energy(scene.q - h * d)) / (2.0 * h) - slope) / scale for h in STEPS
    ]
    assert min(errors) < 1e-7
    # A pair that begins to slide within a step bends the energy there.
    assert friction > 0.0 or errors[2] < 1e-5


@settings(max_examples=10, deadline=None)
@given(friction=st.sampled_from([0.0, 0.3]), seed=seeds)
def test_stiffness_is_the_slope_of_the_forces_and_symmetric(friction: float, seed: int) -> None:
    scene = Scene(friction, seed)
    u, v = scene.direction(scene.q), scene.direction(scene.q)
    scene.work.move_to(scene.q, scene.frames)
    scene.work.assemble()
    ku, kv = scene.work.stiffness.times(u), scene.work.stiffness.times(v)
    assert abs(np.vdot(v, ku) - np.vdot(u, kv)) < 1e-12 * np.abs(v * ku).sum()
    errors = []
    for h in STEPS:
        ju, jv = ((scene.gradient(scene.q + h * d) - scene.gradient(scene.q - h * d)) / (2.0 * h) for d in (u, v))
        # Frames carried round a loop come back turned, so only the symmetric part is a second derivative.
        errors.append(abs(0.5 * (np.vdot(v, ju) + np.vdot(u, jv)) - np.vdot(v, ku)) / np.abs(v * ku).sum())
    # Pairs that pass from stick to slip within a step spoil it; they get fewer as it shrinks.
    assert min(errors) < 1e-7
    assert friction > 0.0 or errors[2] < 1e-4


@settings(max_examples=10, deadline=None)
@given(seed=seeds, shift=st.floats(-100.0, 100.0))
def test_energy_does_not_change_when_all_is_moved_and_turned(seed: int, shift: float) -> None:
    scene = Scene(0.0, seed)
    turn = Rotation.from_rotvec(scene.rng.uniform(-0.5, 0.5, 3))
    q = scene.q.copy()
    q[:, :3] = turn.apply(q[:, :3]) + shift
    frames = scene.frames.copy()
    frames.tangent[:] = turn.apply(frames.tangent)
    frames.director[:] = turn.apply(frames.director)
    before, after = scene.energy(scene.q), scene.work.energy(q, frames)
    assert abs(after / before - 1.0) < 1e-9


@settings(max_examples=5, deadline=None)
@given(path=st.lists(strains, min_size=1, max_size=3), end=strains)
def test_without_friction_forces_do_not_depend_on_the_way(path: list[float], end: float) -> None:
    knit = make_knit(2, friction=0.0, nodes_per_loop=24)
    there = [pull(knit, [*way, end], steps=8, options=Options(tolerance=1e-8))[0][-1] for way in ([], path)]
    np.testing.assert_allclose(there[1].force, there[0].force, rtol=1e-6, atol=1e-7)


@settings(max_examples=5, deadline=None)
@given(path=st.lists(strains, min_size=1, max_size=4), friction=st.floats(0.0, 0.6))
def test_friction_only_takes_and_loops_stay_knitted(path: list[float], friction: float) -> None:
    knit = make_knit(2, friction=friction, nodes_per_loop=24)
    rows, state = pull(knit, path, steps=8)
    most = max(row.external_work for row in rows)
    assert min(row.friction_work for row in rows) >= -0.01 * most
    numbers = clasp_numbers(knit.specimen, state.q[:, :3])
    np.testing.assert_array_equal(numbers, clasp_numbers(knit.specimen, knit.start.q[:, :3]))


@settings(max_examples=5, deadline=None)
@given(longest=st.floats(0.03, 1.0))
def test_every_march_lands_and_every_row_is_balanced(longest: float) -> None:
    knit = make_knit(2, nodes_per_loop=24)
    options = Options(tolerance=1e-5)
    steps = list(
        march(Workspace(knit.model), knit.start, lambda s: knit.target(0.2 * s), longest=longest, options=options)
    )
    assert steps[-1][0] == 1.0
    for s, state, report in steps:
        assert report.residual < options.tolerance
        held = knit.model.fixed
        np.testing.assert_allclose(state.q[held], knit.target(0.2 * s)[held], rtol=0.0, atol=1e-12)
        assert not state.reaction[~held].any()

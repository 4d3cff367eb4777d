"""A new workspace goes on where another stood, to the last bit."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest

from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.rupture import break_fibre, sever, weakest
from knitlab_core.equilibrium.step_control import Pace
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, knit_specimen
from knitlab_core.rods.relaxation import Relaxation
from tests.validation.knit import POISSON_RATIO, YOUNG_MODULUS, make_knit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import Model, State
    from knitlab_core.equilibrium.newton import Options
    from knitlab_core.equilibrium.solver_state import SolverState

NODES = 16


class Scene(NamedTuple):
    """What is marched: model, state to begin from, path, and its longest step."""

    model: Model
    begin: State
    path: Callable[[float], NDArray[np.float64]]
    longest: float
    duration: float = 0.0
    options: Options | None = None


def planar() -> Scene:
    knit = make_knit(2, nodes_per_loop=NODES)
    return Scene(knit.model, knit.start, lambda s: knit.target(0.35 * s), 0.08)


def relaxing() -> Scene:
    scene = planar()
    prony = Relaxation(np.array([0.3, 0.2]), np.array([0.5, 20.0]))
    return scene._replace(model=replace(scene.model, relaxation=prony), duration=30.0)


def fused() -> Scene:
    radius = make_knit(2).model.scales.radius
    law = BondLaw(fuse_gap=3.5 * radius, patch_radius=0.3 * radius, strength=20e6)
    knit = make_knit(2, nodes_per_loop=NODES, bonds=law)
    return Scene(knit.model, knit.start, lambda s: knit.target(0.12 * s), 0.1)


def broken() -> Scene:
    knit = make_knit(2, nodes_per_loop=NODES)
    work = Workspace(knit.model)
    *_, (_, state, _) = march(work, knit.start, lambda s: knit.target(0.3 * s), longest=0.1)
    edge = weakest(knit.model, state).edge
    _, begin = break_fibre(work, state, edge)
    return Scene(sever(knit.model, edge), begin, lambda s: knit.target(0.3 + 0.1 * s), 0.125)


def volumetric() -> Scene:
    stitch = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
    knit = knit_specimen(stitch, rows=2, loops=2, layers=2, loop_width=8e-3, nodes_per_loop=NODES)
    model, state = make_model(
        knit.strands, radius=knit.radius, young_modulus=YOUNG_MODULUS, poisson_ratio=POISSON_RATIO, friction=0.3
    )
    low, high = knit.sites["pile-"], knit.sites["pile+"]
    model.fixed[np.concatenate([low, high]), :3] = True
    height = float(np.ptp(state.q[:, 2]))

    def path(s: float) -> NDArray[np.float64]:
        q = state.q.copy()
        q[high, 2] += 0.15 * height * s
        return q

    return Scene(model, state, path, 0.1)


def kinked() -> Scene:
    """Return a knit that locks on the way: its march goes steps again and lets them grow after that."""
    knit = make_knit(2, nodes_per_loop=NODES)
    return Scene(knit.model, knit.start, lambda s: knit.target(0.25 * s), 0.1)


def unrolled(value: object) -> Iterator[object]:
    """Yield every number and array in a state."""
    if is_dataclass(value):
        for field in fields(value):
            yield from unrolled(getattr(value, field.name))
    elif isinstance(value, tuple):
        for part in value:
            yield from unrolled(part)
    else:
        yield value


def carried_of(work: Workspace) -> SolverState:
    solver_state = work.solver_state
    assert solver_state is not None
    return solver_state


def assert_same(state: object, other: object) -> None:
    for one, two in zip(unrolled(state), unrolled(other), strict=True):
        if isinstance(one, np.ndarray):
            assert isinstance(two, np.ndarray)
            assert one.dtype == two.dtype
        assert np.array_equal(one, two)  # type: ignore[arg-type]


@pytest.mark.parametrize("make", [planar, relaxing, fused, broken, volumetric, kinked])
def test_a_new_workspace_goes_on_to_the_same_bits(make: Callable[[], Scene]) -> None:
    scene = make()
    work, pace = Workspace(scene.model), Pace()

    def go(work: Workspace, state: State, pace: Pace) -> Iterator[tuple[float, State, object]]:
        return march(
            work,
            state,
            scene.path,
            longest=scene.longest,
            options=scene.options,
            duration=scene.duration,
            pace=pace,
        )

    stood = []
    for at, state, report in go(work, scene.begin, pace):
        stood.append((at, state, report, replace(pace), carried_of(work)))
    assert len(stood) > 5
    if make is kinked:
        steps = {pace.step for *_, pace, _ in stood}
        assert len(steps) > 1
    for k in (0, len(stood) // 3, len(stood) - 3):
        _, state, _, pace, solver_state = stood[k]
        fresh = Workspace(scene.model)
        fresh.restore(solver_state)
        for (at, found, report), then in zip(islice(go(fresh, state, pace), 2), stood[k + 1 :], strict=False):
            assert (at, report) == (then[0], then[2])
            assert_same(found, then[1])
            assert_same(carried_of(fresh), then[4])


def test_nothing_is_carried_before_the_first_step() -> None:
    assert Workspace(planar().model).solver_state is None


def test_the_pattern_is_carried_as_it_was_made_on_the_way() -> None:
    scene = planar()
    work = Workspace(scene.model)
    list(march(work, scene.begin, scene.path, longest=scene.longest))
    assert not np.array_equal(carried_of(work).q, scene.begin.q)

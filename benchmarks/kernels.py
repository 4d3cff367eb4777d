"""Parts of one iteration, timed by themselves: the main job at 33 % strain, `python -m benchmarks.kernels`."""

from __future__ import annotations

import sys
from time import perf_counter
from typing import TYPE_CHECKING
from unittest.mock import patch

import numpy as np

from app.checks.dry_run import build_specimen
from app.schemas import load
from app.schemas.machine_data import machines_of
from benchmarks.main_job import PROTOCOL
from knitlab_core.equilibrium import march
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.coupling import load_coupling
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Equilibrium

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.workspace import Workspace


def loaded_knit() -> tuple[Workspace, State]:
    """Return the main job's workspace, begun at the equilibrium at 33 % strain on the way up, and that."""
    loaded = load(PROTOCOL)
    stage, state = mount(build_specimen(loaded), loaded.protocol, machines_of(loaded.protocol))
    states = [state]

    def kept(work: Workspace, begun: State, *args: object, **options: float) -> object:
        states.append(begun)
        return advance(work, begun, *args, **options)  # type: ignore[arg-type]

    with patch.object(march, "advance", kept):
        for event in perform(stage, state, loaded.protocol):
            if isinstance(event, Equilibrium) and event.displacement["C"] >= 0.33 * stage.gauges["C"]:
                break
    return stage.work, states[-1]


def parts(work: Workspace, state: State) -> dict[str, Callable[[], object]]:
    """Return the parts of an iteration, to be called in this order."""
    model = work.model
    rng = np.random.default_rng(1)
    q = state.q + 0.01 * ~model.fixed * rng.standard_normal(state.q.shape)
    frames = state.frames
    step = 0.01 * ~model.fixed * rng.standard_normal(q.shape)
    work.start_step(state.q, frames, state.memory, state.bonds.hold, state.poles)

    def factor() -> None:
        work.assemble()
        began = perf_counter()
        work.stiffness.factor()
        seconds.append(perf_counter() - began)

    seconds: list[float] = []
    return {
        "begin a step": lambda: work.start_step(state.q, frames, state.memory, state.bonds.hold, state.poles),
        "energy": lambda: work.energy(q, frames),
        "place": lambda: work.move_to(state.q, frames),
        "take loads": work.lag,
        "gradient": work.gradient,
        "assemble": work.assemble,
        "assemble and factor": factor,
        "solve": lambda: work.stiffness.solve(step),
        "load coupling": lambda: load_coupling(work, step),
        "room": lambda: work.contacts.collision_free_fraction(state.q, step, 0.8),
    }


def main(repeats: int) -> None:
    """Print the shortest of so many calls of each part."""
    work, state = loaded_knit()
    for name, part in parts(work, state).items():
        times = []
        for _ in range(repeats + 1):
            began = perf_counter()
            part()
            times.append(perf_counter() - began)
        print(f"{name:20s} {1e3 * min(times[1:]):7.3f} ms")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)

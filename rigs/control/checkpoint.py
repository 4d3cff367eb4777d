"""Checkpoint of a test: all that it needs to resume from a row, and the rig in its state there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from knitlab_core.equilibrium.rupture import sever
from knitlab_core.equilibrium.workspace import Workspace
from rigs.machines.mounting import as_mounted

if TYPE_CHECKING:
    from knitlab_core.equilibrium.model import State
    from knitlab_core.equilibrium.solver_state import SolverState
    from rigs.axes import FloatArray
    from rigs.control.resume_point import ResumePoint
    from rigs.machines.rig import Rig


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Checkpoint:
    """All that a test needs to resume from a row; nothing in it changes later.

    Attributes
    ----------
    cursor : ResumePoint
        Its position in the protocol.
    state : State
        The specimen's state.
    solver_state : SolverState
        What the solver carries from step to step.
    mounted : FloatArray, shape (N, 4)
        The unknowns when the specimen was mounted [r], [rad]; see `Rig`.
    severed : tuple of int
        The edges that broke, in order.
    """

    cursor: ResumePoint
    state: State
    solver_state: SolverState
    mounted: FloatArray
    severed: tuple[int, ...]


def checkpoint_of(rig: Rig, state: State, cursor: ResumePoint) -> Checkpoint | None:
    """Return the checkpoint of a test; None before its first equilibrium."""
    solver_state = rig.work.solver_state
    if solver_state is None:
        return None
    return Checkpoint(cursor=cursor, state=state, solver_state=solver_state, mounted=rig.mounted, severed=rig.severed)


def restore(rig: Rig, checkpoint: Checkpoint) -> Rig:
    """Return a newly mounted rig in its state at a checkpoint: what broke is broken."""
    model = rig.work.model
    for edge in checkpoint.severed:
        model = sever(model, edge)
    work = Workspace(model)
    work.restore(checkpoint.solver_state)
    mounted = checkpoint.mounted
    size = as_mounted(rig.size, rig.specimen, model.scales.length * mounted)
    return replace(rig, work=work, size=size, mounted=mounted, severed=checkpoint.severed)

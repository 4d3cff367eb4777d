"""Checks of a step before a live rig does it: what fails here has moved nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.checks.dry_run import passed_limits
from knitlab_core.errors import SpecificationError
from rigs.control.log_rate import density, require_rates
from rigs.control.plan import MAX_ROWS, planned_step
from rigs.protocol.protocol import MAX_STROKES
from rigs.protocol.step import step_name
from rigs.protocol.unrolled import UnrolledStep

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.live.recording import Recording
    from rigs.machines.machine import MachineData
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.step import Step


def checked(test: Recording, machines: Mapping[MachineName, MachineData], step: Step) -> UnrolledStep:
    """Return a step with its place in the protocol, if a test can go on with it.

    Raises
    ------
    SpecificationError
        If the test has ended or gets too long, or the step does not fit the rig or passes a limit of its machines.
    """
    name = step_name(step)
    require_going_on(test, name)
    alone = test.protocol_of(step)
    require_rates(alone, machines)
    leaf = UnrolledStep(number=len(test.steps), place=f"steps[{len(test.steps)}].{name}", step=step)
    planned, *_ = planned_step(test.planner, leaf, test.session.memory.history, test.session.readings())
    passed = passed_limits(alone, machines, planned.strokes)
    if passed:
        raise SpecificationError(name, "; ".join(passed), "what the machines of the rig can do")
    strokes = sum(one.stroke_count for one in test.steps) + step.stroke_count
    if strokes > MAX_STROKES:
        raise SpecificationError(name, f"stroke {strokes} of the test", f"{MAX_STROKES} or fewer")
    rows = (test.session.time + planned.duration) * density(alone.log, leaf).rate
    if rows > MAX_ROWS:
        raise SpecificationError(name, f"a log of {rows:.3g} rows", f"{MAX_ROWS} or fewer")
    return leaf


def require_going_on(test: Recording, what: str) -> None:
    """Raise if a test has ended.

    Raises
    ------
    SpecificationError
        With the reason.
    """
    ended = test.outcome
    if ended is not None:
        found = f"a test that has ended: {ended.end}{': ' if ended.message else ''}{ended.message}"
        raise SpecificationError(what, found, "a test that goes on: go_back to a checkpoint, or another rig")

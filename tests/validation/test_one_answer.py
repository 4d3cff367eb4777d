"""One answer: the loops of a cyclic test depend neither on which cycle it is nor on the length of the steps.

A planar 2x2 knit is driven along course and wale to 25 % and back, as in the paper's Fig. 3a. Strands touch, lock and
turn back on the way, and where they do so, friction's path has kinks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas.machine_data import machines_of
from knitlab_core.equilibrium.newton import Options
from rigs.analysis.branches import branch
from rigs.analysis.work import loop_area
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle, LogSpec, Protocol, SpecimenSpec, Zero
from rigs.record import Equilibrium
from rigs.trace import Trace, trace_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigs.axes import Axis, FloatArray

BOTH: tuple[Axis, ...] = ("C", "W")
CYCLES = 4
DEFAULT = 0.0125
FINE = 0.0015625
STEPS = (2.0 * DEFAULT, DEFAULT, 0.5 * DEFAULT)
SOURCE = "limit of small steps"


@dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """Areas of all loops [J] and largest forces [N] of an axis, cycle by cycle, each (n,)."""

    area: FloatArray
    peak: FloatArray


@cache
def cycled(step: float, cycles: int, options: Options | None = None) -> dict[Axis, Loops]:
    """Carry out some cycles in steps of at most so much strain."""
    protocol = Protocol(
        specimen=SpecimenSpec(
            knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM", friction=0.3
        ),
        speed_ref="pair",
        others="hold",
        steps=(Zero(), Cycle(axes=BOTH, lower=0.0, upper=0.25, rate=2e-4, n=cycles)),
        log=LogSpec(noise=False),
        max_strain_increment=step,
    )
    rig, state = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol))
    trace = trace_of(
        [event for event in perform(rig, state, protocol, options=options) if isinstance(event, Equilibrium)]
    )
    return {axis: _loops(trace, axis, cycles) for axis in BOTH}


def _loops(trace: Trace, axis: Axis, cycles: int) -> Loops:
    number, travel, force = (trace.columns[name] for name in ("cycle", f"displacement_{axis}", f"force_{axis}"))
    found = [branch(trace.phase, number.astype(np.int64), k, ["Stretch", "Recover"]) for k in range(1, cycles + 1)]
    return Loops(
        area=np.array([loop_area(travel[rows], force[rows]) for rows in found]),
        peak=np.array([force[rows].max() for rows in found]),
    )


def limit(axis: Axis) -> Loops:
    """Return the second loop in steps an eighth of the default: the first sets out from strands that never rubbed.

    Half the step again makes the loop of the course 0.5 % larger and that of the wale 0.1 %: so well is the limit
    known. With the default tolerance the loop of the course is 0.5 % larger at this step and 1.8 % at half of it; what
    is out of balance adds up over many steps.
    """
    fine = cycled(FINE, 2, Options(tolerance=1e-6))[axis]
    return Loops(area=fine.area[1:], peak=fine.peak[1:])


def worst(found: FloatArray, wanted: FloatArray) -> float:
    """Return the largest difference relative to what is wanted."""
    return float(np.abs(found / wanted - 1.0).max())


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("axis", BOTH)
def test_all_loops_are_alike(bar: Callable[..., None], axis: Axis, step: float) -> None:
    area = cycled(step, CYCLES)[axis].area
    assert area.min() > 0.0
    bar(
        f"loops of {CYCLES} cycles, {axis}, steps of {step:.3%}, spread", np.ptp(area) / area.min(), 0.01, "1", "cycles"
    )


@pytest.mark.parametrize("axis", BOTH)
def test_the_default_step_is_near_the_limit(bar: Callable[..., None], axis: Axis) -> None:
    found, wanted = cycled(DEFAULT, CYCLES)[axis], limit(axis)
    bar(f"loops in default steps, {axis}, worst of {CYCLES} cycles", worst(found.area, wanted.area), 0.02, "1", SOURCE)
    bar(f"peaks in default steps, {axis}, worst of {CYCLES} cycles", worst(found.peak, wanted.peak), 3e-3, "1", SOURCE)


@pytest.mark.parametrize("axis", BOTH)
def test_errors_fall_with_the_step(bar: Callable[..., None], axis: Axis) -> None:
    long, default, short = (worst(cycled(step, CYCLES)[axis].area, limit(axis).area) for step in STEPS)
    name = f"loops, {axis}, error in steps of {{:.3%}} over that of {{:.3%}}"
    bar(name.format(*STEPS[1::-1]), default / long, 0.4, "1", "first order: 0.5, second: 0.25")
    # Below the default step errors are about as large as the limit is uncertain, so they tell of no order.
    bar(name.format(*STEPS[:0:-1]), short / default, 1.0, "1", "falls")

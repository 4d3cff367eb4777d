"""Curves of a run as measurements: of the whole test, and of each of its steps `cycle`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigs.analysis.stress_strain import stress_strain
from rigs.instruments.zeros import Zeroing, size_in_time, zeroed
from rigs.jumps import parted
from rigs.measurement import Measurement
from rigs.protocol.unrolled import unrolled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.records.reader import RunReader
    from rigs.protocol.protocol import Protocol
    from rigs.record import SpecimenSize
    from rigs.trace import Trace


def whole_test(trace: Trace, size: SpecimenSize, zeroings: Sequence[Zeroing], name: str = "") -> list[Measurement]:
    """Return the equilibria of a test along each driven axis, zeroed as the test asked for; jumps are parted."""
    trace = parted(trace)
    time = trace.columns["time"]
    in_time = size_in_time(time, size, zeroings)
    found = []
    for axis in trace.axes:
        travel = zeroed(trace.columns[f"displacement_{axis}"], time, "displacement", zeroings)
        force = zeroed(trace.columns[f"force_{axis}"], time, "force", zeroings)
        strain, stress = stress_strain(travel, force, axis, in_time)
        found.append(
            Measurement(
                name=name,
                axis=axis,
                time=time,
                travel=travel,
                force=force,
                strain=strain,
                stress=stress,
                transverse=np.full(len(time), np.nan),
                cycle=trace.columns["cycle"].astype(np.int64),
                phase=trace.phase,
                sampled=False,
            )
        )
    return found


def cycled(
    trace: Trace, size: SpecimenSize, zeroings: Sequence[Zeroing], protocol: Protocol | None
) -> list[Measurement]:
    """Return the parts of a test whose cycles count: its steps `cycle`, each on the axes that it drives.

    Each is named by its step where there are several, and its cycles count from 1. Without such a step it is the whole
    test on every axis.
    """
    whole = {one.axis: one for one in whole_test(trace, size, zeroings)}
    steps = parted(trace).columns["step"]
    cycling = [leaf for leaf in unrolled(protocol.steps if protocol else ()) if leaf.step.cyclic]
    found = []
    for leaf in cycling:
        rows = np.flatnonzero(steps == leaf.number)
        if not len(rows):
            continue
        rows = np.concatenate([rows[:1] - 1, rows]) if rows[0] > 0 else rows
        name = "" if len(cycling) == 1 else leaf.step.tag or leaf.place
        found += [_counted(whole[axis].chosen(rows), name) for axis in leaf.step.axes]
    return found if cycling else list(whole.values())


def _counted(part: Measurement, name: str) -> Measurement:
    """Return a step with its name and its cycles counted from 1; its first row is the last one of the step before."""
    cycle = part.cycle - part.cycle[1:].min() + 1
    return replace(part, name=name, cycle=cycle, phase=("Zero", *part.phase[1:]))


def zeroings_of(run: RunReader) -> list[Zeroing]:
    """Return when channels were zeroed in a run, and the gauge lengths from then on."""
    if run.zeroings is not None:
        return list(run.zeroings)
    # Records from before 2026-12 lack the table of zeros; all their gauge lengths are as printed.
    begun = {step.number: step.time for step in run.steps}
    return [
        Zeroing(time=begun[leaf.number], kinds=frozenset(leaf.step.tares))
        for leaf in unrolled(run.test.steps)
        if leaf.step.tares and leaf.number in begun
    ]


def measurements_of(run: RunReader) -> list[Measurement]:
    """Return the equilibria of a run along each driven axis, as one whole test, with the strain across where known."""
    name = str(run.provenance.get("name", run.path.parent.name))
    whole = whole_test(run.trace, run.size, zeroings_of(run), name)
    return with_strain_across(whole, run.trace, free=run.test.others == "free")


def with_strain_across(whole: Sequence[Measurement], trace: Trace, *, free: bool) -> list[Measurement]:
    """Return the measurements of a planar test with the strain of the other axis, where that is free to follow.

    It is known of an axis that has carriages of its own, and of a side of a periodic cell that nothing drives.
    """
    columns, strains = parted(trace).columns, {one.axis: one.strain for one in whole}
    found = []
    for one in whole:
        other = {"C": "W", "W": "C"}.get(one.axis, "")
        side = columns.get(f"cell_{other}")
        if other in strains and free and len(whole) == 2:
            found.append(replace(one, transverse=strains[other]))
        elif other not in strains and side is not None:
            found.append(replace(one, transverse=side / side[0] - 1.0))
        else:
            found.append(one)
    return found

"""Samples of a run's instruments, also of a run that was interrupted before its log was written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.records.results import zeroings_of
from app.schemas.machine_data import machines_of
from rigs.control.log_rate import stretches_of
from rigs.instruments.channels import measure
from rigs.machines.machine import instruments_on

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.records.reader import RunReader
    from rigs.instruments.samples import Table


def samples_of(run: RunReader) -> Mapping[str, Table]:
    """Return the samples of each instrument, up to the last row of an interrupted run; none without rows.

    Raises
    ------
    ProtocolError
        If the protocol of a run that was cut off is none of these machines.
    """
    if not run.going_on or not len(run.trace) or (run.logs and all(_whole(log, run) for log in run.logs.values())):
        return run.logs
    log, zeroings, stretches = run.test.log, zeroings_of(run), stretches_of(run.trace, run.test)
    return {
        instrument.name: measure(
            instrument, run.trace, seed=log.seed, noise=log.noise, zeroings=zeroings, stretches=stretches
        )
        for instrument in instruments_on(run.test, machines_of(run.test))
    }


def _whole(log: Table, run: RunReader) -> bool:
    """Return whether a log reaches the last row of its run, within one sample."""
    last = log.part(max(len(log) - 2, 0), len(log)).true_time
    return len(last) > 1 and float(run.trace.columns["time"][-1] - last[-1]) < 1.5 * float(last[-1] - last[0])

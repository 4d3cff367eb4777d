"""Samples of a run's instruments, also of a run that was interrupted before its log was written."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from app.records.folder import RECORD
from app.records.h5_read import reading
from app.records.layout import make_record
from app.records.measurements import zeroings_of
from app.records.stored_log import read_logs
from app.records.writer import RunWriter
from app.schemas.machine_data import machines_of
from rigs.control.log_rate import stretches_of
from rigs.instruments.channels import measured_parts
from rigs.jumps import jump_times
from rigs.machines.machine import instruments_on

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.records.reader import RunReader
    from rigs.instruments.samples import Table


@contextmanager
def samples_of(run: RunReader) -> Iterator[Mapping[str, Table]]:
    """Give the samples of each instrument, up to the last row of an interrupted run; none without rows.

    Those of an interrupted run are computed part by part into a file of their own, so that memory does not grow with
    them; it is there as long as the block runs.

    Raises
    ------
    ProtocolError
        If the protocol of a run that was cut off is none of these machines.
    """
    if not run.going_on or not len(run.trace) or (run.logs and all(_whole(log, run) for log in run.logs.values())):
        yield run.logs
        return
    protocol = run.test
    log, zeroings = protocol.log, zeroings_of(run)
    instruments = instruments_on(protocol, machines_of(protocol))
    with TemporaryDirectory(prefix="knitlab-") as folder:
        path = make_record(
            Path(folder) / RECORD,
            protocol=run.protocol,
            size=run.size,
            axes=run.trace.axes,
            strands=run.strands,
            instruments=instruments,
            provenance={},
        )
        with RunWriter(path) as writer:
            for instrument in instruments:
                for part in measured_parts(
                    instrument,
                    run.trace,
                    seed=log.seed,
                    noise=log.noise,
                    zeroings=zeroings,
                    stretches=stretches_of(run.trace, protocol),
                ):
                    writer.write_samples(part)
        with reading(path, "the samples of a run") as file:
            tags = [text.decode() for text in file["tags"][()]]
            logs = read_logs(path, file["channels"], tags, jump_times(run.trace))
        yield logs


def _whole(log: Table, run: RunReader) -> bool:
    """Return whether a log reaches the last row of its run, within one sample."""
    last = log.part(max(len(log) - 2, 0), len(log)).true_time
    return len(last) > 1 and float(run.trace.columns["time"][-1] - last[-1]) < 1.5 * float(last[-1] - last[0])

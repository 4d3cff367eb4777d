"""Sample a run that was killed before its instruments were: what they would have logged up to its last row."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.figures import zeroings_of
from app.rig_data import machines_of
from app.schemas import loads
from knitlab_core.errors import FormatError
from rigs.catalogue import arranged
from rigs.instruments import measure
from rigs.log_rate import stretches_of
from rigs.machine import instruments_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.run_reader import RunReader
    from rigs.samples import Table


def logs_up_to_the_end(run: RunReader) -> Mapping[str, Table]:
    """Return the logs of a run by instrument; those of one that was killed are taken of its rows.

    Raises
    ------
    FormatError
        If it was killed before its first row.
    """
    if not run.going_on:
        return run.logs
    if not len(run.trace):
        raise FormatError(run.path, 1, "the record of a run with rows: this one was killed before its first")
    protocol = loads(run.protocol, str(run.path), materials=run.materials).protocol
    data = machines_of(protocol)
    drives = arranged(protocol.rig, protocol.mount)
    driven = {name: [axis for axis, drive in drives.items() if drive.machine == name] for name in data}
    log, zeroings = protocol.log, zeroings_of(run, protocol)
    stretches = stretches_of(run.trace, protocol)
    return {
        one.name: measure(one, run.trace, seed=log.seed, noise=log.noise, zeroings=zeroings, stretches=stretches)
        for one in instruments_of(driven, data, log)
    }

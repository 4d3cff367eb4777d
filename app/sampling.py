"""Sample a run that was killed before its instruments were: what they would have logged up to its last row."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.check import fitted_machines
from app.figures import zeroings_of
from app.schemas import loads
from knitlab_core.errors import FormatError
from rigs.catalogue import arranged
from rigs.instruments import measure
from rigs.machine import instruments_of

if TYPE_CHECKING:
    from app.run_reader import RunReader
    from rigs.instruments import Samples


def samples_up_to_the_end(run: RunReader) -> dict[str, Samples]:
    """Return the samples of a run by instrument; those of one that was killed are taken of its rows.

    Raises
    ------
    FormatError
        If it was killed before its first row.
    """
    if not run.going_on:
        return run.samples
    if not len(run.trace):
        raise FormatError(run.path, 1, "the record of a run with rows: this one was killed before its first")
    loaded = loads(run.protocol, str(run.path), materials=run.materials)
    protocol, data = loaded.protocol, fitted_machines(loaded)
    drives = arranged(protocol.rig, protocol.mount)
    driven = {name: [axis for axis, drive in drives.items() if drive.machine == name] for name in data}
    log, zeroings = protocol.log, zeroings_of(run, protocol)
    return {
        one.name: measure(one, run.trace, seed=log.seed, noise=log.noise, zeroings=zeroings)
        for one in instruments_of(driven, data, log)
    }

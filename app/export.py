"""Export a run's log in the dialect of an instrument: a view of ``run.h5``, made again at any time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from app.rig_data import read_machine
from app.run_folder import write_whole
from knitlab_core.errors import SpecificationError
from rigs.logs.biotester import BIOTESTER, biotester_channels
from rigs.logs.bluehill import BLUEHILL_UNIVERSAL, PLACE, bluehill_channels
from rigs.logs.writer import write_log

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

    from app.run_reader import RunReader
    from rigs.catalogue import MachineName
    from rigs.instruments import Samples


class Log(NamedTuple):
    """Describe a log file: the machine that writes it, where it stands for a sample's name, its lines."""

    machine: MachineName
    place: str
    lines: Callable[[RunReader, Samples], Iterator[bytes]]


def _biotester(run: RunReader, samples: Samples) -> Iterator[bytes]:
    channels = biotester_channels(
        samples,
        run.size,
        set_name=str(run.provenance.get("name", "knitlab")),
        temperature=read_machine("biaxial-hook").convention.temperature.value,
    )
    return write_log(BIOTESTER, channels)


def _bluehill_universal(_: RunReader, samples: Samples) -> Iterator[bytes]:
    return write_log(BLUEHILL_UNIVERSAL, bluehill_channels(samples))


LOGS: Mapping[str, Log] = {
    "biotester": Log("biaxial-hook", "{sample}.csv", _biotester),
    "bluehill-universal": Log("uniaxial-frame", PLACE, _bluehill_universal),
}
"""The logs by their dialect; a machine's first is its default."""


def export_logs(run: RunReader, folder: Path, sample: str) -> tuple[Path, ...]:
    """Write the log of every instrument of a run in its own dialect, under the names that it gives its files."""
    written = []
    for machine in run.samples:
        dialect = next((name for name, log in LOGS.items() if log.machine == machine), None)
        if dialect is not None:
            written.append(export_log(run, folder / LOGS[dialect].place.format(sample=sample), dialect))
    return tuple(written)


def export_log(run: RunReader, path: Path, dialect: str) -> Path:
    """Write the log of one instrument of a run.

    Parameters
    ----------
    run : RunReader
        The run.
    path : Path
        Where the file shall stand; its folder is made.
    dialect : str
        One of `LOGS`.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    SpecificationError
        If the dialect is unknown, or the run has no log of its machine: it was cut off before it was sampled, or the
        machine was no part of its rig.
    """
    if dialect not in LOGS:
        raise SpecificationError("dialect", dialect, f"one of {', '.join(LOGS)}")
    log = LOGS[dialect]
    if log.machine not in run.samples:
        found = ", ".join(run.samples) or "none"
        raise SpecificationError("run.channels", found, f"a run on {log.machine} that was sampled to its end")
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_whole(path, log.lines(run, run.samples[log.machine]))

"""Export a run's log in the dialect of an instrument: a view of ``run.h5``, made again at any time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.rig_data import read_biaxial_data
from app.run_folder import write_whole
from knitlab_core.errors import SpecificationError
from rigs.logs.biotester import BIOTESTER, biotester_channels
from rigs.logs.writer import write_log

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

    from app.run_reader import RunReader


def _biotester(run: RunReader) -> Iterator[bytes]:
    if run.samples is None:
        raise SpecificationError("run.channels", 0, "a run that was sampled to its end")
    channels = biotester_channels(
        run.samples,
        run.size,
        set_name=str(run.provenance.get("name", "knitlab")),
        temperature=read_biaxial_data().convention.temperature.value,
    )
    return write_log(BIOTESTER, channels)


DIALECTS: Mapping[str, Callable[[RunReader], Iterator[bytes]]] = {"biotester": _biotester}


def export_log(run: RunReader, path: Path, dialect: str = "biotester") -> Path:
    """Write the log of a run.

    Parameters
    ----------
    run : RunReader
        The run.
    path : Path
        Where the file shall stand.
    dialect : str
        One of `DIALECTS`.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    SpecificationError
        If the dialect is unknown, or the run was cut off before it was sampled.
    """
    if dialect not in DIALECTS:
        raise SpecificationError("dialect", dialect, f"one of {', '.join(DIALECTS)}")
    return write_whole(path, DIALECTS[dialect](run))
